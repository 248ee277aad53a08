"""Content of a visitor's file: a design, a plan, a simulation, or another tool's motion.

Files are read, checked and drawn for a trial here, in a process where a bad one can do no harm to
other tabs; any tab can then show the result, in some tens of milliseconds.
"""

import logging
import math
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from app.workers.opened_file import OpenedFile, States, check_offered, uploaded_design
from llsrbm.arrays import Array
from llsrbm.errors import Error, FileFormatError, printable
from llsrbm.formats import is_native, load_motion, readable
from llsrbm.motion.plan import Plan
from llsrbm.motion.robot import robot_of
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.trajectory import load
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.request.design import LARGEST as LARGEST_DESIGN
from llsrbm.request.design import SUFFIX, Design
from llsrbm.robots import Robot, load_robot

LARGEST_UNPACKED = 32 * 1024**2
"""Bytes of a native file's arrays; a simulation of 10 s at 1 kHz has half of it."""

MOST_GROWTH = 400 * 1024**2
"""Bytes by which a process may grow while it reads a file; text takes ten times its size."""

LONGEST = 60.0  # s of motion
MOST_INSTANTS = 20_000

UNFORESEEN = "cannot be opened"  # In the message about a file with a fault that no check foresees

_SHORTEST_STEP = 1e-6  # s
_LARGEST_VALUE = 1e7  # of any number that is drawn or plotted, in its SI unit
_FARTHEST = 1000.0  # m
_SAME = 1e-6  # relative; numbers of a robot that were computed anew differ in their last digits
_SHOWN_NAME = 80  # characters
_NEEDED = ("mass", "inertia")  # of a robot's numbers, for the panel's figures
_SUFFIXES = {".json", ".zip"} | {each.suffix for each in readable()}

_log = logging.getLogger(__name__)


def open_file(name: str, content: bytes, robot: str, fps: float | None = None) -> OpenedFile:
    """Read a visitor's file, or raise `Error`; `robot` and `fps` (1/s): if it has none."""
    shown = printable(name, _SHOWN_NAME)
    suffix = Path(name).suffix.lower()
    with tempfile.TemporaryDirectory() as folder:
        # A name of ours: a visitor's may be anything.
        path = Path(folder) / f"motion{suffix if suffix in _SUFFIXES else ''}"
        try:
            path.write_bytes(content)
            # Numbers that make no sense are refused in words.
            with growing_by(MOST_GROWTH), np.errstate(all="ignore"):
                if _is_design(name, path):
                    return OpenedFile(shown, uploaded_design(name, content))
                opened = _opened(path, shown, robot, fps)
                _rehearse(opened)
                return opened
        except Error as error:
            raise FileFormatError(_line(str(error).replace(str(path), shown))) from error
        except MemoryError as error:
            raise FileFormatError(
                f"{shown}: reading it takes more than {MOST_GROWTH >> 20} MB of memory"
            ) from error
        except Exception as error:  # whatever a made-up file leads to; the process shall go on
            _log.info("%s cannot be opened", shown, exc_info=True)
            raise FileFormatError(
                f"{shown}: {UNFORESEEN} ({type(error).__name__}: {printable(_line(str(error)))})"
            ) from error


