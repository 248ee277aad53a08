"""Designs and motions that are kept beside the current one, to be compared with it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from app.motion import colours
from app.motion.colours import Rgb
from app.motion.foreign_motion import ForeignMotion
from app.motion.planned_motion import PlannedMotion
from app.motion.simulated_motion import SimulatedMotion
from app.scene.picture import Ghost
from llsrbm.analysis.figures import DesignFigures, figures_of_plan
from llsrbm.design import Design
from llsrbm.motion.rollout import Rollout
from llsrbm.titles import Decisions


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
        """What is drawn of it: the simulated robot if there is one."""
        frames = self.motion.frames if self.simulated is None else self.simulated.frames
        return Ghost(self.motion.motion.robot, frames, self.colour)

    @property
    def figures(self) -> DesignFigures:
        """Its row of numbers."""
        if isinstance(self.motion, ForeignMotion):
            return self.motion.figures
        return figures_of_plan(self.motion.plan, self.rollout)

    @property
    def decisions(self) -> Decisions | None:
        """What it is called after; None of a motion that is called after its file."""
        if isinstance(self.motion, ForeignMotion):
            return None
        plan, rollout = self.motion.plan, self.rollout
        return plan.jump, plan.tuning, None if rollout is None else rollout.scenario


class Pins:
    """A tab's pins, as many as there are colours."""

    def __init__(self) -> None:
        """None."""
        self._pins: list[Pin] = []

    def __iter__(self) -> Iterator[Pin]:
        return iter(self._pins)

    def __len__(self) -> int:
        return len(self._pins)

    @property
    def full(self) -> bool:
        """Whether there is no colour left."""
        return len(self._pins) >= len(colours.PINNED)

    def add(
        self,
        motion: PlannedMotion | ForeignMotion,
        simulated: SimulatedMotion | None,
        design: Design | None,
    ) -> None:
        """Keep one more; there must be a colour left."""
        taken = {pin.colour for pin in self._pins}
        colour = next(colour for colour in colours.PINNED if colour not in taken)
        self._pins.append(Pin(motion, simulated, design, colour))

    def at(self, index: int) -> Pin | None:
        """The pin with this number, from 0."""
        return self._pins[index] if 0 <= index < len(self._pins) else None

    def remove(self, pin: Pin) -> None:
        """Keep it no longer."""
        self._pins.remove(pin)
