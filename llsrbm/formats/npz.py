"""The project's own file, which `llsrbm.load` and the page open: everything, without loss.

NumPy's npz without pickle: one array a quantity at the planner's knots or the controller's ticks,
`schema` with the file's version, and at `meta` everything beside the numbers as JSON. World frame,
SI units, quaternions w, x, y, z. A rollout's file holds the plan that was followed, its keys under
"plan/". `llsrbm formats --format npz` lists the quantities.
"""

from __future__ import annotations

from pathlib import Path

from llsrbm.formats.base import Format, Options
from llsrbm.motion.files import Trajectory


def write_npz(trajectory: Trajectory, path: Path, options: Options) -> None:
    """Write the native file."""
    del options  # it keeps knots and ticks
    trajectory.save(path)


NPZ = Format(
    name="npz",
    title="the native file: every quantity at the planner's knots or the controller's ticks",
    suffix=".npz",
    write=write_npz,
    conventions=__doc__,
)
