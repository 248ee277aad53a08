"""What is given up moves everything as the tasks of lesser requests have it."""

from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from llsrbm.models import make_model
from llsrbm.planning.problem.foot_clearance import FAR, clearance_line, edge_ranges
from llsrbm.planning.problem.layout import SHORTFALL
from llsrbm.planning.problem.parameters import parameter_symbols, parameters
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.robots import load_robot

CASES = (
    ("anymal", "hops"),
    ("slider", "together"),
    ("go2", "rear-last"),
)
share = st.floats(0.0, 1.0)
signs = st.tuples(*[st.floats(-1.0, 1.0)] * 4)


@cache
def stages(name, kind):
    robot = load_robot(name)
    jump = Jump(robot=name, type=kind, hops=2 if kind == "hops" else 1)
    layout = layout_of(jump, robot, 18)
    model, symbols = make_model("llsrbm-plus", robot), parameter_symbols(layout)
    return robot, jump, layout, model, symbols


@cache
def function(name, kind, knot):
    """Of a knot's stage, what is given up and all parameters: what depends on it."""
    _, _, layout, model, symbols = stages(name, kind)
    stage = Stage(layout.roles[knot], layout, model, symbols)
    moved = [ca.SX(stage.ground_moved(i)) for i in range(layout.legs)]
    edges = [ca.SX(stage.edge_moved(i)) for i in range(layout.legs)]
    of = [stage.parameters[f"goal_{name}"] for name in ("position", "quat", "velocity")]
    standing = stage.standing_feet, stage.standing_contacts, stage.standing_yaw
    values = [stage.lift.resolve(x) for x in (*of, *standing, stage.towards, *moved, *edges)]
    inputs = [stage.symbols[SHORTFALL], stage.local, stage.own, *symbols.values()]
    return ca.Function("stage", inputs, values)


def jump_of(name, kind, share_of_range):
    robot, jump, *_ = stages(name, kind)
    own = robot.file.task
    values = {
        c: abs(s) * getattr(own, c)[int(s > 0)]
        for c, s in zip(COMPONENTS, share_of_range, strict=True)
    }
    return Jump(robot=name, type=kind, hops=jump.hops, stones=stones_of(robot), **values)


def stones_of(robot):
    """The first foot aside, not above the others: it might rise where the robot goes down."""
    return ((robot.leg_names[0], 0.03, 0.02),)


@pytest.mark.parametrize(("name", "kind"), CASES)
@settings(max_examples=8, deadline=None)
@given(wanted=signs, less=st.tuples(*[share] * 4))
def test_as_the_task_of_what_is_done(name, kind, wanted, less):
    robot, _, layout, _, _ = stages(name, kind)
    request = jump_of(name, kind, wanted)
    done = Jump(
        robot=name,
        type=kind,
        hops=request.hops,
        stones=request.stones,
        **{c: s * getattr(request, c) for c, s in zip(COMPONENTS, less, strict=True)},
    )
    reference, task = replace(make_task(request, robot), penalty=1.0), make_task(done, robot)
    numbers = parameters(layout, reference)
    scale = numbers["scale"]
    missing = [getattr(request, c) - getattr(done, c) for c in COMPONENTS]
    shortfall = np.divide(missing, scale, out=np.zeros(4), where=scale != 0)
    for knot in range(layout.total):
        role = layout.roles[knot]
        if not (role.has_shortfall and role.flies):
            continue
        phase = role.phase
        local = [
            numbers[f"phase{phase}_{n}"] for n in ("feet", "contacts", "yaw", "towards", "tilt")
        ]
        own = numbers["own"].reshape(layout.total, -1)[knot]
        found = function(name, kind, knot)(shortfall, np.concatenate(local), own, *numbers.values())
        position, quat, velocity, feet, contacts, yaw, _, *moved = (np.array(x) for x in found)
        assert position.ravel() == pytest.approx(task.goal_position, abs=1e-9)
        assert np.abs(quat.ravel() @ task.goal_quat) == pytest.approx(1, abs=1e-9)
        assert velocity.ravel() == pytest.approx(task.goal_velocity, abs=1e-9)
        assert pytest.approx(task.footholds_before(phase).feet, abs=1e-9) == feet.T
        assert pytest.approx(task.footholds_before(phase).contacts, abs=1e-9) == contacts.T
        assert yaw.ravel() == pytest.approx(task.footholds_before(phase).yaw, abs=1e-9)
        _same_clearance(layout, reference, task, knot, np.ravel(moved[: layout.legs]))


def _same_clearance(layout, reference, task, knot, moved):
    role, progress = layout.roles[knot], layout.swing_progress[0][[knot]]
    lines = [clearance_line(each, role.phase, progress)[0] for each in (reference, task)]
    for leg in role.flying:
        assert moved[leg] == pytest.approx(lines[1][leg] - lines[0][leg], abs=1e-9)


def test_the_edge_moves_with_the_jump():
    """Onto a box to which all feet have a gap, and a little less of that."""
    robot, _, layout, _, _ = stages("go2", "together")
    request = Jump(robot="go2", twist=0.074, forward=0.555, lateral=-0.214, height=0.227)
    less = replace(request, twist=0.06, forward=0.54, height=0.22)
    reference, task = replace(make_task(request, robot), penalty=1.0), make_task(less, robot)
    numbers = parameters(layout, reference)
    scale = np.where(numbers["scale"] == 0, 1, numbers["scale"])
    shortfall = np.array([getattr(request, c) - getattr(less, c) for c in COMPONENTS]) / scale
    bounds = [edge_ranges(each, layout)[1] for each in (reference, task)]
    compared = 0
    for knot in range(layout.total):
        role = layout.roles[knot]
        if not (role.has_shortfall and role.flies):
            continue
        local = [numbers[f"phase1_{n}"] for n in ("feet", "contacts", "yaw", "towards", "tilt")]
        own = numbers["own"].reshape(layout.total, -1)[knot]
        found = function("go2", "together", knot)(
            shortfall, np.concatenate(local), own, *numbers.values()
        )
        moved = np.ravel(found[-layout.legs :])
        for leg in role.flying:
            before, after = bounds[0][knot, leg], bounds[1][knot, leg]
            if max(before, after) < FAR:
                assert moved[leg] == pytest.approx(after - before, abs=1e-4)
                compared += 1
    assert compared > 4
