"""Each constraint on a plan that was made to break it by a known amount, in ANYmal's numbers."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.planning.problem.constraints import CONSTRAINTS
from llsrbm.planning.problem.rotations import feet_seen
from llsrbm.planning.problem.violations import violations
from llsrbm.robots import load_robot
from llsrbm.robots.drives.torques import torque_in_direction
from tests.llsrbm.planning.solved import TYPES, changed, solved, variable

NAMED = {c.name: c for c in CONSTRAINTS}
ROBOT = load_robot("anymal")
MASS = 30.4754  # kg
FORCE = MASS * 9.81 / 4  # N, of forces in the solver's units
FIRST, LAST = 16, 32  # lift-off, touchdown and mid-flight
MIDDLE = (FIRST + LAST) // 2
LEG = 1
BIPED = ("llsrbm-plus", "slider")


def base():
    """A plan whose base stays put relative to the CoM, which keeps amounts easy to say."""
    return solved("srbm", "twist").knots


def swing_to(foot):
    """The plan with a leg's foot at `foot` in its hip frame at mid-flight."""
    return changed(base(), ("feet", MIDDLE, LEG, foot))


def attitude(knots, k):
    """In the middle of an interval."""
    half = Rotation.from_rotvec(knots.rotation_rate[k] * knots.dt[k] / 2)
    return (Rotation.from_quat(knots.quat[k], scalar_first=True) * half).as_matrix()


def with_loads(knots, k, joint, speed, torque):
    """The motion with another speed and torque of a joint over an interval."""
    loads, other = knots.loads, replace(knots)
    velocity, effort = loads.joint_velocity.copy(), loads.joint_torque.copy()
    velocity[k, joint], effort[k, joint] = speed, torque
    vars(other)["loads"] = replace(
        loads,
        joint_velocity=velocity,
        joint_torque=effort,
        torque_available=torque_in_direction(ROBOT, velocity, effort),
    )
    return other


def momentum_balance():
    value = base().momentum[MIDDLE] / base().task.mass + [0.0, 0.0, 2.0 / MASS]
    # The mean over an interval follows from its first knot; the twist keeps z upright.
    return changed(base(), ("momentum", MIDDLE, value)), 2.0, "flight", MIDDLE


def given_contacts():
    foot = np.add(variable(base(), "feet", LAST, LEG), [0.0, 0.0, 0.04])
    return changed(base(), ("feet", LAST, LEG, foot)), 0.04, "landing", LAST


def friction_pyramid():
    """A coefficient of 0.5 holds 35.355 N of 100 N along each axis."""
    force = np.array([35.355 + 7.0, -20.0, 100.0]) / FORCE
    return changed(base(), ("force", 3, LEG, force)), 7.0, "take-off", 3


def feet_at_rest():
    """The base stays put against the CoM, so a foot's velocity is its hip frame's."""
    rate = np.add(variable(base(), "feet_velocity", LAST, LEG), [0.0, 0.2, 0.0])
    return changed(base(), ("feet_velocity", LAST, LEG, rate)), 0.2, "landing", LAST


def phase_times():
    """A flight takes 0.3 s at least."""
    return changed(base(), ("next_duration", FIRST - 1, 0.23)), 0.07, "flight", FIRST


def reach():
    """A leg reaches 0.52 m."""
    return swing_to([0, 0, -0.55]), 0.03, "flight", MIDDLE


def clearance():
    """The arch is 8 cm high in the middle; the lowest foot is put 5 cm below that."""
    fall = base().foot_position[MIDDLE, :, 2].min() - 0.03
    position = base().position[MIDDLE] - [0, 0, fall]
    return changed(base(), ("position", MIDDLE, position)), 0.05, "flight", MIDDLE


def feet_apart():
    """Both front feet 4 cm from each other about the middle plane, where 12 cm are kept."""
    hip = abs(base().model.hips[0, 1])
    feet = [("feet", MIDDLE, leg, [0.0, 0.02 - hip, -0.4]) for leg in (0, 1)]
    return changed(base(), *feet), 0.08, "flight", MIDDLE