@contextmanager
def growing_by(most: int) -> Iterator[None]:
    """Have what would make the process larger by so many bytes fail with `MemoryError` (Linux)."""
    try:
        import resource
    except ImportError:  # Windows
        yield
        return
    before = resource.getrlimit(resource.RLIMIT_DATA)
    with suppress(OSError, ValueError):  # elsewhere, or the limit is lower already
        pages = int(Path("/proc/self/statm").read_text("ascii").split()[5])
        resource.setrlimit(resource.RLIMIT_DATA, (pages * resource.getpagesize() + most, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, before)


def _is_design(name: str, path: Path) -> bool:
    with path.open("rb") as file:
        head = file.read(LARGEST_DESIGN)
    if name.lower().endswith(SUFFIX) or b'"llsrbm.design' in head:
        return True
    may_be = not head.startswith(b"PK") and Path(name).suffix.lower() in (".json", "")
    return may_be and not any(each.recognises(path) for each in readable())


def _opened(path: Path, shown: str, robot: str, fps: float | None) -> OpenedFile:
    if not is_native(path):
        motion = load_motion(path, robot, fps=fps)
        _check_motion(motion, shown)
        return OpenedFile(shown, States.of(motion, robot), motion.remarks)
    holds = load(path, largest=LARGEST_UNPACKED)
    _check_native(holds, shown)
    remarks = _remarks(holds)
    return OpenedFile(shown, _without_solution(holds) if remarks else holds, remarks)


# ---- native files


def _check_native(motion: Plan | Rollout, shown: str) -> None:
    """Raise `FileFormatError` unless it is a motion of the robot that is small enough to draw."""
    # Before anything looks for a robot by that name: it may be the path of a file.
    check_offered(motion.jump, f"{shown}: request")
    name = motion.robot_parameters.get("name", motion.jump.robot)
    if name != motion.jump.robot:
        raise FileFormatError(
            f"{shown}: robot_parameters.name: expected {motion.jump.robot}, got {name!r:.80}"
        )
    missing = [key for key in _NEEDED if key not in motion.robot_parameters]
    if missing:
        raise FileFormatError(f"{shown}: robot_parameters: {', '.join(missing)} missing")
    robot = load_robot(motion.jump.robot)
    joints, feet = sorted(motion.joint_names), motion.foot_position.shape[1]
    if joints != sorted(robot.joint_names) or feet != len(robot.legs):
        raise FileFormatError(
            f"{shown}: a robot with {len(joints)} joints ({', '.join(joints):.60}) and {feet} feet "
            f"as {robot.name}; expected its {len(robot.joint_names)} joints and "
            f"{len(robot.legs)} feet"
        )
    _check_extent(motion.time, shown)
    _check_numbers(motion, shown)
    if isinstance(motion, Plan):
        contacts = len(robot.legs) * len(robot.corners)
        if motion.contact_point.shape[1] != contacts:
            raise FileFormatError(
                f"{shown}: {motion.contact_point.shape[1]} contact points; expected {contacts}"
            )
    else:
        _check_native(motion.plan, shown)


def _check_motion(motion: WholeBodyMotion, shown: str) -> None:
    _check_extent(motion.time, shown)
    _check_numbers(motion, shown)


def _check_extent(time: Array, shown: str) -> None:
    if len(time) > MOST_INSTANTS or not time[-1] - time[0] <= LONGEST:
        raise FileFormatError(
            f"{shown}: {len(time)} instants in {time[-1] - time[0]:.4g} s; at most {MOST_INSTANTS} "
            f"in {LONGEST:g} s can be shown"
        )
    if not (np.diff(time) >= _SHORTEST_STEP).all():
        raise FileFormatError(f"{shown}: time: expected steps of {_SHORTEST_STEP:g} s or more")


def _check_numbers(motion: Plan | Rollout | WholeBodyMotion, shown: str) -> None:
    for name, values in ((field.name, getattr(motion, field.name)) for field in fields(motion)):
        if not isinstance(values, np.ndarray) or values.dtype.kind != "f":
            continue
        largest = float(np.abs(values).max(initial=0.0))
        limit = _FARTHEST if name in ("com", "base_position", "foot_position") else _LARGEST_VALUE
        if not largest <= limit:
            raise FileFormatError(
                f"{shown}: {name}: expected numbers up to {limit:g}, got {largest:.4g}"
            )
    moments = np.linalg.eigvalsh(motion.inertia)
    if not (moments > 0).all():
        raise FileFormatError(
            f"{shown}: inertia: expected positive moments, got {moments.min():.4g} kg m2"
        )


# ---- the robot as it is now


def _remarks(motion: Plan | Rollout) -> tuple[str, ...]:
    robot = robot_of(motion)
    of = [motion.robot_parameters]
    if isinstance(motion, Rollout):
        of.append(motion.plan.robot_parameters)
    now = robot.parameters()
    names = sorted({name for parameters in of for name in differing(parameters, now)})
    if not names:
        return ()
    listed = ", ".join(names)
    return (
        f"It was made with another {robot.name} ({listed:.120}); drawn is the robot as it is now.",
    )


def differing(one: Mapping[str, Any], other: Mapping[str, Any]) -> list[str]:
    """Names of the numbers of two robots that are not the same, `limits.torque` for example."""
    names = []
    for name in sorted({*one, *other}):
        a, b = one.get(name), other.get(name)
        if isinstance(a, Mapping) and isinstance(b, Mapping):
            inner = sorted({*a, *b})
            names += [f"{name}.{i}" for i in inner if not _agree(a.get(i), b.get(i))]
        elif not _agree(a, b):
            names.append(name)
    return [printable(name) for name in names]


def _agree(a: Any, b: Any) -> bool:
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(_agree(a[key], b[key]) for key in a)
    if isinstance(a, list | tuple) and isinstance(b, list | tuple):
        return len(a) == len(b) and all(map(_agree, a, b))
    numbers = isinstance(a, int | float) and isinstance(b, int | float)
    if numbers and not isinstance(a, bool) and not isinstance(b, bool):
        return math.isclose(a, b, rel_tol=_SAME, abs_tol=1e-9)
    return bool(a == b)


def _without_solution(motion: Plan | Rollout) -> Plan | Rollout:
    """The motion without its solver's iterate, which another robot's planner cannot start from."""
    if isinstance(motion, Plan):
        return replace(motion, solution=None)
    return replace(motion, plan=replace(motion.plan, solution=None))


# ---- a trial


def _rehearse(opened: OpenedFile) -> None:
    """Do all that a tab will do with it, so that anything that goes wrong goes wrong here."""
    match opened.holds:
        case Plan() as plan:
            _show(plan, None, load_robot(opened.robot))
        case Rollout() as rollout:
            _show(rollout.plan, rollout, load_robot(opened.robot))
        case States() as states:
            _show_alone(opened.name, states.motion())


def _show(plan: Plan, rollout: Rollout | None, robot: Robot) -> None:
    from app.motion.baked import bake_plan, bake_rollout
    from app.panel import summaries
    from app.plots.charts import everything, shown_layers
    from app.plots.choice import PRESETS
    from app.plots.figure import figure
    from llsrbm.look.timeline import timeline
    from llsrbm.look.titles import titles_of
    from llsrbm.motion.surroundings import surroundings
    from llsrbm.request.design import dump_design
    from llsrbm.request.scenario import Scenario

    scenario = Scenario() if rollout is None else rollout.scenario
    dump_design(Design(plan.jump, plan.tuning, scenario))
    titles_of([(plan.jump, plan.tuning, scenario)])
    replay = bake_plan(plan, robot)
    surroundings(robot, plan, scenario)
    summaries.plan_status(plan)
    summaries.plan_figures(plan)
    summaries.residuals(plan.violations)
    if rollout is not None:
        bake_rollout(rollout)
        summaries.simulated_status(rollout)
        summaries.rollout_figures(rollout)
    end = timeline(plan, rollout).end
    layers = shown_layers(replay, rollout)
    for choice in (*PRESETS.values(), everything()):
        figure(choice, layers, end)


def _show_alone(name: str, motion: Rollout | WholeBodyMotion) -> None:
    from app.motion import colours
    from app.motion.baked import bake_foreign
    from app.plots.charts import charts, everything, pinned_layer

    layer = pinned_layer(name, colours.PINNED[0], bake_foreign(name, motion), None)
    charts(everything(), [layer])


def _line(text_: str) -> str:
    return " ".join(text_.split())
