"""Limits: what there is, what is refused, and that a changed one holds in the plan."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from llsrbm.errors import InputError
from llsrbm.models.drives import LONGEST_LEG, SHORTEST_LEG, widest_box
from llsrbm.planning.answer.planner import planner_for, planner_of
from llsrbm.planning.problem.constraints import CONSTRAINTS
from llsrbm.planning.problem.jump_horizon import row_bounds
from llsrbm.planning.problem.placement import limits_of, make_task
from llsrbm.planning.problem.violations import TOLERANCE, violations
from llsrbm.planning.replan.under_way import relaxed_limits
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.request.jump import Jump
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot

ANYMAL, SLIDER = load_robot("anymal"), load_robot("slider")
ROBOTS = {"anymal": ANYMAL, "slider": SLIDER, "go2": load_robot("go2")}
every_robot = pytest.mark.parametrize("name", ROBOTS)


# ---- what there is


@every_robot
def test_every_default_is_the_robots_and_in_range(name):
    file, limits = ROBOTS[name].file, limits_of(ROBOTS[name])
    for limit, value in limits.values():
        assert limit.lowest <= value <= limit.highest, limit.name
        assert limit.lowest < limit.highest, limit.name
        assert limit.effect
        assert limit.title
    assert limits["friction"][1] == file.limits.friction
    assert limits["reach_max"][1] == file.reach.distance[1]
    assert limits["flight_min"][1] == file.timing.flight[0]
    assert limits["torque_share"][1] == file.limits.torque_share
    assert limits["speed_share"][1] == file.limits.speed_share
    assert limits["reach_standing"][1] == file.reach.standing


@every_robot
def test_no_reach_is_wider_than_the_one_for_which_stops_have_rows(name):
    """Neither a request's nor that of a motion planned anew after such a request."""
    robot, reach = ROBOTS[name], ROBOTS[name].file.reach
    ends = {n: limit.loosest for n, (limit, _) in limits_of(robot).items() if "reach_" in n}
    least, most = widest_box(robot)
    widest = make_task(Jump(robot=name), robot, limits=ends)
    plain = make_task(Jump(robot=name), robot)
    for task in (widest, relaxed_limits(widest), relaxed_limits(plain)):
        assert (np.array(task.reach.lower) >= least - 1e-9).all()
        assert (np.array(task.reach.upper) <= most + 1e-9).all()
        shortest, longest = np.divide(task.reach.distance, reach.distance)
        assert shortest >= SHORTEST_LEG - 5e-3  # limits are said with three digits
        assert longest <= LONGEST_LEG + 5e-3
    assert not (np.array(widest.reach.upper) <= reach.upper).all()


def test_a_robot_has_the_limits_of_what_it_has():
    """Points do not turn, stops that are turns away are no limits, and slides are no knees."""
    soles = {"foot_yaw_min", "foot_yaw_max", "foot_turn_speed"}
    assert set(limits_of(SLIDER)) - set(limits_of(ANYMAL)) == {*soles, "stop_margin"}
    assert set(limits_of(ANYMAL)) - set(limits_of(SLIDER)) == {"knee_margin", "legs_apart"}


def test_names_are_unique():
    names = [limit.name for constraint in CONSTRAINTS for limit in constraint.limits]
    assert len(names) == len(set(names))


@every_robot
@settings(max_examples=5, deadline=None)
@given(data=st.data())
def test_only_the_named_limits_change(name, data):
    robot = ROBOTS[name]
    limits = limits_of(robot)
    # One of a pair alone may cross the other; that is refused, below.
    names = data.draw(
        st.sets(st.sampled_from([n for n in limits if n[-4:] not in ("_min", "_max")]))
    )
    given_ = {n: data.draw(st.floats(limits[n][0].lowest, limits[n][0].highest)) for n in names}
    task = make_task(Jump(robot=name), robot, None, given_)
    assert task.tuning == Tuning(limits=given_)
    for limit, value in limits.values():
        assert limit.of(task) == given_.get(limit.name, value)


@every_robot
def test_the_same_bounds_are_infinite_whatever_the_limits(name):
    """Fatrop looks at that only in its first solve."""
    robot = ROBOTS[name]
    layout = layout_of(Jump(robot=name), robot, 12)
    own = row_bounds(layout, make_task(Jump(robot=name, height=0.1), robot))
    for n, (limit, _) in limits_of(robot).items():
        for end in (limit.lowest, limit.highest):
            try:
                task = make_task(Jump(robot=name, height=0.1), robot, None, {n: end})
            except InputError:  # it crosses the other of its pair
                continue
            for one, other in zip(row_bounds(layout, task), own, strict=True):
                np.testing.assert_array_equal(np.isfinite(one), np.isfinite(other))


