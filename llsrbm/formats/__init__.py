"""Files that other tools read, and foreign files that can be looked at: open and write any of them.

Adding a format is one declaration and one line in `_formats`; another package registers its own as
an entry point `llsrbm.formats`.
"""

import tempfile
import zipfile
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import numpy as np

from llsrbm.errors import FileFormatError, InputError, printable
from llsrbm.files.atomic import staged
from llsrbm.files.npz import keys
from llsrbm.formats import plausibility
from llsrbm.formats.base import ORDERS, Format, Options, Purpose, Written
from llsrbm.formats.logs import MCAP, RRD
from llsrbm.formats.motion_npz import MOTION_NPZ
from llsrbm.formats.mujoco.folder import MUJOCO
from llsrbm.formats.native import DESIGN, NPZ
from llsrbm.formats.pictures.video import GIF, MP4
from llsrbm.formats.table import CSV
from llsrbm.formats.trainers import GMR_PKL, MIMICKIT_PKL, MOTION_IMITATION_JSON
from llsrbm.formats.unitree_csv import UNITREE_CSV
from llsrbm.formats.wire import LOWCMD, ODRI_CSV, QUAD_SDK_CSV, ROS2_BAG
from llsrbm.look.titles import file_words
from llsrbm.motion.plan import Plan
from llsrbm.motion.robot import robot_of
from llsrbm.motion.trajectory import Trajectory, load
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.request.messages import check_kind, look_up
from llsrbm.robots import Robot, load_robot
from llsrbm.text_files import path_of

__all__ = ["FORMATS", "ORDERS", "Format", "Options", "Purpose", "export", "file_name", "find"]
__all__ += ["availability", "by_purpose", "is_native", "load_any", "load_motion", "readable"]
__all__ += ["check_motion_format", "export_many", "remarks_of"]

_GROUP = "llsrbm.formats"  # entry points
_KEYS_NAMED = 12  # keys of an archive that a message names
_ANY_MOTION = (
    "; of any tool's motion an npz can be made, with qpos (K, 7 + joints: position, quaternion "
    "w x y z, joints), fps and joint_names"
)


FORMATS: dict[str, Format]  # by their names


@cache
def _formats() -> dict[str, Format]:
    """All formats in the order in which they are listed and offered: by what they are for.

    Those of other packages, and of the application, which the library never imports, are found at
    the first use: their modules import this one.
    """
    registered = [point.load() for point in sorted(entry_points(group=_GROUP))]
    found = (
        *(NPZ, MUJOCO, DESIGN, UNITREE_CSV, MOTION_NPZ, MIMICKIT_PKL, GMR_PKL),
        *(MOTION_IMITATION_JSON, LOWCMD, ODRI_CSV, QUAD_SDK_CSV, ROS2_BAG),
        *(*registered, CSV, MP4, GIF, MCAP, RRD),
    )
    return {each.name: each for purpose in Purpose for each in found if each.purpose is purpose}


def __getattr__(name: str) -> Any:
    if name == "FORMATS":
        return _formats()
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def find(name: str) -> Format:
    """The format of that name; raises `InputError` if there is none."""
    return look_up("format", name, _formats())


def by_purpose() -> dict[Purpose, list[Format]]:
    """All formats by what their files are for, in the order in which to list them."""
    return {
        purpose: [each for each in _formats().values() if each.purpose is purpose]
        for purpose in Purpose
    }


def availability(format_: Format, robot: Robot | None = None) -> str:
    """Why files of a format cannot be written here, of this robot; "" if they can."""
    if format_.extra is not None and format_.extra.missing:
        return f'not installed: pip install "llsrbm[{format_.extra.name}]"'
    try:
        format_.machine()
        if robot is not None and format_.fits is not None:
            format_.fits(robot)
    except InputError as error:
        words = str(error).removeprefix(f"{robot.path}: " if robot else "")
        return words.removeprefix(f'format "{format_.name}": ').partition(";")[0]
    return ""


# ---- opening


def load_motion(
    path: str | Path,
    robot: str = "anymal",
    format: str | None = None,  # noqa: A002  # the word of the public interface
    fps: float | None = None,
) -> WholeBodyMotion:
    """Open a file that holds a robot's motion, this project's or another tool's.

    Args:
        path: a native file of a plan or a rollout, or a file in a format that can be opened.
        robot: name or robot file of what moves; a native file knows its own.
        format: its name in `llsrbm formats`; None: as the file looks.
        fps: frames/s of a file without a rate of its own; of a native file, at which it is sampled
            (None: 60).

    Raises:
        FileFormatError: no such file, a damaged one, or one that no format recognises.
        InputError: no such format, or none that can be opened.
        RobotFileError: no such robot, or a wrong robot file.
    """
    path = path_of(path)
    chosen = _recognised(path) if format is None else find(format)
    if chosen.read is None:
        raise InputError(
            f'format "{chosen.name}" is written and not opened; expected {_openable()}'
        )
    return chosen.read(path, load_robot(robot), fps)


