"""Data sets of many motions: a file a motion in any format, and formats of data sets."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from llsrbm.formats import FORMATS, Options, export
from llsrbm.formats.datasets.base import DatasetFormat
from llsrbm.motion.trajectory import Trajectory
from llsrbm.request.messages import look_up

_LEROBOT = "lerobot"


def find_dataset_format(name: str) -> DatasetFormat:
    """The format of that name: "lerobot", or one of `llsrbm formats`, a file or folder a motion.

    Raises:
        InputError: there is none, or packages that it needs are missing.
    """
    if name == _LEROBOT:
        from llsrbm.formats.datasets.lerobot import LEROBOT  # needs pyarrow

        return LEROBOT
    of_one = look_up("format of data sets", name, FORMATS, f"or {_LEROBOT}")
    of_one.check_installed()

    def write(trajectory: Trajectory, path: Path, options: Options) -> None:
        given = {name: value for name, value in asdict(options).items() if name in of_one.options}
        export(trajectory, path, format=of_one.name, **given)

    return DatasetFormat(
        name=of_one.name,
        folder="motions",
        suffix=of_one.suffix,
        write=write,
        options=of_one.options,
        defaults=of_one.defaults,
    )