# ---- what is refused


@pytest.mark.parametrize(
    ("limits", "parts"),
    [
        ({"fricton": 0.4}, ["unknown limit 'fricton'", "of anymal are", *limits_of(ANYMAL)]),
        ({"foot_yaw_max": 0.4}, ["unknown limit 'foot_yaw_max'"]),
        ({"friction": 2.0}, ["limit friction: 2 is out of range", "anymal takes 0.1 to 1.5"]),
        ({"contact_force": 100.0}, ["unknown limit 'contact_force'"]),
        ({"foot_speed": 0.5}, ["foot_speed: 0.5 m/s", "1 to 15 m/s"]),
        ({"foot_speed": np.nan}, ["foot_speed: nan m/s is out of range"]),
        ({"torque_share": 0.1}, ["torque_share: 0.1 is out of range", "0.2 to 3"]),
        ({"flight_min": 0.7}, ["flight_min 0.7 s and flight_max 0.6 s leave no room", "0.001 s"]),
        ({"flight_max": 0.4, "flight_min": 0.4}, ["flight_min 0.4 s and flight_max 0.4 s"]),
    ],
)
def test_limits_that_are_none(limits, parts):
    with pytest.raises(InputError) as caught:
        make_task(Jump(), ANYMAL, None, limits)
    assert "\n" not in str(caught.value)
    for part in parts:
        assert part in str(caught.value)


# ---- what they do to a plan


def torque_share(plan):
    """By Pinocchio; the last knot stands."""
    return np.abs(plan.joint_torque[:-1]).max() / 40.0


def speed_share(plan):
    """Between knots."""
    rate = np.diff(plan.joint_position, axis=0) / np.diff(plan.time)[:, None]
    return np.abs(rate).max() / 15.0


def lowest_hips(plan):
    """Above feet that stand, as a share of the default posture's."""
    standing = np.append(plan.contact[:-1].all(axis=1), False)
    standing[0] = False
    stands = (ANYMAL.base_position + ANYMAL.hips - ANYMAL.feet)[:, 2].mean() - ANYMAL.foot_lift
    return -plan.foot_in_hip[standing, :, 2].max() / stands


def sideways(plan):
    f = plan.contact_force[plan.contact_force[..., 2] > 1.0]
    return (np.abs(f[:, :2]).max(axis=1) / f[:, 2]).max()


def duration(phase):
    return lambda plan: np.diff(plan.phase_start)[phase]


def longest_leg(plan):
    return np.linalg.norm(plan.foot_in_hip[1:-1], axis=-1).max()


def flying(plan):
    first, last = np.flatnonzero(~plan.contact.any(axis=1))[[0, -1]]
    return slice(first, last + 2)


def box(pick, axis):
    return lambda plan: pick(plan.foot_in_hip[1:-1, :, axis])


def highest_foot(plan):
    return plan.foot_position[flying(plan)][..., 2].max(axis=0).min()


def nearest_feet(plan):
    feet = plan.foot_in_hip[flying(plan)][1:-1]
    model = planner_for("anymal", "llsrbm-plus").model
    seen = model.hips + model.mirrors * feet
    apart = [
        np.linalg.norm((seen[:, i] - seen[:, j])[:, :2], axis=-1)
        for i in range(4)
        for j in range(i)
    ]
    return np.min(apart)


def foot_speed(plan):
    """In the world along base axes, by differences, at midpoints as the planner has them."""
    from scipy.spatial.transform import Rotation, Slerp

    at = flying(plan)
    time, feet = plan.time[at], plan.foot_position[at]
    middle = Slerp(time, Rotation.from_quat(plan.base_quat[at], scalar_first=True))(
        (time[1:] + time[:-1]) / 2
    )
    speed = np.diff(feet, axis=0) / np.diff(time)[:, None, None]
    return np.abs(np.einsum("kji,klj->kli", middle.as_matrix(), speed)).max()


TWIST, FORWARD = {"twist": 1.6}, {"forward": 0.5}
SLOW = {"time": 0.01}  # otherwise phases are as short as they may be, and no longest one binds

