"""Plans that a player refuses, and why."""

from llsrbm.certificate import CHECKS, Certificate, certify
from llsrbm.errors import InputError
from llsrbm.motion.plan import Plan
from llsrbm.player.tier import Tier
from llsrbm.robots import Robot


def check_plan(plan: Plan, robot: Robot, tier: type[Tier]) -> Certificate:
    """The certificate of a plan that may be played, made anew: a file may hold anything.

    Every check of it has to be known and to hold, but for those that the tier makes up for itself
    (`Tier.makes_up_for`). Raises `InputError`: the plan did not converge, is of another robot,
    begins or ends under way, or its certificate does not hold.
    """
    if not plan.solved:
        raise InputError("plan: it did not converge; expected one that did")
    if plan.robot_parameters.get("name") != robot.file.name:
        raise InputError(
            f"plan: it is of robot {plan.robot_parameters.get('name')}, the robot to be played on "
            f"is {robot.file.name}; expected the plan's own"
        )
    if plan.jump.speed or plan.jump.end_speed:
        raise InputError(
            "plan: it begins or ends with a speed; expected one from standing to standing, as a "
            "player begins and ends"
        )
    certificate = certify(plan, robot)
    needed = [check.name for check in CHECKS if check.name not in tier.makes_up_for]
    for name in needed:
        found = certificate[name]
        if found.holds:
            continue
        if found.holds is None or found.worst is None or found.allowed is None:
            raise InputError(f"plan: {name} of its certificate is not known: {found.why}")
        raise InputError(
            f"plan: its certificate does not hold: {name} {found.shown(found.worst)} of "
            f"{found.where} at {found.time_s:.3f} s, allowed {found.shown(found.allowed)}; "
            f"expected one for tier {tier.name} that holds, as `llsrbm plan` makes"
        )
    return certificate
