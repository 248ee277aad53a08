"""Which variables the plan of a jump has."""

from collections.abc import Mapping

from llsrbm.errors import InputError
from llsrbm.models import free_arms_of
from llsrbm.planning.problem.apex import limits_apex
from llsrbm.planning.problem.layout import Layout
from llsrbm.request.jump import Jump
from llsrbm.request.jump_types import load_type, schedule_of
from llsrbm.robots.robot import Robot

INTERVALS = 48
MIN_INTERVALS, MAX_INTERVALS = 9, 300  # 3 a phase; more than 300 take minutes to build


def layout_of(
    jump: Jump,
    robot: Robot,
    intervals: int = INTERVALS,
    limits: Mapping[str, float] | None = None,
) -> Layout:
    """The variables of a jump's plan; `intervals` as for three phases; `limits`: of the request.
    Raises `InputError`: a number of intervals that cannot be, or a jump type that is none.
    """
    if not MIN_INTERVALS <= intervals <= MAX_INTERVALS:
        raise InputError(
            f"intervals: {intervals} given; expected {MIN_INTERVALS} to {MAX_INTERVALS}"
        )
    contacts = len(robot.legs) * len(robot.corners)
    return Layout.of(
        schedule_of(jump, robot),
        contacts,
        intervals,
        robot.foot_coordinates,
        clears=load_type(jump.type).clears,
        turns=jump.turns,
        arm_joints=len(robot.arm_joint_index) if free_arms_of(jump, robot) else 0,
        apex=limits_apex(limits),
    )
