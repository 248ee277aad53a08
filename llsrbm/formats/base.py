"""A file format: its options, the packages that it needs, and the JSON that stands beside files."""

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from enum import Enum
from importlib.util import find_spec
from math import isfinite
from pathlib import Path
from typing import Any

from llsrbm.errors import FileFormatError, InputError
from llsrbm.motion.robot import robot_of
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.trajectory import Trajectory, description, motion_description
from llsrbm.motion.whole_body import WholeBodyMotion, whole_body_motion
from llsrbm.request.messages import Flag, Number
from llsrbm.robots import Robot
from llsrbm.robots.drives.stated import stated_drives
from llsrbm.robots.drives.variants import driven
from llsrbm.text_files import parse_json, read_text

ORDERS = ("depth-first", "breadth-first")
_STATED = ("fps", "pad", "order", "packed")  # options that a description has
_SMALLEST, _LARGEST = 32, 4096  # pixels
_BESIDE = ".meta.json"  # after the whole name of the file that it is of
_LARGEST_JSON = 1024**2  # bytes; ours have some ten thousand

Written = Trajectory | WholeBodyMotion


@dataclass(frozen=True)
class Options:
    """Options of an export; a format takes those that it names.

    Attributes:
        fps: frames/s.
        pad: s of standing still before the motion and after it.
        order: of bodies and joints, one of `ORDERS`.
        size: width and height of a picture, pixels.
        camera: azimuth, elevation (deg) and distance (m) from which the robot is looked at; None:
            as the page does.
        packed: whether the messages themselves are written beside a table of their numbers.

    Raises:
        InputError: a value of another type, or an order, a size or a camera that makes no sense;
            rates are checked where used.
    """

    fps: float = 60.0
    pad: float = 0.0
    order: str = ORDERS[0]
    size: tuple[int, int] = (960, 540)
    camera: tuple[float, float, float] | None = None
    packed: bool = False

    def __post_init__(self) -> None:
        for name, spec in (("fps", Number("")), ("pad", Number("")), ("packed", Flag(""))):
            object.__setattr__(self, name, spec.checked(name, getattr(self, name)))
        if self.order not in ORDERS:
            raise InputError(f"order: expected {' or '.join(ORDERS)}, got {self.order!r}")
        size, camera = self.size, self.camera
        if not _numbers(size, 2, int) or not all(_SMALLEST <= n <= _LARGEST for n in size):
            raise InputError(
                f"size: expected width and height, {_SMALLEST} to {_LARGEST} pixels, got {size!r}"
            )
        if camera is not None and not (
            _numbers(camera, 3, float | int) and -90 <= camera[1] <= 90 and camera[2] > 0
        ):
            raise InputError(
                "camera: expected azimuth and elevation (-90 to 90) in deg and a distance > 0 in "
                f"m, got {camera!r}"
            )


@dataclass(frozen=True)
class Extra:
    """Modules that must be importable; `pip install "llsrbm[name]"` installs them."""

    name: str
    modules: tuple[str, ...]

    @property
    def missing(self) -> bool:
        """True if one of the modules is not installed."""
        return any(find_spec(module) is None for module in self.modules)


class Purpose(Enum):
    """The purposes of formats, in the order of their lists; the value is the heading there."""

    SIMULATION = "For simulation"
    LEARNING = "For learning"
    ROBOT = "For the robot"
    LOOKING = "To look at"


