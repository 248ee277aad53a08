"""Designs and motions that are kept beside the present one, to be compared with it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from app.motion import colours
from app.motion.colours import Rgb
from app.motion.foreign_motion import ForeignMotion
from app.motion.planned_motion import PlannedMotion
from app.motion.simulated_motion import SimulatedMotion
from app.picture.picture import Ghost
from llsrbm.analysis.figures import DesignFigures, figures_of_plan
from llsrbm.look.titles import Decisions
from llsrbm.motion.rollout import Rollout
from llsrbm.request.design import Design


@dataclass(frozen=True, eq=False)
class Pin:
    """One design with its motion, or a motion from a file.

    Attributes:
        motion: its plan, or what a file holds.
        simulated: the simulation that followed the plan, if there was one.
        design: what was asked for; None where that is not known.
        colour: of its ghost and curves.
    """

    motion: PlannedMotion | ForeignMotion
    simulated: SimulatedMotion | None
    design: Design | None
    colour: Rgb

    @property
    def rollout(self) -> Rollout | None:
        """The simulation."""
        return None if self.simulated is None else self.simulated.rollout

    @cached_property
    def ghost(self) -> Ghost:
        """The robot that is drawn of it, the simulated one if there is one."""
        frames = self.motion.frames if self.simulated is None else self.simulated.frames
        return Ghost(self.motion.motion.robot, frames, self.colour)

    @cached_property
    def figures(self) -> DesignFigures:
        """Its row of numbers."""
        if isinstance(self.motion, ForeignMotion):
            return self.motion.figures
        return figures_of_plan(self.motion.plan, self.rollout)

    @property
    def decisions(self) -> Decisions | None:
        """Which its title is made from; None of a motion that has its file's name."""
        if isinstance(self.motion, ForeignMotion):
            return None
        plan, rollout = self.motion.plan, self.rollout
        return plan.jump, plan.tuning, None if rollout is None else rollout.scenario


def free_colour(pins: tuple[Pin, ...]) -> Rgb | None:
    """A colour that none of the pins has; None: all are taken, and no more can be pinned."""
    taken = {pin.colour for pin in pins}
    return next((colour for colour in colours.PINNED if colour not in taken), None)
