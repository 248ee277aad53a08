"""The tiers, found by name."""

from llsrbm.motion.plan import Plan
from llsrbm.player.closed_loop import ClosedLoop
from llsrbm.player.table import Table
from llsrbm.player.tier import PlanTier
from llsrbm.request.messages import look_up
from llsrbm.robots import Robot

TIERS: dict[str, type[PlanTier]] = {tier.name: tier for tier in (Table, ClosedLoop)}


def tier_called(name: str) -> type[PlanTier]:
    """The tier of a name. Raises `InputError`, naming the valid ones: no tier has it."""
    return look_up("tier", name, TIERS)


def make_tier(name: str, plan: Plan, robot: Robot) -> PlanTier:
    """The tier of a name, for a plan. Raises `InputError`: no such tier, or no standing start."""
    return tier_called(name)(plan, robot)
