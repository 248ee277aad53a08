"""Each constraint on a plan that was made to break it by a known amount."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm import models
from llsrbm.planning.constraints import CONSTRAINTS
from llsrbm.planning.layout import Intervals
from llsrbm.planning.residuals import violations
from llsrbm.robots import load_robot
from llsrbm.trajectory.plan import Phase
from tests.llsrbm.planning.solved import REQUESTS, solved

NAMED = {c.name: c for c in CONSTRAINTS}
ROBOT = load_robot("anymal")
MASS, FILE = ROBOT.mass, ROBOT.file
LIMITS, REACH, TIMING = FILE.limits, FILE.reach, FILE.timing
FIRST = Intervals().takeoff  # lift-off, touchdown and mid-flight
LAST = FIRST + Intervals().flight
MIDDLE = (FIRST + LAST) // 2
LEG = 1


def base():
    """A plan whose base stays put relative to the CoM, which keeps amounts easy to say."""
    return solved("srbm", "twist").knots


def changed(name, index, value):
    """The plan with one entry of an array replaced."""
    array = getattr(base(), name).copy()
    array[index] = value
    return replace(base(), **{name: array})


def swing_to(foot):
    """The plan with a leg's foot at `foot` in its hip frame at mid-flight."""
    return changed("flight_feet", (MIDDLE - FIRST, LEG), foot)


def momentum_balance():
    step = np.array([0.0, 0.0, 2.0])
    knots = changed("momentum", MIDDLE, base().momentum[MIDDLE] + step)
    # The mean over an interval follows from its first knot; the twist keeps z upright.
    return knots, 2.0, "flight", {base().time[MIDDLE]}


def given_contacts():
    foot = base().flight_feet[-1, LEG] + [0.0, 0.0, 0.04]
    return changed("flight_feet", (-1, LEG), foot), 0.04, "landing", {base().time[LAST]}


def friction_pyramid():
    force = [LIMITS.friction * 100 + 7.0, -20.0, 100.0]
    return changed("force", (3, LEG), force), 7.0, "take-off", {base().time[3]}


def contact_force():
    force = [0.0, 0.0, LIMITS.contact_force + 11.0]
    return changed("force", (LAST + 2, LEG), force), 11.0, "landing", {base().time[LAST + 2]}


def phase_times():
    low, _ = TIMING.flight
    return changed("durations", 1, low - 0.07), 0.07, "flight", {base().time[FIRST]}


def reach():
    return swing_to([0, 0, -REACH.distance[1] - 0.03]), 0.03, "flight", {base().time[MIDDLE]}


def clearance():
    progress = (MIDDLE - FIRST) / (LAST - FIRST)
    arch = 4 * progress * (1 - progress) * LIMITS.clearance
    low = base().foot_position[MIDDLE][:, 2].min()
    fall = 0.05 + low - arch  # the lowest foot then is 5 cm below the arch, the ground being at 0
    position = base().position[MIDDLE] - [0, 0, fall]
    return changed("position", MIDDLE, position), 0.05, "flight", {base().time[MIDDLE]}


def feet_apart():
    feet = base().flight_feet[MIDDLE - FIRST].copy()
    # Both front feet 4 cm from each other about the middle plane.
    for leg in (0, 1):
        feet[leg] = [0.0, 0.02 - abs(base().model.hips[leg, 1]), -0.4]
    knots = changed("flight_feet", MIDDLE - FIRST, feet)
    return knots, LIMITS.feet_apart - 0.04, "flight", {base().time[MIDDLE]}


def foot_speed():
    """Five times the limit at mid-interval, all of it along one axis of the base."""
    k = MIDDLE
    R, _, v = (a[k] for a in base().mid)
    beta = (
        R.T
        @ (
            base().foot_position[k]
            + base().foot_position[k + 1]
            - base().position[k : k + 2].sum(axis=0)
        )[LEG]
        / 2
    )
    at_rest = R.T @ v + np.cross(base().rotation_rate[k], beta)
    wanted = np.array([LIMITS.foot_speed + 2.0, 0.0, 0.0])
    rate = base().model.mirrors[LEG] * (wanted - at_rest)
    return changed("flight_feet_rate", (k - FIRST, LEG), rate), 2.0, "flight", {base().time[k]}


def foot_speed_in_base():
    rate = [0.0, -LIMITS.foot_speed_in_base[1] - 0.3, 0.0]
    knots = changed("flight_feet_rate", (MIDDLE - FIRST, LEG), rate)
    return knots, 0.3, "flight", {base().time[MIDDLE]}


def knee_speed():
    """A leg that folds straight up; the knee's angle by the law of cosines, by differences."""
    a, b = base().task.knee
    length, closing, step = 0.4, 3.0, 1e-6

    def angle(at):
        return np.arccos((a**2 + b**2 - at**2) / (2 * a * b))

    speed = closing * (angle(length + step) - angle(length - step)) / (2 * step)
    feet, rate = base().flight_feet.copy(), base().flight_feet_rate.copy()
    k = MIDDLE - FIRST
    feet[k : k + 2, LEG] = [0, 0, -length]
    rate[k, LEG] = [0, 0, closing]
    knots = replace(base(), flight_feet=feet, flight_feet_rate=rate)
    return knots, speed - 0.75 * LIMITS.joint_speed, "flight", {base().time[MIDDLE]}


