"""The player: a plan on a robot, by a `Link`, a clock and the plan alone.

    player = Player(ClosedLoop(plan, robot), link, clock)
    ended = player.run()

States follow each other, `check`, `ramp`, `stand`, `jump`, `damp`; what stops a robot before its
plan has ended leads to `damp` at once. Nobody here has run it on a robot.
"""

from llsrbm.player.player import Ended, Player
from llsrbm.player.requirements import check_plan
from llsrbm.player.tier import PERIOD, Tier
from llsrbm.player.tiers import TIERS, make_tier

__all__ = ["PERIOD", "TIERS", "Ended", "Player", "Tier", "check_plan", "make_tier"]
