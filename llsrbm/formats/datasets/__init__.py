"""Data sets of many motions: a file a motion in any format, and formats of data sets."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import NamedTuple

from llsrbm.formats import FORMATS, Options, export
from llsrbm.motion.trajectory import Trajectory
from llsrbm.request.messages import look_up

_LEROBOT = "lerobot"


class Episode(NamedTuple):
    """The file of one motion, and its task in words: the same words for the same request."""

    file: Path
    task: str


@dataclass(frozen=True)
class DatasetFormat:
    """One format of many motions.

    Attributes:
        name: as on the command line.
        folder: of the data set, that files of single motions are written to.
        suffix: of those files, with the dot; "" where each is a folder.
        write: (trajectory, path, options) -> None, writes one motion at exactly that path, whole or
            not at all. Raises `InputError` if it cannot.
        options: names of what it takes of `Options`; defaults: what it takes of others.
        check: raises `InputError` for options that it cannot take.
        finish: (data set's folder, episodes, options) -> None, once all files are there: writes
            what is about all of them. The files may be gone after that.
        one_robot: whether all motions must be of the same robot.
        finished: of the data set, the file that is there once `finish` is through.
    """

    name: str
    folder: str
    suffix: str
    write: Callable[[Trajectory, Path, Options], None]
    options: tuple[str, ...] = ()
    defaults: Options = field(default_factory=Options)
    check: Callable[[Options], None] | None = None
    finish: Callable[[Path, Sequence[Episode], Options], None] | None = None
    one_robot: bool = False
    finished: str | None = None


def find_dataset_format(name: str) -> DatasetFormat:
    """The format of that name: "lerobot", or one of `llsrbm formats`, a file or folder a motion.
    Raises `InputError`: there is none, or packages that it needs are missing.
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