@dataclass(frozen=True)
class Format:
    """One file format.

    Attributes:
        name: as on the command line; title: one line, which says what a file is and who reads it.
        purpose: what files are written for.
        suffix: of file names, with the dot; "" of a folder.
        write: (trajectory, path, options) -> None, writes the file or folder at exactly that path,
            and further files beside it under names that begin with its name. Raises `InputError`
            if it cannot. Nobody sees the path before everything has been written.
        write_motion: the same of a motion at its own rate, which is neither a plan nor a rollout;
            None: it is not for these.
        write_many: ((name, trajectory), ..., folder, options) -> None, writes a file `NAME` of each
            into a folder, and once what they share; None: there is no such way.
        conventions: frames, units and orders, in a few lines.
        options: names of what it takes of `Options`; defaults: theirs.
        extra: packages that it needs; None: none. machine: raises `InputError` where it cannot be
            written on this machine, fits: where it cannot be written of a robot; None: of any.
        read: (path, robot, frames/s) -> motion, for formats that can be opened for looking; raises
            `FileFormatError`. The rate is for files without one of their own.
        recognises: path -> whether a file looks like one that `read` opens; raises nothing.
    """

    name: str
    title: str
    purpose: Purpose
    suffix: str
    write: Callable[[Trajectory, Path, Options], None]
    conventions: str
    write_motion: Callable[[WholeBodyMotion, Path, Options], None] | None = None
    write_many: Callable[[Iterable[tuple[str, Trajectory]], Path, Options], None] | None = None
    options: tuple[str, ...] = ()
    defaults: Options = field(default_factory=Options)
    extra: Extra | None = None
    machine: Callable[[], object] = lambda: None
    fits: Callable[[Robot], object] | None = None
    read: Callable[[Path, Robot, float | None], WholeBodyMotion] | None = None
    recognises: Callable[[Path], bool] = lambda _: False

    @property
    def tag(self) -> str:
        """The format in names of files, "unitree" or "gmr"; "" where the extension tells it."""
        extension = self.suffix.removeprefix(".")
        if extension == self.name or "." in extension:
            return ""
        return self.name.removesuffix(f"-{extension}")

    def check_installed(self) -> None:
        """Raise `InputError` if packages that it needs are missing."""
        if self.extra is not None and self.extra.missing:
            raise InputError(
                f'format "{self.name}" needs packages that are not installed; expected '
                f'pip install "llsrbm[{self.extra.name}]"'
            )

    def described(self, motion: Written, options: Options, **own: Any) -> dict[str, Any]:
        """Description of what is exported as plain data; `own`: orders, columns and so on."""
        taken = {name: getattr(options, name) for name in self.options if name in _STATED}
        if isinstance(motion, WholeBodyMotion):
            drives, of_it = stated_drives(motion.robot), motion_description(motion)
        else:
            drives, of_it = stated_drives(driven_robot(motion)), description(motion)
        return {"format": self.name, **taken, **own, "drives": drives, **of_it}

    def described_json(self, motion: Written, options: Options, **own: Any) -> str:
        """The same as JSON."""
        return json.dumps(self.described(motion, options, **own), allow_nan=False)

    def write_beside(self, path: Path, motion: Written, options: Options, **own: Any) -> None:
        """Write `described` beside `path`, under its name and `.meta.json`."""
        text = json.dumps(self.described(motion, options, **own), indent=1, allow_nan=False)
        path.with_name(path.name + _BESIDE).write_text(text + "\n", encoding="utf-8")


def frames_of(motion: Written, options: Options) -> WholeBodyMotion:
    """Evenly spaced frames to write: of a plan or a rollout as the options have it, of a motion its
    own. Raises `InputError`: as `llsrbm.motion.whole_body.whole_body_motion`.
    """
    if isinstance(motion, WholeBodyMotion):
        return motion
    return whole_body_motion(motion, options.fps, options.pad)


def driven_robot(trajectory: Trajectory) -> Robot:
    """The robot of a motion as it is now, with ideal drives where it was simulated with these."""
    robot = robot_of(trajectory)
    return driven(robot, trajectory.scenario.drives) if isinstance(trajectory, Rollout) else robot


def joints_beside(beside: dict[str, Any], path: Path) -> list[str] | None:
    """Names of a file's joints, as what is beside it has them; None: it does not say.

    Raises `FileFormatError`: they are no names.
    """
    names = beside.get("joint_order")
    if "joint_order" not in beside:
        return None
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise FileFormatError(f"{path}{_BESIDE}: joint_order: expected a list of names")
    return names


def read_beside(path: Path) -> dict[str, Any]:
    """The JSON beside a file; nothing where there is none. Raises `FileFormatError`: there is one,
    and it is unreadable or no JSON object.
    """
    beside = path.with_name(path.name + _BESIDE)
    if not beside.exists():
        return {}
    table = parse_json(read_text(beside, "a JSON object", _LARGEST_JSON), str(beside))
    if not isinstance(table, dict):
        raise FileFormatError(f"{beside}: expected a JSON object")
    return table


def _numbers(values: Any, count: int, kind: Any) -> bool:
    return (
        isinstance(values, Sequence)
        and len(values) == count
        and all(isinstance(n, kind) and isfinite(n) for n in values)
    )
