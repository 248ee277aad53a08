"""What is planned anew: from a state on, by the laws of motion, to where legs reach."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

import llsrbm
from llsrbm.control.reference import Reference
from llsrbm.control.swing import UnderWay
from llsrbm.control.whole_body import WholeBody
from llsrbm.mechanics import interpolated
from llsrbm.planning.problem.constraints.drives import TORQUE_ALLOWANCE
from llsrbm.planning.replan.replanner import MAX_EXTENSION, Replanner
from llsrbm.planning.replan.under_way import NEED_TORQUE, State, planned_state
from llsrbm.robots import load_robot
from tests.llsrbm.planning.solved import solved

ROBOT = load_robot("anymal")
GRAVITY = np.array([0.0, 0.0, -9.81])
FLIGHT, LANDING = 1, 2
SLOWER = 1e-3  # s either side of an instant, for velocities


@lru_cache(maxsize=1)
def plan():
    return solved("llsrbm-plus", "twist").plan


def state(time, phase, *, velocity=(0.0, 0.0, 0.0), momentum=(0.0, 0.0, 0.0)):
    """On the plan at a time, s, but for what a push has added."""
    of = plan()
    at = {
        name: interpolated(time, of.time, getattr(of, name))
        for name in ("com", "com_velocity", "base_quat", "angular_velocity", "angular_momentum")
    }
    before, after = (interpolated(time + dt, of.time, of.foot_position) for dt in (-SLOWER, SLOWER))
    return State(
        time=time,
        phase=phase,
        com=at["com"],
        com_velocity=at["com_velocity"] + velocity,
        base_quat=at["base_quat"] / np.linalg.norm(at["base_quat"]),
        angular_velocity=at["angular_velocity"],
        angular_momentum=at["angular_momentum"] + momentum,
        foot_position=interpolated(time, of.time, of.foot_position),
        foot_velocity=(after - before) / (2 * SLOWER) + velocity,
        foot_yaw=np.zeros(4),
        foot_yaw_rate=np.zeros(4),
        joints=interpolated(time, of.time, of.joint_position),
        joint_speeds=interpolated(time, of.time, of.joint_velocity),
    )


def found(*states):
    """The newest plan after states in a row."""
    replanner = Replanner(plan(), ROBOT)
    for each in states:
        answer = replanner.replan(each)
        assert answer.plan is not None
    return answer.plan


def rest(new, start):
    """Knots from a time on."""
    return np.flatnonzero(new.time >= start - 1e-9)


def test_where_nothing_has_happened_the_plan_stays():
    start = plan().lift_off + 0.06
    new = found(state(start, FLIGHT))
    assert new.phase_start == pytest.approx(plan().phase_start, abs=2e-3)
    assert new.com[-1] == pytest.approx(plan().com[-1], abs=2e-3)
    assert new.foot_position[-1] == pytest.approx(plan().foot_position[-1], abs=2e-3)
    times = np.linspace(start, plan().time[-1], 50)
    off = interpolated(times, new.time, new.com) - interpolated(times, plan().time, plan().com)
    assert np.abs(off).max() < 0.02


@pytest.mark.parametrize(
    ("velocity", "momentum"),
    [
        ((-0.4, 0.0, -0.2), (0.0, 0.0, 0.0)),
        ((0.2, 0.2, 0.2), (0.3, -0.3, 0.2)),
    ],
)
def test_a_pushed_robot_flies_on_by_the_laws_of_motion(velocity, momentum):
    at = state(plan().lift_off + 0.1, FLIGHT, velocity=velocity, momentum=momentum)
    new = found(at)
    knots = rest(new, at.time)
    flying = knots[new.time[knots] <= new.phase_start[LANDING] + 1e-9]
    since = (new.time[flying] - at.time)[:, None]
    parabola = at.com + since * at.com_velocity + since**2 / 2 * GRAVITY
    assert new.com[flying] == pytest.approx(parabola, abs=1e-3)
    momenta = np.tile(at.angular_momentum, (len(flying), 1))
    assert new.angular_momentum[flying] == pytest.approx(momenta, abs=0.02)
    # On the ground the forces are what moves it.
    landing = knots[len(flying) - 1 :]
    dt = np.diff(new.time[landing])[:, None]
    force = new.contact_force[landing[:-1]].sum(axis=1)
    gained = np.diff(new.com_velocity[landing], axis=0)
    assert gained == pytest.approx(dt * (force / ROBOT.mass + GRAVITY), abs=5e-3)
    tangential = np.abs(new.contact_force[..., :2]).max(axis=-1)
    assert (tangential <= 0.5 * new.contact_force[..., 2] + 2.0).all()
    assert new.com_velocity[-1] == pytest.approx(np.zeros(3), abs=5e-3)


def test_legs_reach_what_is_planned():
    """Forward kinematics of the posture puts every foot where the plan has it."""
    at = state(plan().lift_off + 0.1, FLIGHT, velocity=(0.3, 0.4, 0.0))
    new = found(at)
    model, data = ROBOT.model, ROBOT.model.createData()
    for k in rest(new, at.time):
        q = np.concatenate(
            [new.base_position[k], np.roll(new.base_quat[k], -1), new.joint_position[k]]
        )
        pin.framesForwardKinematics(model, data, q)
        frames = np.array([data.oMf[leg.foot_frame_id].translation for leg in ROBOT.legs])
        feet = frames - [0, 0, ROBOT.foot_lift]
        assert feet == pytest.approx(new.foot_position[k], abs=5e-3)


def test_after_touchdown_feet_stay_where_they_are():
    at = state(plan().touchdown + 0.05, LANDING)
    slid = np.array([[0.03, 0.0, 0.0], [0.03, 0.01, 0.0], [0.02, 0.0, 0.0], [0.02, 0.01, 0.0]])
    at = replace(at, foot_position=at.foot_position + slid, com=at.com + slid[0])
    new = found(at)
    knots = rest(new, at.time)
    assert new.foot_position[knots] == pytest.approx(np.tile(at.foot_position, (len(knots), 1, 1)))
    assert new.com[-1] - plan().com[-1] == pytest.approx(slid.mean(axis=0), abs=0.02)
    turned = Rotation.from_quat(new.base_quat[-1], scalar_first=True).inv()
    turned = turned * Rotation.from_quat(plan().base_quat[-1], scalar_first=True)
    assert turned.magnitude() < 0.01


def test_near_the_last_answer_a_solve_takes_few_iterations():
    replanner = Replanner(plan(), ROBOT)
    starts = plan().lift_off + 0.1 + 0.02 * np.arange(5)
    taken = [replanner.replan(state(start, FLIGHT)).iterations for start in starts]
    assert max(taken[1:]) <= 5


@pytest.mark.parametrize("momentum", [(0.0, -2.0, 0.0), (0.5, 0.5, 0.0)])
def test_the_drives_can_do_what_is_asked_of_legs_at_once(momentum):
    """By the whole body's inverse dynamics where it begins, falling freely."""
    begins = state(plan().lift_off + 0.08, FLIGHT, momentum=momentum)
    new = found(begins)
    start = UnderWay(begins.time, begins.foot_velocity - begins.com_velocity, begins.foot_yaw_rate)
    target = Reference(new, ROBOT.mass * 9.81, start).at(begins.time)
    knot = int(np.argmin(np.abs(new.time - begins.time)))
    w, x, y, z = new.base_quat[knot]
    q = np.concatenate([new.com[knot], [x, y, z, w], new.joint_position[knot]])
    body = WholeBody(ROBOT)
    body.update(q, np.zeros(ROBOT.model.nv))
    from_com = body.foot_jacobian - body.momentum_matrix[:3] / body.mass
    feet = from_com.reshape(12, -1)
    wanted = target.foot_velocity_from_com.ravel(), begins.angular_momentum, begins.com_velocity
    rows = np.vstack([feet, body.momentum_matrix[3:], body.momentum_matrix[:3] / body.mass])
    body.update(q, np.linalg.solve(rows, np.concatenate(wanted)))
    com_bias = body.momentum_bias[:3] / body.mass
    bias = (body.foot_bias - com_bias).ravel()
    rows = np.vstack([feet, body.M[:6]])
    right = np.concatenate([target.foot_acceleration_from_com.ravel() - bias, -body.h[:6]])
    torque = (body.M @ np.linalg.solve(rows, right) + body.h)[6:]
    assert np.abs(torque / ROBOT.torque_limit).max() < NEED_TORQUE + TORQUE_ALLOWANCE


