"""A robot under way: its state, and limits under which it may catch a push."""

from dataclasses import dataclass, replace

import numpy as np

from llsrbm.arrays import Array
from llsrbm.mechanics import GRAVITY
from llsrbm.models.drives import widest_box
from llsrbm.motion.plan import Plan
from llsrbm.planning.problem.apex import FREE_APEX
from llsrbm.planning.problem.task import Task

# Shares of the drives, and factors of the reach, see `relaxed_limits`.
NEED_TORQUE, NEED_SPEED = 0.95, 1.0
NEED_BOX, NEED_LENGTH, NEED_STANDING = 1.4, 1.03, 0.7


@dataclass(frozen=True, eq=False)
class State:
    """A robot under way: L legs, world frame; heights above the plan's ground.

    Attributes:
        time: s on the plan's clock, which touchdowns set.
        phase: of the plan's schedule.
        com, com_velocity: (3,) m, m/s.
        base_quat: (4,) w, x, y, z; angular_velocity: (3,) rad/s of the base.
        angular_momentum: (3,) kg m2/s about the CoM.
        foot_position, foot_velocity: (L, 3) m, m/s.
        foot_yaw, foot_yaw_rate: (L,) rad, rad/s: headings of soles; zeros of points.
        joints, joint_speeds: (J,) rad and rad/s, of which those of arms count.
    """

    time: float
    phase: int
    com: Array
    com_velocity: Array
    base_quat: Array
    angular_velocity: Array
    angular_momentum: Array
    foot_position: Array
    foot_velocity: Array
    foot_yaw: Array
    foot_yaw_rate: Array
    joints: Array
    joint_speeds: Array


def planned_state(plan: Plan, phase: int) -> State:
    """Where a plan is as one of its phases begins; headings of feet do not turn there."""
    time = float(plan.phase_start[phase])
    k = int(np.argmax(plan.phase == phase))
    w, z = plan.foot_quat[k, :, 0], plan.foot_quat[k, :, 3]
    return State(
        time=time,
        phase=phase,
        com=plan.com[k],
        com_velocity=plan.com_velocity[k],
        base_quat=plan.base_quat[k],
        angular_velocity=plan.angular_velocity[k],
        angular_momentum=plan.angular_momentum[k],
        foot_position=plan.foot_position[k],
        foot_velocity=np.zeros_like(plan.foot_position[k]),
        foot_yaw=2 * np.arctan2(z, w),
        foot_yaw_rate=np.zeros(len(w)),
        joints=plan.joint_position[k],
        joint_speeds=np.zeros_like(plan.joint_position[k])
        if plan.joint_velocity is None
        else plan.joint_velocity[k],
    )


def relaxed_limits(task: Task) -> Task:
    """The task under limits for a robot that has been pushed.

    A plan leaves something of the drives and of the legs' reach to feedback, and does not crouch as
    deep as it could; what catches a fall may use nearly all of it, and flies as high as it does.
    Friction stays, and so does the widest reach that a request may ask for.
    """
    limits, reach = task.limits, task.reach
    shares = {
        "torque_share": max(limits.torque_share, NEED_TORQUE),
        "speed_share": max(limits.speed_share, NEED_SPEED),
    }
    lower, upper = np.array(reach.lower), np.array(reach.upper)
    least, most = widest_box(task.robot)
    length, of_file = reach.distance[1], task.robot.file.reach.distance[1]
    wider = {
        "lower": tuple(np.maximum(lower - (NEED_BOX - 1) * np.abs(lower), least).tolist()),
        "upper": tuple(np.minimum(upper + (NEED_BOX - 1) * np.abs(upper), most).tolist()),
        "distance": (
            reach.distance[0],
            min(NEED_LENGTH * length, max(length, NEED_LENGTH * of_file)),
        ),
        "standing": NEED_STANDING * reach.standing,
    }
    return replace(
        task,
        limits=limits.model_copy(update=shares),
        reach=reach.model_copy(update=wider),
        apex=FREE_APEX,
    )


def falling_time(height: float, speed: float) -> float:
    """Time (s) until a body with `speed` (m/s, upwards) has come down by `height` (m); 0: never."""
    under_root = speed**2 + 2 * GRAVITY * height
    return float((speed + np.sqrt(under_root)) / GRAVITY) if under_root > 0 else 0.0


def plan_quat(plan: Plan, time: float) -> Array:
    """(4,) of the nearest knot, with the plan's sign."""
    return plan.base_quat[int(np.argmin(np.abs(plan.time - time)))]


def swings_begun(plan: Plan, state: State) -> Array:
    """(L,) share of its swing that is over of each foot."""
    start, stands = plan.phase_start, plan.schedule.stands
    begun = np.zeros(stands.shape[1])
    for leg in np.flatnonzero(~stands[state.phase]):
        before = np.flatnonzero(stands[: state.phase, leg])[-1]
        after = state.phase + np.flatnonzero(stands[state.phase :, leg])[0]
        lift, touch = start[before + 1], start[after]
        begun[leg] = np.clip((state.time - lift) / (touch - lift), 0.0, 1.0)
    return begun
