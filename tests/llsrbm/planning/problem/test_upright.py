"""How far a body that has turned over may lean as it lands, against rotations of known tilt."""

from functools import cache
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.models import make_model
from llsrbm.planning.problem.constraints.drive_shares import compressed
from llsrbm.planning.problem.constraints.drives import OVERRUN, JointSpeed
from llsrbm.planning.problem.constraints.motion import (
    LEAN,
    REBOUND,
    SHORT,
    Rebound,
    ShortOfTurn,
    UprightLanding,
)
from llsrbm.planning.problem.constraints.swing import BESIDE, PutDown
from llsrbm.planning.problem.knots import RowValues
from llsrbm.planning.problem.parameters import parameter_symbols, parameters
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.solve.guess import analytic_guess
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot

FLIPS = (
    {"type": "flip", "pitch": -2 * np.pi},
    {"type": "flip", "pitch": 2 * np.pi},
    {"type": "barrel-roll", "roll": 2 * np.pi},
    {"type": "barrel-roll", "roll": -2 * np.pi},
)
NAMES = ("back", "front", "right", "left")
TILTS = (0.0, LEAN - 0.01, LEAN + 0.01, np.pi)


@cache
def case(**turn):
    """Task, layout, model and the analytic guess of a flip."""
    robot = load_robot("go2")
    jump = Jump(robot="go2", **(turn or FLIPS[0]))
    task, layout = make_task(jump, robot), layout_of(jump, robot, 12)
    model = make_model("llsrbm-plus", robot)
    return task, layout, model, analytic_guess(task, layout, model)


def landing(layout):
    """The knots from touchdown on, the very end not among them."""
    return range(int(layout.first_knots[-2]), layout.knots - 1)


def leaning(tilt, heading=0.7, towards=2.0):
    """(4,) w, x, y, z of a body that leans by `tilt` from the vertical, in any direction."""
    axis = np.array([np.cos(towards), np.sin(towards), 0.0])
    turned = Rotation.from_rotvec(tilt * axis) * Rotation.from_euler("z", heading)
    return turned.as_quat(scalar_first=True)


@cache
def row_at(knot):
    """The row as a function of a stage's variables, with the task's numbers."""
    task, layout, model, w = case()
    symbols = parameter_symbols(layout)
    stage = Stage(layout.roles[knot], layout, model, symbols)
    inputs = [stage.variables, stage.local, *symbols.values()]
    row = ca.Function("row", inputs, [stage.lift.resolve(UprightLanding().rows(stage))])
    values = parameters(layout, task)
    phase = int(layout.phase[knot])
    names = [f"phase{phase}_{n}" for n in ("feet", "contacts", "yaw", "towards", "tilt")]
    local = np.concatenate([values[n] for n in names])
    places = layout.variables(knot)

    def at(quat):
        here = w.copy()
        here[places["quat"]] = quat
        variables = np.concatenate([here[place] for place in places.values()])
        return float(row(variables, local, *values.values()))

    return at


@pytest.mark.parametrize("tilt", TILTS, ids="{:.2f}".format)
def test_the_row_is_within_its_bounds_up_to_the_largest_lean(tilt):
    task, layout, _, _ = case()
    for knot in (landing(layout)[0], landing(layout)[-1]):
        found = row_at(knot)(leaning(tilt))
        assert found == pytest.approx(np.cos(tilt), abs=1e-12)
        # A whole turn over is -quat: the same attitude.
        assert row_at(knot)(-leaning(tilt)) == pytest.approx(found)
        (low,), (high,) = UprightLanding().bounds(task, layout, knot)
        assert (low <= found <= high) == (tilt <= LEAN)


@pytest.mark.parametrize("tilt", TILTS, ids="{:.2f}".format)
def test_the_violation_is_by_how_much_it_leans_beyond(tilt):
    constraint, time = UprightLanding(), np.arange(9.0)
    lower = np.full(3, np.cos(np.radians(30)))
    rows = RowValues(np.cos([0.0, tilt, 0.1]), lower, np.full(3, np.inf), np.array([5, 6, 7]))
    found = constraint.violation(SimpleNamespace(time=time, task=None, rows={constraint: rows}))
    expected = np.zeros(9)
    expected[6] = max(tilt - np.radians(30), 0.0)
    np.testing.assert_allclose(found, expected, atol=1e-7)


