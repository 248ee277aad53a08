import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.motion.solve_report import Violation
from llsrbm.planning.problem.constraints import AGREED, CONSTRAINTS
from llsrbm.planning.problem.constraints.truth import correction
from llsrbm.planning.problem.knots import unpack
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.violations import (
    TOLERANCE,
    broken_in_words,
    describe_worst,
    dynamics_defects,
    satisfied,
    stops,
    violations,
)
from llsrbm.robots import load_robot
from tests.llsrbm.planning.solved import changed, solved, variable


@pytest.fixture(scope="module")
def knots():
    return solved("llsrbm-plus", "all").knots


def test_a_plan_obeys_the_dynamics(knots):
    for name, (_, defect) in dynamics_defects(knots).items():
        assert defect.shape == (len(knots.time) - 1,)
        assert defect.max() < 1e-6, name
    assert satisfied(violations(knots))


@pytest.mark.parametrize("k", [4, 20])
def test_defects_of_a_disturbed_plan(knots, k):
    """A disturbed knot shows in the interval before it; the one after starts from it."""
    step = np.array([0.0, 0.02, 0.0])
    quat = Rotation.from_quat(knots.quat[k], scalar_first=True) * Rotation.from_rotvec(step)
    mass = knots.task.mass
    for name, field, value, unit in (
        ("position", "position", knots.position[k] + step, "m"),
        ("velocity", "velocity", knots.velocity[k] + step, "m/s"),
        ("attitude", "quat", quat.as_quat(scalar_first=True), "rad"),
        ("momentum", "momentum", knots.momentum[k] / mass + step, "kg m2/s"),
    ):
        found, defect = dynamics_defects(changed(knots, (field, k, value)))[f"dynamics_{name}"]
        scale = mass if name == "momentum" else 1.0
        assert found == unit
        assert defect[k - 1] == pytest.approx(0.02 * scale, rel=1e-3)
        assert defect[k] > 0.01 * scale
        assert np.delete(defect, [k - 1, k]).max() < 1e-6


def test_a_lost_force_is_a_lost_acceleration(knots):
    defects = dynamics_defects(changed(knots, ("force", 3, 0, 0.0)))
    expected = np.abs(knots.force[3, 0]).max() / knots.task.mass * knots.dt[3]
    assert defects["dynamics_velocity"][1][3] == pytest.approx(expected, rel=1e-6)


def test_names_and_phases(knots):
    found = violations(knots)
    dynamics = ["position", "velocity", "attitude", "momentum"]
    dynamics += ["feet", "feet_velocity", "force", "duration", "shortfall"]
    # There is nothing in the way that the body would have to clear, and nothing is given up.
    unchecked = ("body_clearance", "shortfall")
    constraints = [c.name for c in CONSTRAINTS if c.name not in unchecked]
    assert list(found) == [*(f"dynamics_{d}" for d in dynamics), *constraints]
    for violation in found.values():
        assert violation.phase in ("take-off", "flight", "landing")
        assert 0 <= violation.time <= knots.time[-1]


@pytest.mark.parametrize("number", [np.nan, np.inf, 0.0])
def test_what_is_no_number_is_the_worst(knots, number):
    """Of every variable, as a solver that diverges leaves it: violated, and nothing raises."""
    layout, places = knots.layout, {}
    for knot in range(layout.knots):
        for name, place in layout.variables(knot).items():
            places.setdefault((name, knot == 0), place)
    if number == 0.0:  # no attitude either
        places = {"quat": layout.variables(5)["quat"]}
    else:
        places["all"] = slice(None)
    for name, place in places.items():
        w = knots.variables.copy()
        w[place] = number
        with np.errstate(all="ignore"):
            diverged = unpack(w, layout, knots.task, knots.model, knots.evaluate)
            found = violations(diverged)
            assert not satisfied(found), name
            assert np.inf in [violation.amount for violation in found.values()], name
            assert " by inf " in describe_worst(found, diverged)
            assert stops(diverged)
            for constraint in AGREED:
                constraint.agreed_bounds(diverged)
                constraint.leaning(diverged, 3, 1.0)
            assert not np.isfinite(correction(diverged)).all() or name != "all"


