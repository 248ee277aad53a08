"""Each constraint on a plan that was made to break it by a known amount."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from llsrbm import models
from llsrbm.planning.problem.constraints import CONSTRAINTS
from llsrbm.planning.problem.constraints.drives import (
    COMPARED_SPEED_ALLOWANCE,
    COMPARED_TORQUE_ALLOWANCE,
)
from llsrbm.planning.problem.knots import feet_from_com
from llsrbm.planning.why.residuals import phase_name, violations
from llsrbm.robots import load_robot
from llsrbm.robots.drives import torque_in_direction
from tests.llsrbm.planning.solved import REQUESTS, TYPES, solved

NAMED = {c.name: c for c in CONSTRAINTS}
ROBOT = load_robot("anymal")
MASS, FILE = ROBOT.mass, ROBOT.file
LIMITS, REACH, TIMING = FILE.limits, FILE.reach, FILE.timing
FIRST, LAST = 16, 32  # lift-off, touchdown and mid-flight
MIDDLE = (FIRST + LAST) // 2
LEG = 1
BIPED = ("llsrbm-plus", "slider")


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
    return changed("air_feet", (MIDDLE, LEG), foot)


def momentum_balance():
    step = np.array([0.0, 0.0, 2.0])
    knots = changed("momentum", MIDDLE, base().momentum[MIDDLE] + step)
    # The mean over an interval follows from its first knot; the twist keeps z upright.
    return knots, 2.0, "flight", {base().time[MIDDLE]}


def given_contacts():
    foot = base().air_feet[LAST, LEG] + [0.0, 0.0, 0.04]
    return changed("air_feet", (LAST, LEG), foot), 0.04, "landing", {base().time[LAST]}


def friction_pyramid():
    force = [LIMITS.friction * 100 / np.sqrt(2) + 7.0, -20.0, 100.0]
    return changed("force", (3, LEG), force), 7.0, "take-off", {base().time[3]}


def feet_at_rest():
    """The base stays put against the CoM, so a foot's velocity is its hip frame's."""
    rate = base().knot_rate[LAST, LEG] + [0.0, 0.2, 0.0]
    knots = changed("knot_rate", (LAST, LEG), rate)
    return knots, 0.2, "landing", {base().time[LAST]}


def phase_times():
    low, _ = TIMING.flight
    return changed("durations", 1, low - 0.07), 0.07, "flight", {base().time[FIRST]}


def reach():
    return swing_to([0, 0, -REACH.distance[1] - 0.03]), 0.03, "flight", {base().time[MIDDLE]}


def clearance():
    progress = (MIDDLE - FIRST) / (LAST - FIRST)
    arch = (4 * progress * (1 - progress)) ** 2 * LIMITS.clearance
    low = base().foot_position[MIDDLE][:, 2].min()
    fall = 0.05 + low - arch  # the lowest foot then is 5 cm below the arch, the ground being at 0
    position = base().position[MIDDLE] - [0, 0, fall]
    return changed("position", MIDDLE, position), 0.05, "flight", {base().time[MIDDLE]}


def feet_apart():
    feet = base().air_feet[MIDDLE].copy()
    # Both front feet 4 cm from each other about the middle plane.
    for leg in (0, 1):
        feet[leg] = [0.0, 0.02 - abs(base().model.hips[leg, 1]), -0.4]
    knots = changed("air_feet", MIDDLE, feet)
    return knots, LIMITS.feet_apart - 0.04, "flight", {base().time[MIDDLE]}


def foot_speed():
    """Five times the limit at mid-interval, all of it along one axis of the base."""
    k, model = MIDDLE, base().model
    R, _, v = (a[k] for a in base().mid)
    omega, half = base().rotation_rate[k], base().dt[k] / 2
    begins = base().evaluated[0][k] + model.hips[LEG]
    begins = begins + model.mirrors[LEG] * base().air_feet[k, LEG]
    wanted = np.array([LIMITS.foot_speed + 2.0, 0.0, 0.0])
    # Of a foot that moves at u against the base: u + omega x (where it begins + u dt / 2).
    turned = np.cross(omega, np.eye(3)).T
    u = np.linalg.solve(np.eye(3) + half * turned, wanted - R.T @ v - turned @ begins)
    rate = model.mirrors[LEG] * u
    knots = changed("air_rate", (k, LEG), rate)
    return knots, 2.0, "flight", {base().time[k]}


def joint_torque():
    """A foot that pushes harder: the torques change by -J^T of the force."""
    k, more = LAST + 3, np.array([60.0, -40.0, 500.0])
    knots = changed("force", (k, LEG), base().force[k, LEG] + more)
    q = np.concatenate([[0, 0, 0, 0, 0, 0, 1], base().loads.joint_position[k]])
    data = ROBOT.model.createData()
    frame, axes = ROBOT.legs[LEG].foot_frame_id, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    J = pin.computeFrameJacobian(ROBOT.model, data, q, frame, axes)[:3, 6:]
    torque = base().loads.joint_torque[k] - J.T @ base().mid[0][k].T @ more
    beyond = np.abs(torque).max() - (0.85 + COMPARED_TORQUE_ALLOWANCE) * 40.0
    assert beyond > 10.0
    return knots, beyond, "landing", {base().time[k]}


def torque_at_speed():
    """Driving at 85 % of the speed limit, half of the torque is left."""
    k, joint = FIRST - 1, 4
    loads = base().loads
    speed, torque = loads.joint_velocity.copy(), loads.joint_torque.copy()
    speed[k, joint], torque[k, joint] = -0.85 * 15.0, -39.0
    knots = replace(base())
    vars(knots)["loads"] = replace(
        loads,
        joint_velocity=speed,
        joint_torque=torque,
        torque_available=torque_in_direction(ROBOT, speed, torque),
    )
    return (
        knots,
        39.0 - 0.85 * 20.0 - COMPARED_TORQUE_ALLOWANCE * 40.0,
        "take-off",
        {base().time[k]},
    )


def joint_speed():
    """The same motion in less time: all joints are faster by that factor."""
    fastest = np.abs(base().loads.joint_velocity).max(axis=1)
    factor = ((0.9 + COMPARED_SPEED_ALLOWANCE) * 15.0 + 1.5) / fastest.max()
    assert factor > 1
    knots = replace(
        base(),
        time=base().time / factor,
        durations=base().durations / factor,
        velocity=base().velocity * factor,
        rotation_rate=base().rotation_rate * factor,
    )
    k = int(fastest.argmax())
    return knots, 1.5, phase_name(knots, k), {knots.time[k]}


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
    feet_at_rest,
    phase_times,
    reach,
    clearance,
    feet_apart,
    foot_speed,
    joint_torque,
    torque_at_speed,
    joint_speed,
    final_state,
]


def test_every_constraint_has_its_example():
    """Those of soles, obstacles, flips and replanning, and the model's truth, are elsewhere."""
    elsewhere = {"edge", "foot_yaw", "foot_turn", "true_turn", "body_clearance", "upright_landing"}
    elsewhere |= {"final_place"}
    assert {make.__name__ for make in BROKEN} | elsewhere == set(NAMED)