def load_any(
    path: str | Path, robot: str = "anymal", fps: float | None = None
) -> Trajectory | WholeBodyMotion:
    """A plan or a rollout of this project's, or the motion in another tool's file.

    Arguments and errors as of `load_motion`.
    """
    return load(path) if is_native(path) else load_motion(path, robot, fps=fps)


def remarks_of(motion: Trajectory | WholeBodyMotion) -> tuple[str, ...]:
    """Sentences on what a motion's numbers cannot mean: see `llsrbm.formats.plausibility`."""
    if isinstance(motion, WholeBodyMotion):
        return motion.remarks
    robot = robot_of(motion)
    if sorted(motion.joint_names) != sorted(robot.joint_names):
        return ()  # another robot by now, which whatever is made of it says
    order = [motion.joint_names.index(name) for name in robot.joint_names]
    joints = motion.joint_position[:, order]
    states = np.hstack([motion.base_position, motion.base_quat, joints])
    return plausibility.remarks(robot, motion.time, states)


def is_native(path: str | Path) -> bool:
    """True if a file is of this project's kind, damaged or not."""
    held = keys(path)
    # `load` says best what is wrong with an archive that cannot be listed.
    return "schema" in held or (not held and Path(path).suffix.lower() == ".npz")


def readable() -> tuple[Format, ...]:
    """The formats that can be opened."""
    return tuple(each for each in _formats().values() if each.read is not None)


def _recognised(path: Path) -> Format:
    try:
        if not path.is_dir():
            path.open("rb").close()
    except (OSError, ValueError) as error:  # ValueError: a name that no file can have
        reason = getattr(error, "strerror", None) or error
        raise FileFormatError(
            f"{printable(str(path), 300)}: cannot be read: {reason}; expected {_openable()}"
        ) from error
    for each in readable():
        if each.recognises(path):
            return each
    raise FileFormatError(f"{path}: {_is_none(path)}; expected {_openable()}{_ANY_MOTION}")


def _is_none(path: Path) -> str:
    """Why a file is none that can be opened, for a message."""
    if held := sorted(keys(path)):
        more = f" and {len(held) - _KEYS_NAMED} more" if len(held) > _KEYS_NAMED else ""
        listed = printable(", ".join(held[:_KEYS_NAMED]), 200)
        return f"not a file that can be opened, as it has the keys {listed}{more}"
    return "damaged, or not a file that can be opened"


def _openable() -> str:
    *first, last = (f"{each.name} ({each.suffix or 'a folder'})" for each in readable())
    return f"{', '.join(first)} or {last}"


# ---- writing: nobody ever sees half a file


def export(
    trajectory: Written,
    path: str | Path,
    format: str | Sequence[str] = "npz",  # noqa: A002  # the word of the public interface
    **options: Any,
) -> None:
    """Write a trajectory to a file, or in several formats into a zip.

    Args:
        trajectory: what `llsrbm.plan`, `llsrbm.simulate` or `llsrbm.load` returned; in a trainer's
            format also a motion, of `llsrbm.load_motion` or `llsrbm.repair_clip`.
        path: the file, or the folder of a format that is one; replaced when all has been written.
            A path that ends in ".zip" gets an archive of all that is written.
        format: a name, or several, of `llsrbm formats`.
        options: of `llsrbm.formats.Options`, as far as the formats take them: `fps`, `pad`,
            `order`, `size`, `camera`, `packed`. A motion has its own rate and is not padded.

    Raises:
        InputError: no such format, or one whose packages are missing or that takes no such option,
            or no motion; a value that makes no sense; a file that cannot be written. Nothing is
            left behind.
    """
    check_kind("trajectory", trajectory, Written, "a Plan, a Rollout or a WholeBodyMotion")
    check_kind("format", format, str | Iterable, "a name or several")
    names = [format] if isinstance(format, str) else format
    formats = list({each.name: each for each in map(find, names)}.values())
    if not formats:
        raise InputError("no format is named; expected one or more of `llsrbm formats`")
    _check_used(formats, options)
    if isinstance(trajectory, WholeBodyMotion):
        options = _of_motion(trajectory, formats, options)
    chosen = [(each, _options(each, options)) for each in formats]
    for each in formats:
        each.check_installed()
        if each.fits is not None and not isinstance(trajectory, WholeBodyMotion):
            each.fits(load_robot(trajectory.jump.robot))
    path = path_of(path)
    zipped = path.suffix.lower() == ".zip"
    if len(formats) > 1 and not zipped:
        raise InputError(
            f"{path}: {len(formats)} formats do not fit into one file; expected a path that ends "
            "in .zip"
        )
    with staged(path) as target:
        if zipped:
            _write_zip(trajectory, chosen, target)
        else:
            _write(trajectory, target, *chosen[0])


