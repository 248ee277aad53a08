"""All that was asked for, as a small JSON file to start from again: no motion is in it.

The request, the weights and limits that differ from the robot's own, and of a simulation its
scenario: what `llsrbm plan --design`, `llsrbm simulate --design` and the page open. SI units,
angles in rad; `llsrbm.request.design` says what stands where.
"""

from __future__ import annotations

from pathlib import Path

from llsrbm.formats.base import Format, Options
from llsrbm.motion.plan import Plan
from llsrbm.motion.trajectory import Trajectory
from llsrbm.request.design import SUFFIX, Design, dump_design


def write_design(trajectory: Trajectory, path: Path, options: Options) -> None:
    """Write the design of a plan or of a rollout."""
    del options  # it holds nothing that could be sampled
    path.write_text(dump_design(design_of(trajectory)), encoding="utf-8")


def design_of(trajectory: Trajectory) -> Design:
    """The design that a plan or a rollout came from."""
    if isinstance(trajectory, Plan):
        return Design(trajectory.jump, trajectory.tuning)
    return Design(trajectory.jump, trajectory.plan.tuning, trajectory.scenario)


DESIGN = Format(
    name="design",
    title="all that was asked for, to plan and simulate it again; no motion",
    suffix=SUFFIX,
    write=write_design,
    conventions=__doc__,
)
