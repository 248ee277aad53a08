"""The project's own file, which `llsrbm.load` and the page open: everything, without loss.

NumPy's npz without pickle: one array a quantity at the planner's knots or the controller's ticks,
`schema` with the file's version, and at `meta` everything beside the numbers as JSON, of a plan its
`schedule`: name and standing feet of each phase that `phase` counts. World frame, SI units,
quaternions w, x, y, z. A rollout's file holds the plan that was followed, its keys under "plan/".
`llsrbm formats --format npz` lists the quantities.
"""

from __future__ import annotations

from pathlib import Path

from llsrbm.files.npz import keys
from llsrbm.formats.base import Format, Options
from llsrbm.motion.trajectory import Trajectory, load
from llsrbm.motion.whole_body import WholeBodyMotion, whole_body_motion
from llsrbm.robots import Robot


def write_npz(trajectory: Trajectory, path: Path, options: Options) -> None:
    """Write the native file."""
    del options  # it keeps knots and ticks
    trajectory.save(path)


def read_npz(path: Path, robot: Robot, fps: float | None) -> WholeBodyMotion:
    """Sample what a native file holds; its robot is the file's.

    Raises:
        FileFormatError: it is no native file.
        InputError: the rate makes no sense, or the file's robot is another by now.
    """
    del robot
    return whole_body_motion(load(path), Options().fps if fps is None else fps)


def _looks_so(path: Path) -> bool:
    return {"schema", "meta"} <= keys(path)


NPZ = Format(
    name="npz",
    title="the native file: every quantity at the planner's knots or the controller's ticks",
    suffix=".npz",
    write=write_npz,
    conventions=__doc__,
    read=read_npz,
    recognises=_looks_so,
)
