"""Planners that answer the same request: this project's, the paper's formulation, Crocoddyl."""

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import llsrbm
from benchmarks.interleaved import CHILD, Program, crocoddyl_python
from benchmarks.opti_baseline import solve_baseline
from benchmarks.peers.judge import Motion
from benchmarks.solve_child import wait_for_library
from llsrbm.body.knot_motion import KnotMotion
from llsrbm.models import make_model
from llsrbm.planning.answer.planner import planner_for
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.whole_body.refine import refined, refiner_of
from llsrbm.robots import load_robot
from llsrbm.robots.robot import Robot

INTERVALS = 48


@dataclass(frozen=True, eq=False)
class Answer:
    """The result of a planner.

    Attributes:
        seconds: in its solver.
        converged: as it says itself.
        turned, moved: where the base ends: rad about the vertical, m forward; NaN if unknown.
        motion: None if there is none to be judged.
    """

    seconds: float
    iterations: int
    converged: bool
    turned: float
    moved: float
    motion: Motion | None


class Ours:
    """This project's planner, from the analytic guess; with the second stage where it refines."""

    def __init__(self, model: str, *, refines: bool = False) -> None:
        self.name = f"llsrbm, {model}" + (", refined" if refines else "")
        self._model, self._refines = model, refines

    def prepare(self) -> None:
        self._planner = planner_for("anymal", self._model, intervals=INTERVALS)
        wait_for_library(self._planner)
        if self._refines:
            first = self._planner.plan(llsrbm.Jump(robot="anymal", model=self._model))
            refiner_of(first).solver.settle()

    def plan(self, twist: float, forward: float) -> Answer:
        jump = llsrbm.Jump(robot="anymal", model=self._model, twist=twist, forward=forward)
        plan = self._planner.plan(jump)
        if self._refines:
            plan = refined(plan)
        w, _, _, z = plan.base_quat[-1]
        return Answer(
            seconds=plan.effort.solve_time_s,
            iterations=plan.effort.iterations,
            converged=plan.report.status == "solved" and plan.refined == self._refines,
            turned=2 * float(np.arctan2(z, w)),
            moved=float(plan.com[-1, 0] - plan.com[0, 0]),
            motion=Motion.of_knots(self._planner.robot, KnotMotion.of_plan(plan)),
        )

    def end(self) -> None:
        """Nothing was started."""


class Opti:
    """The paper's formulation by CasADi's Opti and Ipopt."""

    def __init__(self, model: str) -> None:
        self.name = f"Opti + Ipopt, {model}"
        self._model_name = model

    def prepare(self) -> None:
        self._robot = load_robot("anymal")
        self._model = make_model(self._model_name, self._robot)

    def plan(self, twist: float, forward: float) -> Answer:
        jump = llsrbm.Jump(robot="anymal", model=self._model_name, twist=twist, forward=forward)
        task = make_task(jump, self._robot)
        found = solve_baseline(task, self._model, INTERVALS, expand=True)
        return Answer(
            seconds=found.solve_time_s,
            iterations=found.iterations,
            converged=found.converged,
            turned=found.final_yaw,
            moved=float(found.motion.com[-1, 0] - found.motion.com[0, 0]),
            motion=Motion.of_knots(self._robot, found.motion),
        )

    def end(self) -> None:
        """Nothing was started."""


class Crocoddyl:
    """Crocoddyl's own jump of ANYmal, in an environment of its own; it has no twist."""

    def __init__(self, title: str, solver: str) -> None:
        self.name, self._solver = f"Crocoddyl 3.2.1, {title}", solver

    def prepare(self) -> None:
        child = str(CHILD.with_name("crocoddyl_jump.py"))
        self._folder = tempfile.TemporaryDirectory(prefix="llsrbm-")
        self._file = Path(self._folder.name, "motion.npz")
        command = [str(crocoddyl_python()), child, "--forward", "--out", str(self._file)]
        self._program = Program([*command, "--solver", self._solver])
        self._program.ready()

    def plan(self, twist: float, forward: float) -> Answer | None:
        if twist or forward != 0.3:
            return None
        figures = json.loads(self._program.answer())
        with np.load(self._file) as arrays:
            motion = _crocoddyls(load_robot("anymal"), dict(arrays))
            moved = float(arrays["moved"])
        return Answer(
            seconds=figures["solve"],
            iterations=figures["iterations"],
            converged=bool(figures["converged"]),
            turned=0.0,
            moved=moved,
            motion=motion,
        )

    def end(self) -> None:
        self._program.end()
        self._folder.cleanup()


def _crocoddyls(robot: Robot, arrays: dict[str, np.ndarray]) -> Motion:
    order = [list(arrays["joint_names"]).index(name) for name in robot.joint_names]
    feet = [list(arrays["feet"]).index(leg.foot_frame) for leg in robot.legs]
    return Motion(
        joint_velocity=arrays["joint_velocity"][:, order],
        joint_torque=arrays["joint_torque"][:, order],
        contact_force=arrays["contact_force"][:, feet],
        foot_position=arrays["foot_position"][:, feet],
        standing=arrays["standing"][:, feet],
        impulse=float(arrays["impulse"]),
    )


PLANNERS = (
    Ours("llsrbm-plus"),
    Ours("llsrbm-plus", refines=True),
    Ours("llsrbm"),
    Ours("srbm"),
    Opti("llsrbm"),
    Opti("srbm"),
    Crocoddyl("FDDP", "fddp"),
    Crocoddyl("BoxFDDP", "box-fddp"),
    Crocoddyl("CSQP", "csqp"),
)