@pytest.mark.parametrize("make", BROKEN, ids=lambda make: make.__name__)
def test_seen_with_the_right_amount_at_the_right_place(make):
    knots, amount, phase, times = make()
    found = violations(knots)[make.__name__]
    assert found.amount == pytest.approx(amount, rel=1e-3, abs=2e-4)
    assert found.phase == phase
    assert found.time in times
    assert found.unit == NAMED[make.__name__].unit
    assert violations(base())[make.__name__].amount < 1e-4


@pytest.mark.parametrize(
    ("model", "request_name"),
    [*((m, r) for m in models.names() for r in REQUESTS), *(("llsrbm-plus", t) for t in TYPES)],
)
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
        (("force", (0, 0), [0, 0, -3.0]), "friction_pyramid", 3.0 * LIMITS.friction / np.sqrt(2)),
        (
            ("force", (0, 0), [0, -60.0, 100.0]),
            "friction_pyramid",
            60.0 - 100.0 * LIMITS.friction / np.sqrt(2),
        ),
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
    longest = np.linalg.norm(base().task.places[0].feet - hips, axis=1).max()
    below = np.max(REACH.lower[2] - (base().task.places[0].feet - hips) @ R[:, 2])
    found = violations(knots)["reach"]
    assert found.amount == pytest.approx(max(longest - REACH.distance[1], below))
    assert found.phase == "take-off"


