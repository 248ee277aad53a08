"""The momentum balance where feet leave or land: Fatrop takes rows that hardly depend on what is
chosen for rows that do, and ends in the first iterations, or never.
"""

import casadi as ca
import numpy as np
import pytest

from llsrbm.models import make_model
from llsrbm.planning.answer.planner import planner_of
from llsrbm.planning.problem.parameters import parameter_symbols
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot

# Types in which some feet swing while others stand.
PARTLY = [
    ("go2", "rear-last"),
    ("go2", "leap"),
    ("go2", "one-foot-first"),
    ("slider", "one-foot-first"),
]


def slopes_in_swings(robot, kind, model):
    """At each first stage of a phase whose feet have just left or met the ground while some swing:
    the balance's largest slope in what swings them, at a random place.
    """
    jump, loaded = Jump(robot, model=model, type=kind), load_robot(robot)
    layout, made = layout_of(jump, loaded), make_model(model, loaded)
    rng, found = np.random.default_rng(0), []
    for role in dict.fromkeys(layout.roles):
        if not role.swinging or not (role.leaving or role.landing):
            continue
        symbols = parameter_symbols(layout)
        stage = Stage(role, layout, made, symbols)
        balance = stage.lift.resolve(stage.balance)
        slope = ca.jacobian(balance, stage.symbols["feet_step"])
        inputs = [stage.variables, stage.local, stage.own, *symbols.values()]
        values = [rng.uniform(0.1, 0.3, each.shape) for each in inputs]
        found.append(np.abs(np.array(ca.Function("slope", inputs, [slope])(*values))).max())
    assert len(found) >= 2
    return found


@pytest.mark.parametrize(("robot", "kind"), PARTLY)
def test_legs_without_momentum_leave_the_balance_alone_as_they_swing(robot, kind):
    assert max(slopes_in_swings(robot, kind, "llsrbm")) == 0.0


def test_legs_with_momentum_do_not():
    assert min(slopes_in_swings("go2", "rear-last", "llsrbm-plus")) > 1e-4


@pytest.mark.nightly
@pytest.mark.parametrize(("robot", "kind"), [("go2", "rear-last"), ("slider", "one-foot-first")])
def test_the_papers_model_plans_types_whose_feet_take_turns(robot, kind):
    jump = Jump(robot, model="llsrbm", type=kind, forward=0.2, twist=np.radians(5))
    plan = planner_of(jump).plan(jump, patient=False)
    assert plan.solved
    assert plan.report.iterations < 60
