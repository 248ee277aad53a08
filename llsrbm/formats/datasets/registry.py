"""The formats of data sets that there are: every format of one motion, and those of their own."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from llsrbm.errors import InputError
from llsrbm.formats.base import Format, Options
from llsrbm.formats.datasets.base import DatasetFormat
from llsrbm.formats.datasets.lerobot import LEROBOT
from llsrbm.formats.exporting import export
from llsrbm.formats.registry import FORMATS
from llsrbm.motion.trajectory import Trajectory
from llsrbm.request.messages import look_up

OWN: dict[str, DatasetFormat] = {format_.name: format_ for format_ in (LEROBOT,)}


def find_dataset_format(name: str, kind: str) -> DatasetFormat:
    """The format of that name.

    Args:
        name: of `llsrbm formats`, or of `OWN`.
        kind: "plan" or "rollout", what it is to hold.

    Raises:
        InputError: there is none, it cannot hold that, or packages that it needs are missing.
    """
    if name in OWN:
        return OWN[name]
    of_one = look_up("format of data sets", name, FORMATS, f"or {', '.join(OWN)}")
    if kind not in of_one.holds:
        raise InputError(
            f'format "{name}" cannot hold a {kind}; expected --source {" or ".join(of_one.holds)}'
        )
    of_one.check_installed()
    return _of_files(of_one)


def _of_files(format_: Format) -> DatasetFormat:
    """A file, or a folder, for each motion."""

    def write(trajectory: Trajectory, path: Path, options: Options) -> None:
        given = {name: value for name, value in asdict(options).items() if name in format_.options}
        export(trajectory, path, format=format_.name, **given)

    return DatasetFormat(
        name=format_.name,
        folder="motions",
        suffix=format_.suffix,
        write=write,
        options=format_.options,
        defaults=format_.defaults,
    )
