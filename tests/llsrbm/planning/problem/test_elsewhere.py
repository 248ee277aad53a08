"""All rows, costs and states of all stages, with the world turned, moved, mirrored or shifted.

At random variables, so that no row is at rest: how far each is from its bounds must stay.
"""

from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np
import pytest

from llsrbm.models import make_model
from llsrbm.planning.problem.constraints.edge import Edge
from llsrbm.planning.problem.costs import COSTS
from llsrbm.planning.problem.jump_horizon import constraints_of
from llsrbm.planning.problem.layout import SHIFT, Layout
from llsrbm.planning.problem.parameters import (
    OWN,
    local_parameters,
    parameter_places,
    parameter_symbols,
    parameters,
)
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import InMotion
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.llsrbm.planning.elsewhere import Elsewhere

INTERVALS = 12
ALMOST = 1e-2
HEADINGS = np.radians([17.0, 45.0, -133.0])
# Along the world's axes on purpose: a pyramid of friction inside of the cone.
OF_WORLD_AXES = "friction_pyramid"
JUMPS = {
    "anymal": Jump(robot="anymal", twist=0.5, forward=0.2, lateral=0.1, height=0.1),
    "a foot aside": Jump(
        robot="go2", twist=0.5, forward=0.2, stones=(("FL", 0.06, 0.04, 0.03), ("RR", -0.02, 0.01))
    ),
    "slider": Jump(robot="slider", twist=0.5, forward=0.2, height=0.1),
    "one side first": Jump(robot="anymal", type="one-foot-first", twist=0.5, forward=0.1),
    "flip": Jump(robot="go2", type="flip", pitch=2 * np.pi, twist=0.4, forward=0.1),
}


class Stages:
    """All stages of a jump as functions of variables and parameters."""

    def __init__(self, jump: Jump, under_way: bool):
        robot = load_robot(jump.robot)
        self.robot = robot.turning if jump.turns else robot
        task = make_task(jump, robot)
        self.layout = layout_of(jump, robot, INTERVALS)
        if under_way:  # in flight, or as only the first side has landed
            mixed = any(0 < sum(row) < len(row) for row in task.schedule.stands[-2:])
            schedule = task.schedule.rest(task.schedule.flights[0] + mixed, (0.2, 0.5))
            layout = self.layout
            self.layout = Layout.of(
                schedule,
                layout.contacts,
                INTERVALS,
                layout.foot_coordinates,
                turns=layout.turns,
            )
            task = replace(task, schedule=schedule, motion=_motion(self.layout))
        self.task = task
        self.places = parameter_places(self.layout)
        model = make_model(jump.model, self.robot)
        symbols = parameter_symbols(self.layout)
        self.functions = {}
        for knot, role in enumerate(self.layout.roles):
            if role in self.functions:
                continue
            stage = Stage(role, self.layout, model, symbols)
            rows = {c.name: c.rows(stage) for c in constraints_of(role)}
            costs = [c.term(stage) for c in COSTS if c.applies(role)]
            following = None if role.terminal else self.layout.roles[knot + 1]
            rows["cost"] = ca.vertcat(*costs)
            rows["state"] = ca.SX(0, 1) if role.terminal else stage.next_state(following)
            own = ca.SX(0, 1) if role.terminal else stage.own
            inputs = [stage.variables, ca.vertcat(*symbols.values()), stage.local, own]
            outputs = [stage.lift.resolve(ca.densify(ca.vec(row))) for row in rows.values()]
            self.functions[role] = list(rows), ca.Function("rows", inputs, outputs)

    def at(self, knot, task, w):
        """Name -> values of the rows, of `cost` and `state` at a knot."""
        layout, p = self.layout, np.concatenate(list(parameters(self.layout, task).values()))
        names, function = self.functions[layout.roles[knot]]
        local = np.r_[tuple(self.places[name] for name in local_parameters(layout.phase[knot]))]
        own = p[self.places[OWN]].reshape(layout.total, -1)[knot : knot + 1].ravel()
        found = function(w[layout.stage(knot)], p, p[local], own)
        return {name: np.array(x).ravel() for name, x in zip(names, found, strict=True)}

    def random(self):
        rng = np.random.default_rng(1)
        w = rng.normal(scale=0.2, size=self.layout.size_total)
        for k in range(self.layout.knots):
            for name, place in self.layout.variables(k).items():
                if "duration" in name:
                    w[place] = 0.4
                elif name in ("feet", "next_feet"):
                    each = w[place].reshape(-1, self.layout.foot_coordinates)
                    each[:, 2] -= 0.3
                elif name == "position":
                    w[place] += self.task.goal_position
                elif name == "quat":
                    w[place] = self.task.goal_quat + 0.3 * w[place]
        return self.layout.normalised(w)