# name: a value that binds, what is measured of the plan, by how much that may differ from what the
# planner bounds (knots against midpoints, the whole body's torques against a leg's).
BINDING = {
    "friction": (0.2, sideways, 1e-3),
    "takeoff_min": (0.7, duration(0), 1e-3),
    "takeoff_max": (0.45, duration(0), 1e-3),
    "flight_min": (0.45, duration(1), 1e-3),
    "landing_min": (0.7, duration(2), 1e-3),
    "landing_max": (0.55, duration(2), 1e-3),
    "reach_max": (0.5, longest_leg, 1e-3),
    "reach_x_min": (-0.1, box(np.min, 0), 1e-3),
    "reach_x_max": (0.12, box(np.max, 0), 1e-3),
    "reach_z_min": (-0.49, box(np.min, 2), 1e-3),
    "clearance": (0.15, highest_foot, 1e-3),
    "feet_apart": (0.35, nearest_feet, 1e-3),
    "torque_share": (0.5, torque_share, 0.1),
    "speed_share": (0.55, speed_share, 0.05),
    "reach_standing": (0.9, lowest_hips, 1e-3),
}
# Jump, weights, and limits that bind it together.
TOGETHER = (
    (FORWARD, {}, ("takeoff_min", "flight_min", "landing_min", "clearance")),
    (FORWARD, {}, ("reach_x_min", "reach_x_max", "reach_z_min", "speed_share")),
    (FORWARD, {}, ("reach_max",)),
    (FORWARD, {}, ("reach_standing",)),
    (FORWARD, {}, ("torque_share",)),
    (FORWARD, SLOW, ("takeoff_max", "landing_max")),
    (TWIST, {}, ("feet_apart",)),
    (TWIST, {}, ("friction",)),
)


def planned(motion, weights, limits):
    jump = Jump(**motion)
    planner = planner_of(jump, limits=limits)
    return planner.plan(jump, weights=weights, limits=limits, patient=False)


@cache
def plan_of(*, weight=None, **motion):
    """Under the robot's own limits."""
    return planned(motion, {} if weight is None else {"time": weight}, {})


@pytest.mark.parametrize(("motion", "weights", "names"), TOGETHER, ids=str)
def test_limits_bind_in_the_plan(motion, weights, names):
    """Measured in the plan's arrays: what was beyond a limit is at it, in the checks as well."""
    limits = {name: BINDING[name][0] for name in names}
    free = plan_of(**motion, weight=weights.get("time"))
    bound = planned(motion, weights, limits)
    for name, value in limits.items():
        _, measured, tolerance = BINDING[name]
        side = -1 if limits_of(ANYMAL)[name][0].lower_bound else 1
        assert side * (measured(free) - value) > 2 * tolerance, name
        assert side * (measured(bound) - value) <= tolerance, name
    assert max(v.amount for v in bound.violations.values()) <= TOLERANCE
    assert bound.tuning == Tuning(weights, limits)


# Of the same rows as limits that bind above: the numbers that these rows have.
BOUNDS = {
    "flight_max": (0.4, lambda task: task.times(1)[1]),
    "reach_min": (0.3, lambda task: task.reach.distance[0]),
    "reach_y_min": (-0.1, lambda task: task.reach.lower[1]),
    "reach_y_max": (0.1, lambda task: task.reach.upper[1]),
    "reach_z_max": (-0.275, lambda task: task.reach.upper[2]),
}


@pytest.mark.parametrize("name", BOUNDS)
def test_limits_of_the_same_rows_are_their_bounds(name):
    value, bound = BOUNDS[name]
    assert bound(make_task(Jump(), ANYMAL, None, {name: value})) == pytest.approx(value)


@pytest.mark.parametrize(
    ("name", "value", "measured"),
    [
        ("torque_share", 0.5, lambda plan: 40.0 * (torque_share(plan) - 0.10)),
        ("foot_speed", 1.0, foot_speed),
    ],
)
def test_the_checks_use_the_changed_limit(name, value, measured):
    """A plan under the robot's limits, checked against a tighter one."""
    planner = planner_for("anymal", "llsrbm-plus")
    plan = planner.plan(Jump(model="llsrbm-plus", **FORWARD))
    knots = planner.last_knots()
    task = make_task(knots.task.jump, ANYMAL, None, {name: value})
    constraint = {"torque_share": "joint_torque"}.get(name, name)
    bound = value * (40.0 if name == "torque_share" else 1.0)
    amount = violations(replace(knots, task=task))[constraint].amount
    assert amount == pytest.approx(measured(plan) - bound, rel=0.03)
    assert violations(knots)[constraint].amount <= TOLERANCE


def test_every_limit_of_a_point_foot_is_measured():
    # Knees and legs side by side are measured in `test_knees`, battery and strength of drives in
    # `motion/test_robot`, the apex in `whole_body/test_tops`.
    others = {"foot_speed", "knee_margin", "legs_apart", "apex_min", "apex_max"}
    others |= {"battery", "drive_strength"}
    assert {*BINDING, *BOUNDS, *others} == set(limits_of(ANYMAL))
    assert sorted(name for _, _, names in TOGETHER for name in names) == sorted(BINDING)