def test_no_answer_leaves_the_plan_as_it_is():
    replanner = Replanner(plan(), ROBOT)
    lost = state(plan().lift_off + 0.1, FLIGHT, velocity=(0.0, 30.0, 0.0))
    answer = replanner.replan(lost)
    assert answer.plan is None
    assert replanner.plan is plan()
    assert replanner.replan(state(plan().lift_off + 0.12, FLIGHT)).plan is not None


def test_a_flight_may_last_longer_than_a_jump_may_be_planned():
    at = state(plan().lift_off + 0.1, FLIGHT, velocity=(0.0, 0.0, 1.2))
    new = found(at)
    longer = new.touchdown - plan().touchdown
    assert 0.1 < longer < MAX_EXTENSION + 0.3


@pytest.mark.parametrize("phase", [FLIGHT, LANDING])
def test_robots_that_fall_are_answered_too(phase):
    """Fatrop once looked for a direction for ever where legs had to be straight."""
    rng = np.random.default_rng(phase)
    replanner = Replanner(plan(), ROBOT)
    start, end = plan().phase_start[phase : phase + 2]
    for _ in range(4):
        velocity, momentum = rng.uniform(-1.5, 1.5, 3), rng.uniform(-8.0, 8.0, 3)
        time = rng.uniform(start, end - 0.08)
        answer = replanner.replan(state(time, phase, velocity=velocity, momentum=momentum))
        assert answer.solve_time_s < 5.0