def test_a_box_is_cleared_before_the_feet_are_above_it():
    """Landing surface 0.15 m up: from half way on the feet are above it, and above the arch."""
    knots = solved("llsrbm-plus", "all").knots
    heights = knots.foot_position[FIRST : LAST + 1, :, 2]
    s = np.linspace(0, 1, len(heights))
    arch = (4 * s * (1 - s)) ** 2 * knots.task.limits.clearance
    late = s >= 0.5
    late[-1] = False  # the feet are on the box
    assert (heights[late] >= 0.15 + arch[late, None] - 1e-4).all()
    assert (heights[1:-1] >= arch[1:-1, None] - 1e-4).all()


def feet_in_stance(model, R, position, stood):
    """(L, d) m, rad: x of all feet where they stand."""
    beta = feet_from_com(model, R[None], position[None], stood.feet[None], stood.yaw[None])
    return model.feet_of(beta, np.ones((1, model.legs), dtype=bool))[0]


@pytest.mark.parametrize(("model", "robot"), [*((m, "anymal") for m in models.names()), BIPED])
def test_feet_leave_the_ground_and_meet_it_at_rest(model, robot):
    """Velocities in hip frames at lift-off and touchdown against differences of standing feet's."""
    knots = solved(model, "all" if robot == "anymal" else "twist", robot).knots
    step = 1e-5
    for k, end in ((FIRST, 0), (LAST, -1)):
        stood = knots.task.places[end]
        here = Rotation.from_quat(knots.quat[k], scalar_first=True)
        x = [
            feet_in_stance(
                knots.model,
                (here * Rotation.from_rotvec(t * knots.rotation_rate[k])).as_matrix(),
                knots.position[k] + t * knots.velocity[k],
                stood,
            )
            for t in (-step, step)
        ]
        rate = (x[1] - x[0]) / (2 * step)
        np.testing.assert_allclose(knots.knot_rate[k], rate, atol=1e-3)


def test_feet_speed_up_and_slow_down_within_the_first_and_last_intervals():
    """From rest: the first interval's steps are no larger than the next two's together."""
    for model in models.names():
        speed = np.abs(solved(model, "all").knots.foot_velocity_base[FIRST:LAST])
        assert speed[0].max() < 0.6 * speed.max()
        assert speed[-1].max() < 0.6 * speed.max()


def test_feet_that_swing_while_others_stand_are_held_to_what_swinging_is():
    """Of ANYmal that pushes last with its hind feet; two feet have these rows, two have not."""
    s = solved("llsrbm-plus", "rear-last")
    layout = s.planner.layout
    lift, away, landing = (int(k) for k in layout.first_knots[1:4])
    for k, count in ((lift - 1, 0), (lift, 2), (lift + 1, 2), (away, 4), (landing, 0)):
        role = layout.roles[k]
        for name, per_foot in (("foot_speed", 3), ("friction_pyramid", 4)):
            feet = count if name == "foot_speed" else 4 - count
            constraint = NAMED[name]
            assert constraint.applies(role) == (feet > 0)
            assert len(constraint.bounds(s.task, layout, k)[0]) == per_foot * feet
    edges = {k for k, role in enumerate(layout.roles) if NAMED["given_contacts"].applies(role)}
    assert edges == {lift, away, landing}
    # The front feet are lifted while the hind feet push.
    heights = s.knots.foot_position[lift + 1 : away + 1, :, 2]
    assert (heights[:, :2] > 1e-4).all()
    np.testing.assert_allclose(heights[:, 2:], 0.0, atol=1e-6)


def test_phases_and_roles():
    layout = solved("srbm", "twist").planner.layout
    for k, role in enumerate(layout.roles):
        applies = {c.name for c in CONSTRAINTS if c.applies(role)}
        assert ("friction_pyramid" in applies) == role.in_contact
        assert ("final_state" in applies) == (k == layout.knots - 1)
        assert ("given_contacts" in applies) == ("feet_at_rest" in applies) == (k in (FIRST, LAST))
        moving = 0 < k < layout.knots - 1  # at first the robot stands, and has no joint to choose
        assert ("joint_torque" in applies) == ("torque_at_speed" in applies) == moving
        assert ("joint_speed" in applies) == (FIRST - 1 <= k <= LAST)
