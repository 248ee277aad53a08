"""A file format, its options, and packages that it needs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from math import isfinite
from pathlib import Path
from typing import Any

from llsrbm.errors import InputError
from llsrbm.motion.trajectory import Trajectory
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.robots import Robot

ORDERS = ("depth-first", "breadth-first")
_SMALLEST, _LARGEST = 32, 4096  # pixels


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

    Raises:
        InputError: an order, a size or a camera that makes no sense.
    """

    fps: float = 60.0
    pad: float = 0.0
    order: str = ORDERS[0]
    size: tuple[int, int] = (960, 540)
    camera: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        """Check what is the same for every format; rates are checked where they are used."""
        if self.order not in ORDERS:
            raise InputError(f"order: expected {' or '.join(ORDERS)}, got {self.order!r}")
        if not _numbers(self.size, 2, int) or not all(
            _SMALLEST <= n <= _LARGEST for n in self.size
        ):
            raise InputError(
                f"size: expected width and height, {_SMALLEST} to {_LARGEST} pixels, got "
                f"{self.size!r}"
            )
        if self.camera is not None and (
            not _numbers(self.camera, 3, float | int)
            or not -90 <= self.camera[1] <= 90
            or not self.camera[2] > 0
        ):
            raise InputError(
                "camera: expected azimuth and elevation (-90 to 90) in deg and a distance > 0 in "
                f"m, got {self.camera!r}"
            )


@dataclass(frozen=True)
class Extra:
    """Packages that a format needs and a plain installation does not have.

    Attributes:
        name: as in `pip install "llsrbm[name]"`.
        modules: what must be importable.
    """

    name: str
    modules: tuple[str, ...]

    @property
    def missing(self) -> bool:
        """True if one of the modules is not installed."""
        return any(find_spec(module) is None for module in self.modules)


@dataclass(frozen=True)
class Format:
    """One file format.

    Attributes:
        name: as on the command line.
        title: one line.
        suffix: of file names, with the dot; "" of a folder.
        write: (trajectory, path, options) -> None, writes the file or folder at exactly that path,
            and further files beside it under names that begin with its name. Raises `InputError`
            if it cannot. Nobody sees the path before everything has been written.
        conventions: frames, units and orders, in a few lines: the module's docstring.
        options: names of what it takes of `Options`; defaults: what it takes where nothing is said.
        holds: of "plan" and "rollout", what it can hold.
        extra: packages that it needs; None: none.
        read: (path, robot, frames/s) -> motion, for formats that can be opened for looking; raises
            `FileFormatError`. The rate is for files that do not say theirs; what the file says
            counts.
        recognises: path -> whether a file looks like one that `read` opens, by its name and a
            glance at its content; raises nothing. Every format with `read` has it.
    """

    name: str
    title: str
    suffix: str
    write: Callable[[Trajectory, Path, Options], None]
    conventions: str
    options: tuple[str, ...] = ()
    defaults: Options = field(default_factory=Options)
    holds: tuple[str, ...] = ("plan", "rollout")
    extra: Extra | None = None
    read: Callable[[Path, Robot, float | None], WholeBodyMotion] | None = None
    recognises: Callable[[Path], bool] | None = None

    def check_installed(self) -> None:
        """Raise `InputError` if packages that it needs are missing."""
        if self.extra is not None and self.extra.missing:
            raise InputError(
                f'format "{self.name}" needs packages that are not installed; expected '
                f'pip install "llsrbm[{self.extra.name}]"'
            )


def _numbers(values: Any, count: int, kind: Any) -> bool:
    return (
        isinstance(values, Sequence)
        and len(values) == count
        and all(isinstance(n, kind) and isfinite(n) for n in values)
    )