@pytest.mark.parametrize(
    ("name", "k", "unit", "scale"),
    [
        ("feet", 20, "m", 1.0),
        ("feet_velocity", 20, "m/s", 1.0),
        ("force", 5, "N", 30.4754 * 9.81 / 4),
        ("duration", 5, "s", 1.0),
    ],
)
def test_gaps_of_every_state_are_violations(knots, name, k, unit, scale):
    value = variable(knots, name, k)
    value[0] += 0.02
    found = violations(changed(knots, (name, k, value)))[f"dynamics_{name}"]
    assert found.amount == pytest.approx(0.02 * scale, rel=1e-6)
    assert found.unit == unit
    assert found.time in knots.time[[k - 1, k]]


def test_legs_that_are_too_short_are_a_violation(knots):
    """Feet a metre below their hips, of legs that are half as long, by inverse kinematics."""
    feet = variable(knots, "feet", 20).reshape(4, 3) - [0.0, 0.0, 0.6]
    found = violations(changed(knots, ("feet", 20, feet.ravel())))["legs_reach"]
    assert found.amount > 0.3
    assert found.phase == "flight"


def test_the_tolerance_counts_as_satisfied():
    at = {"reach": Violation(TOLERANCE, "m", "flight", 0.5)}
    beyond = {"reach": Violation(1.01 * TOLERANCE, "m", "flight", 0.5)}
    assert satisfied(at)
    assert not satisfied(beyond)


def test_the_worst_three_in_words():
    found = {
        "a": Violation(0.002, "m", "flight", 0.5),
        "b": Violation(3.0, "N", "take-off", 0.123),
        "c": Violation(0.0, "m", "landing", 1.0),
        "d": Violation(0.1234, "rad", "landing", 1.0),
        "e": Violation(0.01, "s", "flight", 0.456),
    }
    assert describe_worst(found) == (
        "d is violated by 0.123 rad in landing at 1.00 s; "
        "b is violated by 3 N in take-off at 0.12 s; "
        "e is violated by 0.01 s in flight at 0.46 s"
    )


def test_nothing_violated_and_yet_no_optimum():
    found = {"a": Violation(0.0, "m", "flight", 0.5)}
    assert describe_worst(found) == "no constraint is violated, the optimum was not reached"


@pytest.mark.parametrize(
    ("limit", "tighter", "measured"),
    [
        ("reach_max", 0.45, lambda k: np.linalg.norm(k.feet_in_hip[1:-1], axis=-1).max()),
        ("flight_min", 0.5, lambda k: k.durations[1]),
        ("friction", 0.1, lambda k: np.nanmax(sideways(k.force)) * np.sqrt(2)),
        # Of the check, 10 % beyond the share are allowed; at the fastest instants, lift-off and
        # touchdown, 1/9 of the share more, and 1 %.
        ("torque_share", 0.4, lambda k: np.abs(k.loads.joint_torque / 40.0).max() - 0.10),
        ("speed_share", 0.3, lambda k: 0.9 * (np.abs(k.loads.knot_velocity / 15.0).max() - 0.01)),
    ],
)
def test_stops_name_the_limit_and_what_it_would_have_to_be(knots, limit, tighter, measured):
    """A plan that kept the robot's limits, looked at under a tighter one."""
    task = make_task(knots.task.jump, load_robot("anymal"), None, {limit: tighter})
    stop, *others = stops(knots.under(task))
    assert (stop.limit, stop.value) == (limit, tighter)
    assert stop.needed == pytest.approx(measured(knots), rel=0.02)
    # A share of the torque also counts at speed, which has no limit of its own.
    expected = ["torque_at_speed"] if limit == "torque_share" else []
    assert [other.constraint for other in others] == expected


def sideways(force):
    loaded = np.where(force[..., 2] > 1.0, force[..., 2], np.nan)
    return np.abs(force[..., :2]).max(axis=-1) / loaded


def test_stops_of_what_no_limit_mends(knots):
    position = knots.position[20] + [0.0, 0.02, 0.0]
    first = stops(changed(knots, ("position", 20, position)))[0]
    assert (first.constraint, first.limit) == ("dynamics_position", None)
    assert str(first).startswith("the centre of mass jumps by 0.02 m in flight")
    assert stops(knots) == ()


def test_every_constraint_is_named_in_words(knots):
    names = {c.name for c in CONSTRAINTS} | violations(knots).keys()
    unworded = {name for name in names if broken_in_words(name).startswith(name)}
    assert not unworded