@pytest.mark.parametrize("turn", FLIPS, ids=NAMES)
def test_every_flip_lands_upright_and_nothing_else_has_to(turn):
    _, layout, _, _ = case(**turn)
    applies = [UprightLanding().applies(role) for role in layout.roles]
    assert np.flatnonzero(applies).tolist() == list(landing(layout))


@pytest.mark.parametrize("turn", FLIPS, ids=NAMES)
def test_a_body_touches_down_short_of_its_turn_and_never_past_it(turn):
    """Attitudes by SciPy: what is left of a turn about the body's own axis, at any heading."""
    task, layout, _, _ = case(**turn)
    constraint, knot = ShortOfTurn(), landing(layout)[0]
    assert [k for k, role in enumerate(layout.roles) if constraint.applies(role)] == [knot]
    axis, whole = ("X", turn["roll"]) if "roll" in turn else ("Y", turn["pitch"])
    least, most = SHORT["roll" if axis == "X" else "front" if whole > 0 else "back"]
    low, high = constraint.bounds(task, layout, knot)
    for left in np.radians([-10.0, 0.0, 4.0, 11.0, 15.0, 19.0, 22.0]):
        angles = [0.7, whole - np.sign(whole) * left]
        R = Rotation.from_euler("Z" + axis, angles).as_matrix()
        found = R[2, :2]
        within = bool(((low <= found) & (found <= high)).all())
        assert within == bool(least <= left <= most)


def test_feet_come_down_onto_their_places_as_the_last_interval_begins():
    task, layout, _, _ = case()
    constraint = PutDown()
    (knot,) = (k for k, role in enumerate(layout.roles) if constraint.applies(role))
    assert knot == landing(layout)[0] - 1
    low, high = constraint.bounds(task, layout, knot)
    places = task.footholds_after(int(layout.phase[knot])).feet[:, :2].ravel()
    np.testing.assert_allclose([low, high], [places - BESIDE, places + BESIDE])


def speed_bounds(turn, knot_after_touchdown=0, **displacement):
    robot = load_robot("go2")
    jump = Jump(robot="go2", **displacement, **turn)
    task, layout = make_task(jump, robot), layout_of(jump, robot, 12)
    knot = int(layout.first_knots[-2]) + knot_after_touchdown
    lower, upper = JointSpeed().bounds(task, layout, knot)
    np.testing.assert_array_equal(lower, -upper)
    return upper


def test_where_knees_may_be_overrun_as_a_flip_lands():
    back, front, roll, _ = FLIPS
    for turn, displacement, overrun in (
        (back, {}, True),
        (back, {"height": -0.5}, True),
        (front, {}, True),
        (front, {"forward": 0.1}, True),
        (roll, {}, False),
        (roll, {"forward": 0.1}, False),
    ):
        hips_and_knees = speed_bounds(turn, **displacement).reshape(-1, 3)
        knees = hips_and_knees[:, 2]
        assert (
            knees == pytest.approx(compressed(OVERRUN, np.sqrt)) if overrun else knees.max() < 1.0
        )
        assert hips_and_knees[:, :2].max() < 1.0
        assert speed_bounds(turn, -1, **displacement).max() < 1.0


@pytest.mark.parametrize("turn", FLIPS, ids=NAMES)
def test_flips_may_not_rise_again_fast_as_they_land(turn):
    task, layout, _, _ = case(**turn)
    constraint = Rebound()
    assert [k for k, r in enumerate(layout.roles) if constraint.applies(r)] == [*landing(layout)]
    _, (high,) = constraint.bounds(task, layout, landing(layout)[0])
    assert high == REBOUND if "pitch" in turn else high > 3.0


def test_flips_are_offered_further_down_than_other_jumps():
    file = load_robot("go2").file
    flips, others = (file.for_jump(turns=turns).task for turns in (True, False))
    assert flips.height[0] == -0.5 < others.height[0]
