"""The project's own files: everything about a motion, or only the request, to start from again."""

from pathlib import Path

from llsrbm.files.npz import keys
from llsrbm.formats.base import Format, Options, Purpose
from llsrbm.motion.plan import Plan
from llsrbm.motion.trajectory import Trajectory, load
from llsrbm.motion.whole_body import WholeBodyMotion, whole_body_motion
from llsrbm.request.design import SUFFIX, Design, dump_design
from llsrbm.robots import Robot


def _read_npz(path: Path, _: Robot, fps: float | None) -> WholeBodyMotion:
    """Sampled; the robot is the file's own."""
    return whole_body_motion(load(path), Options().fps if fps is None else fps)


def _write_design(trajectory: Trajectory, path: Path, _: Options) -> None:
    if isinstance(trajectory, Plan):
        design = Design(trajectory.jump, trajectory.tuning)
    else:
        design = Design(trajectory.jump, trajectory.plan.tuning, trajectory.scenario)
    path.write_text(dump_design(design), encoding="utf-8")


NPZ = Format(
    name="npz",
    title="the native file, which llsrbm and its page open again: every quantity, without loss",
    purpose=Purpose.SIMULATION,
    suffix=".npz",
    write=lambda trajectory, path, _: trajectory.save(path),
    conventions="""\
The project's own file, which `llsrbm.load` and the page open: everything, without loss.

NumPy's npz without pickle: one array a quantity at the planner's knots or the controller's ticks,
`schema` with the file's version, and at `meta` everything beside the numbers as JSON, of a plan its
`schedule`: name and standing feet of each phase that `phase` counts. World frame, SI units,
quaternions w, x, y, z. A rollout's file holds the plan that was followed, its keys under "plan/".
`llsrbm formats --format npz` lists the quantities.
""",
    read=_read_npz,
    recognises=lambda path: {"schema", "meta"} <= keys(path),
)

DESIGN = Format(
    name="design",
    title="the request alone, for llsrbm and its page to plan and simulate it again; no motion",
    purpose=Purpose.SIMULATION,
    suffix=SUFFIX,
    write=_write_design,
    conventions="""\
All that was asked for, as a small JSON file to start from again: no motion is in it.

The request, the weights and limits that differ from the robot's own, and of a simulation its
scenario: what `llsrbm plan --design`, `llsrbm simulate --design` and the page open. SI units,
angles in rad; `llsrbm.request.design` says what stands where.
""",
)