def _of_motion(
    motion: WholeBodyMotion, formats: Sequence[Format], given: dict[str, Any]
) -> dict[str, Any]:
    """Options with which a motion is written; raises `InputError`: it cannot be."""
    for each in formats:
        check_motion_format(each.name)
    for name in ("fps", "pad"):
        if name in given:
            raise InputError(f"{name}: is not for a motion, which is written frame by frame")
    if motion.fps is None:
        raise InputError("the motion's frames are not evenly spaced; expected one rate")
    return given | {"fps": motion.fps}


def check_motion_format(name: str) -> None:
    """Raise `InputError` unless there is a format of that name that motions can be written in."""
    if find(name).write_motion is None:
        able = ", ".join(name for name, each in _formats().items() if each.write_motion)
        raise InputError(
            f'format "{name}" is of plans and simulations; of a motion expected {able}'
        )


def _write(written: Written, path: Path, format_: Format, options: Options) -> None:
    if not isinstance(written, WholeBodyMotion):
        format_.write(written, path, options)
    elif format_.write_motion is not None:
        format_.write_motion(written, path, options)


def export_many(
    trajectories: Iterable[tuple[str, Trajectory]],
    folder: str | Path,
    format: str,  # noqa: A002  # the word of the public interface
    **options: Any,
) -> None:
    """Write files of many trajectories, (name, trajectory), that share what they have in common.

    `folder`: is made; options: as of `export`.

    Raises:
        InputError: no such format, one whose files share nothing, or as of `export`.
    """
    found = find(format)
    if found.write_many is None:
        shares = ", ".join(name for name, each in _formats().items() if each.write_many)
        raise InputError(
            f'format "{format}": its files have nothing in common; expected {shares or "none"}'
        )
    _check_used([found], options)
    found.check_installed()
    found.write_many(trajectories, Path(folder), _options(found, options))


def file_name(trajectory: Trajectory, names: Sequence[str], *, zipped: bool = False) -> str:
    """A name for an export as one file: robot, request, and the format where it needs saying.

    "anymal_twist90.npz" of a plan, "anymal_twist90_simulated_unitree.csv" of a simulation.
    """
    formats = [find(name) for name in names]
    if len(formats) > 1:
        return f"{_stem(trajectory)}.zip"
    (format_,) = formats
    name = _own_name(trajectory, format_)
    return name if format_.suffix and not zipped else f"{name.removesuffix(format_.suffix)}.zip"


def _stem(trajectory: Written) -> str:
    if isinstance(trajectory, WholeBodyMotion):
        return f"{trajectory.robot.name}_motion"
    jump = trajectory.jump
    kind = [] if isinstance(trajectory, Plan) else ["simulated"]
    return "_".join((Path(jump.robot).stem, file_words(jump), *kind))


def _own_name(trajectory: Written, format_: Format) -> str:
    """The name of a file or folder of a format."""
    tag = f"_{format_.tag}" if format_.tag else ""
    return f"{_stem(trajectory)}{tag}{format_.suffix}"


def _write_zip(trajectory: Written, chosen: Sequence[tuple[Format, Options]], target: Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        for format_, options in chosen:
            name = _own_name(trajectory, format_)
            _write(trajectory, Path(folder) / name, format_, options)
        with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in sorted(Path(folder).rglob("*")):
                if file.is_file():
                    archive.write(file, file.relative_to(folder))


def _options(format_: Format, given: dict[str, Any]) -> Options:
    known = Options.__dataclass_fields__
    for name in given:
        if name not in known:
            raise InputError(f"no option {name} of an export; expected {', '.join(known)}")
    return replace(format_.defaults, **{n: v for n, v in given.items() if n in format_.options})


def _check_used(formats: Sequence[Format], given: dict[str, Any]) -> None:
    """An option that none of the formats takes would be ignored in silence."""
    for name in given:
        if not any(name in each.options for each in formats):
            taken = sorted({option for each in formats for option in each.options})
            listed = f"its options are {', '.join(taken)}" if taken else "it has no options"
            names = ", ".join(each.name for each in formats)
            raise InputError(f'{name}: is not for format "{names}"; {listed}')