def final_state():
    turned = Rotation.from_rotvec([0.02, 0, 0]) * Rotation.from_quat(
        base().quat[-1], scalar_first=True
    )
    quat = turned.as_quat(scalar_first=True)
    return changed("quat", -1, quat), 0.02, "landing", {base().time[-1]}


BROKEN = [
    momentum_balance,
    given_contacts,
    friction_pyramid,
    contact_force,
    phase_times,
    reach,
    clearance,
    feet_apart,
    foot_speed,
    foot_speed_in_base,
    knee_speed,
    final_state,
]


def test_every_constraint_has_its_example():
    """What concerns soles is broken in test_sole_constraints."""
    assert {make.__name__ for make in BROKEN} | {"edge", "foot_yaw", "foot_turn"} == set(NAMED)


@pytest.mark.parametrize("make", BROKEN, ids=lambda make: make.__name__)
def test_seen_with_the_right_amount_at_the_right_place(make):
    knots, amount, phase, times = make()
    found = violations(knots)[make.__name__]
    assert found.amount == pytest.approx(amount, rel=1e-3, abs=2e-4)
    assert found.phase == phase
    assert found.time in times
    assert found.unit == NAMED[make.__name__].unit
    assert violations(base())[make.__name__].amount < 1e-4


@pytest.mark.parametrize("request_name", REQUESTS)
@pytest.mark.parametrize("model", models.names())
def test_plans_keep_every_constraint(model, request_name):
    knots = solved(model, request_name).knots
    for constraint in CONSTRAINTS:
        amount = constraint.violation(knots)
        assert amount.shape == knots.time.shape
        assert (amount >= 0).all()
        assert amount.max() < 1e-4, constraint.name


@pytest.mark.parametrize(
    ("change", "name", "amount"),
    [
        (("force", (0, 0), [0, 0, -3.0]), "contact_force", 3.0),
        (("force", (0, 0), [0, -60.0, 100.0]), "friction_pyramid", 10.0),
        (("durations", 0, TIMING.takeoff[1] + 0.2), "phase_times", 0.2),
        (("quat", -1, [0, 0, 0, 1]), "final_state", np.pi / 2),
        (("velocity", -1, [0, 0, -0.3]), "final_state", 0.3),
        (("momentum", -1, [0, 0.4 * MASS, 0]), "final_state", 0.4),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_the_other_ways_to_break_them(change, name, amount):
    assert violations(changed(*change))[name].amount == pytest.approx(amount, abs=1e-4)


@pytest.mark.parametrize(
    ("foot", "amount"),
    [
        ([REACH.upper[0] + 0.02, 0, -0.4], 0.02),
        ([0, REACH.lower[1] - 0.05, -0.4], 0.05),
        ([0, 0, REACH.upper[2] + 0.04], REACH.distance[0] - abs(REACH.upper[2] + 0.04)),
    ],
)
def test_reach_has_a_box_and_a_shortest_distance(foot, amount):
    assert violations(swing_to(foot))["reach"].amount == pytest.approx(amount)


def test_reach_in_stance_is_measured_from_the_hip():
    position = base().position[5] + [0, 0, 0.2]
    knots = changed("position", 5, position)
    R = base().R_world_base[5]
    hips = position + (base().model.hips + base().evaluated[0][5]) @ R.T
    longest = np.linalg.norm(base().task.start_feet - hips, axis=1).max()
    below = np.max(REACH.lower[2] - (base().task.start_feet - hips) @ R[:, 2])
    found = violations(knots)["reach"]
    assert found.amount == pytest.approx(max(longest - REACH.distance[1], below))
    assert found.phase == "take-off"


def test_a_box_is_cleared_before_the_feet_are_above_it():
    """Landing surface 0.15 m up: from half way on the feet are above it, and above the arch."""
    knots = solved("llsrbm-plus", "all").knots
    heights = knots.foot_position[knots.flight][..., 2]
    s = np.linspace(0, 1, len(heights))
    arch = 4 * s * (1 - s) * knots.task.limits.clearance
    late = s >= 0.5
    late[-1] = False  # the feet are on the box
    assert (heights[late] >= 0.15 + arch[late, None] - 1e-4).all()
    assert (heights[1:-1] >= arch[1:-1, None] - 1e-4).all()


def test_feet_start_and_stop_gently():
    """The speed allowed in the first and last interval is about a quarter of the limit."""
    for model in models.names():
        speed = np.abs(solved(model, "all").knots.foot_velocity_base)
        s = 0.5 / len(speed)
        assert max(speed[0].max(), speed[-1].max()) < 8 * s * (1 - s) * LIMITS.foot_speed + 1e-4


def test_legs_without_a_knee_are_left_free():
    knots, amount, _, _ = knee_speed()
    assert amount > 1
    free = replace(knots, task=replace(knots.task, knee=None))
    assert violations(free)["knee_speed"].amount == 0
    layout = solved("srbm", "twist").planner.layout
    low, high = NAMED["knee_speed"].bounds(free.task, layout, FIRST)
    assert np.isinf([low, high]).all()


def test_phases_and_roles():
    layout = solved("srbm", "twist").planner.layout
    for k, role in enumerate(layout.roles):
        applies = {c.name for c in CONSTRAINTS if c.applies(role)}
        assert ("friction_pyramid" in applies) == ("contact_force" in applies) == role.in_contact
        assert ("final_state" in applies) == (k == layout.knots - 1)
        assert ("given_contacts" in applies) == (k in (FIRST, LAST))
        assert ("foot_speed_in_base" in applies) == (role.phase == Phase.FLIGHT)
