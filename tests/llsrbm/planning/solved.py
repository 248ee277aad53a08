"""Jumps that several tests look at, each planned once a run."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from llsrbm.motion.plan import Plan
from llsrbm.planning.answer.planner import Planner, planner_of
from llsrbm.planning.problem.jump_horizon import constraints_of
from llsrbm.planning.problem.knots import Knots, unpack
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.problem.parameters import parameters as parameters_of
from llsrbm.planning.problem.task import Task
from llsrbm.request.jump import Jump

REQUESTS: dict[str, dict[str, Any]] = {
    "twist": {"twist": np.pi / 2},
    "forward": {"forward": 0.3},
    "all": {"twist": 0.8, "forward": 0.2, "lateral": 0.15, "height": 0.15},
}
BIPED = {"box": {"forward": 0.2, "height": 0.35}}
# Jump types of which not all feet do the same, or which fly more than once, or start with speed.
TYPES: dict[str, dict[str, Any]] = {
    "rear-last": {"type": "rear-last", "forward": 0.3},
    "run-up": {"type": "run-up", "speed": 0.5, "end_speed": 0.2, "forward": 0.4},
    "hops": {"type": "hops", "hops": 2, "forward": 0.2, "twist": 0.3},
}
# They turn over, which of these robots Go2 can. No barrel roll is found with its rotors.
FLIPS: dict[str, dict[str, Any]] = {"flip": {"type": "flip", "pitch": -2 * np.pi}}


@dataclass(frozen=True)
class Solved:
    planner: Planner
    task: Task
    plan: Plan
    knots: Knots
    w: np.ndarray


@cache
def solved(model: str, request: str, robot: str = "anymal") -> Solved:
    """The plan of a request, from the analytic guess."""
    jump = Jump(robot=robot, model=model, **(REQUESTS | BIPED | TYPES | FLIPS)[request])
    planner = planner_of(jump)
    plan = planner.plan(jump)
    found = planner.last
    return Solved(planner, found.task, plan, found.knots, found.solution.variables)


def variable(knots: Knots, name: str, knot: int, leg: int | None = None) -> np.ndarray:
    """A variable at a knot, or a leg's part of it, in the layout's units; a copy."""
    return knots.variables[_place(knots, name, knot, leg)].copy()


def changed(knots: Knots, *changes: tuple) -> Knots:
    """The motion with other variables: each (name, knot, value) or (name, knot, leg, value)."""
    w = knots.variables.copy()
    for name, knot, *leg, value in changes:
        w[_place(knots, name, knot, *leg)] = value
    return unpack(w, knots.layout, knots.task, knots.model, knots.evaluate)


def _place(knots: Knots, name: str, knot: int, leg: int | None = None) -> slice:
    layout = knots.layout
    place = layout.variables(knot)[name]
    if leg is None:
        return place
    width = 3 * layout.corners if "force" in name else layout.foot_coordinates
    start = place.start + width * layout.legs_of(name, layout.roles[knot]).index(leg)
    return slice(start, start + width)


def function(planner: Planner, name: str) -> Any:
    """One of the functions that the planner's solver evaluates."""
    return planner.formulation.solver.function(name)


def parameters(layout: Layout, task: Task) -> np.ndarray:
    return np.concatenate(list(parameters_of(layout, task).values()))


def rows_by_constraint(s: Solved, g: np.ndarray) -> list[dict[str, np.ndarray]]:
    """Of each knot: constraint name -> its rows in g, the solver's values."""
    layout, row, found = s.planner.formulation.layout, 0, []
    for k, role in enumerate(layout.roles):
        if not role.terminal:
            row += layout.state_size(layout.roles[k + 1])
        here = {}
        for constraint in constraints_of(role):
            count = len(constraint.bounds(s.task, layout, k)[0])
            here[constraint.name] = g[row : row + count]
            row += count
        found.append(here)
    assert row == len(g)
    return found
