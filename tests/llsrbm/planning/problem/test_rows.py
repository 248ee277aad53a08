"""What the solver is told and what is checked afterwards are two formulations: they must agree.

Random motions: a plan's controls disturbed, and rolled out so that the dynamics hold.
"""

from functools import cache

import numpy as np
import pytest

from llsrbm import models
from llsrbm.mechanics import GRAVITY
from llsrbm.planning.problem.constraints import CONSTRAINTS
from llsrbm.planning.problem.horizon import constraints_of
from llsrbm.planning.problem.knots import unpack
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.stage import BALANCE_SCALE
from llsrbm.planning.solve.planner import layout_of
from llsrbm.planning.why.residuals import dynamics_defects
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.llsrbm.planning.solved import function, parameters, rows_by_constraint, solved

# Rows of the legs' drives, checks by Pinocchio: test_drive_rows compares them.
DRIVES = ("joint_torque", "torque_at_speed", "joint_speed")
MOTIONS = [*((model, "all") for model in models.names()), ("llsrbm-plus", "rear-last")]
MOTIONS += [("llsrbm-plus", "hops")]
every_motion = pytest.mark.parametrize(("model", "request_name"), MOTIONS)


def rolled_out(s, seed):
    """A disturbed plan whose gaps are closed one after another, and its rows."""
    layout, p = s.planner.layout, parameters(s.planner.layout, s.task)
    nlp_g = function(s.planner, "nlp_g")
    rng = np.random.default_rng(seed)
    w = s.w + rng.normal(scale=0.05, size=s.w.size)
    row = 0
    for k, role in enumerate(layout.roles[:-1]):
        places, after = layout.variables(k), layout.variables(k + 1)
        for name in ("duration", "next_duration"):
            if name in places:
                w[places[name]] = np.maximum(w[places[name]], 0.2)
        states = layout.states(layout.roles[k + 1])
        first = after[states[0]].start
        size = layout.state_size(layout.roles[k + 1])
        gap = np.array(nlp_g(w, p)).ravel()[row : row + size]
        w[first : first + size] -= gap
        row += size + sum(len(c.bounds(s.task, layout, k)[0]) for c in constraints_of(role))
    return w, np.array(nlp_g(w, p)).ravel()


@cache
def motion(model, request_name, seed):
    s = solved(model, request_name)
    w, g = rolled_out(s, seed)
    knots = unpack(w, s.planner.layout, s.task, s.planner.model)
    return s, knots, row_excess(s, g)


def row_excess(s, g):
    """Constraint name -> (N+1,) by how much the rows at each knot leave their bounds."""
    layout = s.planner.layout
    excess = {c.name: np.zeros(layout.knots) for c in CONSTRAINTS}
    for k, rows in enumerate(rows_by_constraint(s, g)):
        for constraint in constraints_of(layout.roles[k]):
            low, high = constraint.bounds(s.task, layout, k)
            here = rows[constraint.name]
            # Points have no rows about the turn of feet.
            beyond = np.concatenate([low - here, here - high])
            excess[constraint.name][k] = beyond.max(initial=0.0)
    return excess


@every_motion
@pytest.mark.parametrize("seed", [0, 1])
def test_the_solvers_dynamics_are_those_of_numpy(model, request_name, seed):
    _, knots, _ = motion(model, request_name, seed)
    for name, (_, defect) in dynamics_defects(knots).items():
        assert defect.max() < 1e-8, name


@every_motion
@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize(
    "constraint",
    [c for c in CONSTRAINTS if c.name not in {*DRIVES, "true_turn"}],
    ids=lambda c: c.name,
)
def test_rows_and_check_agree(model, request_name, seed, constraint):
    s, knots, excess = motion(model, request_name, seed)
    rows, amount = excess[constraint.name], constraint.violation(knots)
    if constraint.name == "phase_times":
        # The rows are at the knot where the duration is chosen, the check where its phase begins.
        phases = s.planner.layout.phases
        rows, amount = np.sort(rows)[-phases:], np.sort(amount)[-phases:]
    force_unit = s.task.mass * GRAVITY / s.planner.layout.contacts
    units = {
        "momentum_balance": s.task.mass / BALANCE_SCALE,
        "given_contacts": 1.0,
        "friction_pyramid": force_unit,
        "phase_times": 1.0,
        "clearance": 1.0,
        "foot_speed": 1.0,
        "feet_at_rest": 1.0,
    }
    if constraint.name in units:
        np.testing.assert_allclose(rows * units[constraint.name], amount, atol=1e-8)
    np.testing.assert_array_equal(rows > 1e-9, amount > 1e-9)
    # The disturbance is large enough to break what holds at many knots.
    if constraint.name in ("momentum_balance", "given_contacts", "reach", "final_state"):
        assert amount.max() > 1e-3


@pytest.mark.parametrize(("robot", "kind"), [("anymal", "hops"), ("slider", "together")])
def test_bounds_of_a_role_are_the_same_at_its_knots_unless_said_otherwise(robot, kind):
    jump = Jump(robot=robot, type=kind, forward=0.2, height=0.1)
    task, layout = make_task(jump, load_robot(robot)), layout_of(jump, load_robot(robot))
    differ = set()
    for role, knots in layout.blocks():
        for constraint in constraints_of(role):
            first, *others = (constraint.bounds(task, layout, knot) for knot in knots)
            if any(not np.array_equal(first, other) for other in others):
                differ.add(constraint)
    assert differ
    assert all(constraint.by_knot for constraint in differ)