def foot_speed():
    """7 m/s at mid-interval where 5 are allowed, all of it along one axis of the base."""
    knots, k, model = base(), MIDDLE, base().model
    omega, half = knots.rotation_rate[k], knots.dt[k] / 2
    begins = ROBOT.base_position - ROBOT.com + model.hips[LEG]
    begins = begins + model.mirrors[LEG] * knots.feet_in_hip[k, LEG]
    velocity = attitude(knots, k).T @ (knots.velocity[k] + knots.velocity[k + 1]) / 2
    # Of a foot that moves at u against the base: u + omega x (where it begins + u dt / 2).
    turned = np.cross(omega, np.eye(3)).T
    u = np.linalg.solve(np.eye(3) + half * turned, [7.0, 0, 0] - velocity - turned @ begins)
    step = model.mirrors[LEG] * u - variable(knots, "feet_velocity", k, LEG)
    return changed(knots, ("feet_step", k, LEG, step)), 2.0, "flight", k


def joint_torque():
    """A foot that pushes harder: torques change by -J^T of the force; of 40 Nm 125 % are allowed.

    It acts where the foot's ball touches the ground.
    Models for comparison are given 40 % beyond the 85 % that plans may use.
    """
    k, more = LAST + 3, np.array([60.0, -40.0, 500.0])
    force = variable(base(), "force", k, LEG) + more / FORCE
    q = np.concatenate([[0, 0, 0, 0, 0, 0, 1], base().loads.joint_position[k]])
    data = ROBOT.model.createData()
    frame, axes = ROBOT.legs[LEG].foot_frame_id, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    J = pin.computeFrameJacobian(ROBOT.model, data, q, frame, axes)[:, 6:]
    moment = np.cross([0, 0, -ROBOT.foot_lift], more)
    push = [attitude(base(), k).T @ vector for vector in (more, moment)]
    torque = base().loads.joint_torque[k] - J.T @ np.concatenate(push)
    beyond = np.abs(torque).max() - 50.0
    assert beyond > 10.0
    return changed(base(), ("force", k, LEG, force)), beyond, "landing", k


def torque_at_speed():
    """Driving at 85 % of 15 rad/s, 20 of 40 Nm are left, of which plans may use 85 %."""
    knots = with_loads(base(), FIRST - 1, 4, -12.75, -39.0)
    return knots, 39.0 - 17.0 - 16.0, "take-off", FIRST - 1


def joint_speed():
    """115 % of 15 rad/s are allowed for comparison."""
    return with_loads(base(), MIDDLE, 3, 17.25 + 1.5, 0.0), 1.5, "flight", MIDDLE


def joint_stops():
    """A knee 0.5 rad beyond an end that is 10 % of the range nearer for comparison."""
    knots = replace(base())
    angles = base().postures.joint_position.copy()
    lower, upper = ROBOT.joint_stops
    angles[MIDDLE, 5] = upper[5] + 0.10 * (upper[5] - lower[5]) + 0.5
    vars(knots)["postures"] = replace(base().postures, joint_position=angles)
    return knots, 0.5, "flight", MIDDLE


def legs_reach():
    """A foot that misses its place by 12 cm, of which comparison is given two."""
    knots = replace(base())
    missed = base().postures.residual_m.copy()
    missed[MIDDLE] = 0.12
    vars(knots)["postures"] = replace(base().postures, residual_m=missed)
    return knots, 0.1, "flight", MIDDLE


def final_state():
    turned = Rotation.from_rotvec([0.02, 0, 0]) * Rotation.from_quat(
        base().quat[-1], scalar_first=True
    )
    quat = turned.as_quat(scalar_first=True)
    return changed(base(), ("quat", LAST + 16, quat)), 0.02, "landing", LAST + 16


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
    joint_stops,
    legs_reach,
    final_state,
]


def test_every_constraint_has_its_example():
    """Those of soles, arms, obstacles, flips, replanning, apexes and less jumps are elsewhere."""
    elsewhere = {"edge", "foot_yaw", "foot_turn", "true_turn", "body_clearance", "upright_landing"}
    elsewhere |= {"final_place", "shortfall", "knee_height", "legs_apart", "arms_at_rest"}
    elsewhere |= {"put_down", "rolling", "short_of_turn", "turns_over", "rebound", "apex_height"}
    assert {make.__name__ for make in BROKEN} | elsewhere == set(NAMED)