def _motion(layout):
    rng = np.random.default_rng(2)
    feet, rates = rng.normal(scale=0.1, size=(2, layout.legs, layout.foot_coordinates))
    feet[:, 2] -= 0.3
    none = np.zeros(0)
    begun = np.full(layout.legs, 0.3)
    return InMotion(rng.normal(size=3), feet, rates, np.full(layout.legs, 0.1), begun, (none, none))


@cache
def stages(name, under_way):
    return Stages(JUMPS[name], under_way)


def slacks(constraint, task, layout, knot, rows):
    """Sorted: how far rows are from their bounds; of equalities their norm, which has no axes."""
    lower, upper = constraint.bounds(task, layout, knot)
    off = np.broadcast_arrays(rows - lower, upper - rows)
    if constraint.equality:
        return np.array([np.linalg.norm(off[0])])
    found = np.sort(np.concatenate(off))
    return found[np.isfinite(found)]


def assert_alike(of, there, skip=(), tolerance=1e-8):
    """Everything at all knots of a motion is as at the motion elsewhere."""
    w, other_task = of.random(), there.task(of.task)
    other = there.variables(of.robot, of.layout, w)
    seen = set()
    for knot, role in enumerate(of.layout.roles):
        here, moved = of.at(knot, of.task, w), of.at(knot, other_task, other)
        for constraint in constraints_of(role):
            if constraint.name in skip:
                continue
            seen.add(constraint.name)
            found = (
                slacks(constraint, task, of.layout, knot, rows[constraint.name])
                for task, rows in ((of.task, here), (other_task, moved))
            )
            np.testing.assert_allclose(
                *found, rtol=tolerance, atol=tolerance, err_msg=f"{constraint.name} at {knot}"
            )
        np.testing.assert_allclose(here["cost"], moved["cost"], rtol=tolerance, atol=tolerance)
        if not role.terminal:
            state = there.states(of.robot, of.layout, knot + 1, here["state"])
            np.testing.assert_allclose(moved["state"], state, rtol=tolerance, atol=tolerance)
    return seen


@pytest.mark.parametrize(
    ("name", "under_way"),
    [("a foot aside", False), ("slider", False), ("anymal", True), ("one side first", True)],
)
def test_the_world_may_be_turned_and_moved(name, under_way):
    of = stages(name, under_way)
    for heading in HEADINGS:
        there = Elsewhere(heading, (0.7, -0.4, 0.2))
        seen = assert_alike(of, there, skip={OF_WORLD_AXES})
    assert "final_state" in seen
    assert ("final_place" in seen) == under_way


@pytest.mark.parametrize("name", ["a foot aside"])
def test_left_and_right_may_change_places(name):
    """But for what little by which the sides of the robots' files differ."""
    assert_alike(stages(name, False), Elsewhere(mirrored=True), tolerance=ALMOST)


@pytest.mark.parametrize("name", ["anymal", "flip"])
def test_landing_elsewhere_is_landing_alike(name):
    """In flight and after it: CoM and feet with the shift. What stands still is the edge alone."""
    of, aside = stages(name, True), np.array([0.07, -0.05])
    w = of.random()
    other = w.copy()
    for k in range(of.layout.knots):
        for variable, size in (("position", 2), (SHIFT, 2)):
            if (place := of.layout.variables(k).get(variable)) is not None:
                other[place.start : place.start + size] += aside
    seen = set()
    for knot, role in enumerate(of.layout.roles[1:], start=1):
        here, there = of.at(knot, of.task, w), of.at(knot, of.task, other)
        for constraint in constraints_of(role):
            if not isinstance(constraint, Edge):
                seen.add(constraint.name)
                np.testing.assert_allclose(
                    here[constraint.name],
                    there[constraint.name],
                    atol=1e-9,
                    err_msg=constraint.name,
                )
    assert {"put_down", "given_contacts", "final_place", "momentum_balance"} <= seen
