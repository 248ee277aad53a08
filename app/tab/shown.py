"""The motion that a tab shows, as a value."""

from dataclasses import dataclass

from app.motion.baked import PlannedMotion, SimulatedMotion
from llsrbm.look.shown_motion import ShownMotion
from llsrbm.motion.block import Block
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.request.jump import Jump, changes
from llsrbm.request.scenario import Scenario


@dataclass(frozen=True, eq=False)
class Shown:
    """The motion that is shown."""

    planned: PlannedMotion  # the plan, ready to be drawn
    simulated: SimulatedMotion | None = None  # the simulation that followed it
    scenario: Scenario | None = None  # for which it was asked
    so_far: ShownMotion | None = None  # frames of the simulation that is running
    blocks: tuple[Block, ...] = ()  # what stands around
    source: str = ""  # where it is from, in words, if not from this tab's own planning
    # the request to which it is the nearest that can be planned; None: it does what was asked for
    wanted: Jump | None = None
    reason: str = ""  # why not that, in one sentence
    centroidal: Plan | None = None  # the draft of its jump, from which a slider's steps begin

    @property
    def request(self) -> Jump:
        """The request that it answers."""
        return self.wanted or self.plan.jump

    @property
    def remark(self) -> str:
        """In which way it is not the jump that was asked for, in words; "" if it is."""
        if not self.plan.solved:
            return "Not feasible: where the planner stopped"
        if self.wanted is None:
            return ""
        return f"Nearest: {changes(self.wanted, self.plan.jump) or 'all but the same'}"

    @property
    def plan(self) -> Plan:
        """The plan."""
        return self.planned.plan

    @property
    def rollout(self) -> Rollout | None:
        """The simulation."""
        return None if self.simulated is None else self.simulated.rollout

    @property
    def solid(self) -> ShownMotion | None:
        """The motion of the robot that follows the plan; None: the plan alone is shown."""
        return self.so_far if self.simulated is None else self.simulated.frames


@dataclass(frozen=True, eq=False)
class Given:
    """A motion that is there already: it is shown when its robot can be drawn, without planning."""

    plan: Plan  # to show
    rollout: Rollout | None = None  # that followed it
    source: str = ""  # where both are from, in words; "": the tab's own planning
    note: str = ""  # on the file that holds them