def test_a_robot_pushed_aside_comes_to_rest_aside_whatever_its_heading():
    """As much as one that has not turned, pushed as it touches down."""
    aside, push = [], np.array([0.0, 0.4, 0.0])
    for heading in np.radians([0.0, 28.2]):
        turned = Rotation.from_euler("z", heading)
        first = llsrbm.plan(llsrbm.Jump(robot="anymal", twist=heading), draft=True)
        at = planned_state(first, LANDING)
        at = replace(at, com_velocity=at.com_velocity + turned.apply(push))
        new = Replanner(first, ROBOT).replan(at).plan
        aside.append(turned.inv().apply(new.com[-1] - first.com[-1]))
    assert aside[0][1] > 0.05
    assert aside[1] == pytest.approx(aside[0], abs=5e-3)


@pytest.mark.nightly
def test_while_only_one_side_has_landed_the_other_is_planned_anew():
    first = llsrbm.plan(llsrbm.Jump(robot="anymal", type="one-foot-first", forward=0.1), draft=True)
    at = planned_state(first, LANDING)
    at = replace(at, com_velocity=at.com_velocity + np.array([0.1, 0.1, 0.0]))
    new = Replanner(first, ROBOT).replan(at).plan
    stands = first.schedule.stands[LANDING]
    assert 0 < stands.sum() < 4
    assert new.foot_position[-1, stands] == pytest.approx(at.foot_position[stands], abs=1e-3)
    assert new.foot_position[-1] == pytest.approx(first.foot_position[-1], abs=1e-3)
    assert new.com_velocity[-1] == pytest.approx(np.zeros(3), abs=5e-3)