@pytest.mark.parametrize("make", BROKEN, ids=lambda make: make.__name__)
def test_seen_with_the_right_amount_at_the_right_place(make):
    knots, amount, phase, knot = make()
    found = violations(knots)[make.__name__]
    assert found.amount == pytest.approx(amount, rel=1e-3, abs=2e-4)
    assert found.phase == phase
    assert found.time == knots.time[knot]
    assert found.unit == NAMED[make.__name__].unit
    assert violations(base())[make.__name__].amount < 1e-4


@pytest.mark.parametrize(
    ("model", "request_name"),
    [("srbm", "all"), *(("llsrbm-plus", name) for name in ("all", *TYPES))],
)
def test_plans_keep_every_constraint(model, request_name):
    knots = solved(model, request_name).knots
    for constraint in CONSTRAINTS:
        amount = constraint.violation(knots)
        assert amount.shape == knots.time.shape
        assert (amount >= 0).all()
        assert amount.max() < 1e-4, constraint.name


@pytest.mark.parametrize(
    ("model", "speed", "torque"),
    [("llsrbm-plus", 0.93 * 15.0, 0.95 * 40.0), ("srbm", 1.15 * 15.0, 1.25 * 40.0)],
)
def test_allowances_of_the_drives(model, speed, torque):
    """Beyond 90 % of the speed and 85 % of the torque: 3 and 10 %, for comparison 25 and 40 %."""
    knots = solved(model, "twist").knots
    for share in (0.995, 1.005):
        fast = violations(with_loads(knots, MIDDLE, 3, share * speed, 0.0))["joint_speed"].amount
        strong = violations(with_loads(knots, 3, 3, 0.0, share * torque))["joint_torque"].amount
        assert fast == pytest.approx(max(share - 1, 0) * speed)
        assert strong == pytest.approx(max(share - 1, 0) * torque)


@pytest.mark.parametrize(
    ("change", "name", "amount"),
    [
        (("force", 0, 0, [0, 0, -3.0 / FORCE]), "friction_pyramid", 1.0607),
        (("force", 0, 0, [0, -60.0 / FORCE, 100.0 / FORCE]), "friction_pyramid", 24.6447),
        (("duration", 0, 1.0), "phase_times", 0.2),
        (("quat", 48, [0, 0, 0, 1]), "final_state", np.pi / 2),
        (("velocity", 48, [0, 0, -0.3]), "final_state", 0.3),
        (("momentum", 48, [0, 0.4, 0]), "final_state", 0.4),
        (("feet", MIDDLE, LEG, [0.24, 0, -0.4]), "reach", 0.02),
        (("feet", MIDDLE, LEG, [0, -0.25, -0.4]), "reach", 0.05),
        (("feet", MIDDLE, LEG, [0, 0, -0.18]), "reach", 0.08),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_the_other_ways_to_break_them(change, name, amount):
    assert violations(changed(base(), change))[name].amount == pytest.approx(amount, abs=1e-4)


def test_reach_in_stance_is_measured_from_the_hip():
    position = base().position[5] + [0, 0, 0.2]
    R = Rotation.from_quat(base().quat[5], scalar_first=True).as_matrix()
    hips = position + (base().model.hips + ROBOT.base_position - ROBOT.com) @ R.T
    legs = base().task.places[0].feet + np.array([0, 0, ROBOT.foot_lift]) - hips
    beyond = max(np.linalg.norm(legs, axis=1).max() - 0.52, np.max(-0.56 - legs @ R[:, 2]))
    found = violations(changed(base(), ("position", 5, position)))["reach"]
    assert found.amount == pytest.approx(beyond)
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
    zero = np.zeros(3)
    given = (R, position, zero, zero, stood.feet.T, np.zeros((3, model.legs)), stood.yaw)
    return np.array(feet_seen(model)(*given, np.zeros(model.legs))[0]).T


@pytest.mark.parametrize(("model", "robot"), [("llsrbm-plus", "anymal"), BIPED])
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
        found = variable(knots, "feet_velocity", k).reshape(rate.shape)
        np.testing.assert_allclose(found, rate, atol=1e-3)


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
