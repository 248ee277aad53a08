"""Weights and limits for those who want them: made from what the planner itself declares."""

from __future__ import annotations

import viser

from app.panel.html import note
from app.panel.tuning_table import entries_of, tuning_table
from llsrbm.request.tuning import Tuning
from llsrbm.robots import Robot

_LINE = "Defaults. Hover a name to see the effect of increasing it."
_CHANGED = "{} from the defaults. Hover a name to see the effect of increasing it."
_NO_ROBOT = "The weights and limits appear as soon as the robot is ready."


class TuningControls:
    """The table of a robot's weights and limits, in the container that is open.

    Attributes:
        reset: the button that takes every change back.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        """Empty until there is a robot."""
        self._line = gui.add_html(note(_NO_ROBOT))
        self.reset = gui.add_button(
            "Reset all",
            disabled=True,
            hint="Every weight and limit as the robot's file has it, or the jump type",
        )
        self._table = gui.add_html("", visible=False)
        self._of: tuple[Robot, str] | None = None

    def show_robot(self, robot: Robot, jump_type: str) -> bool:
        """The weights and limits of this robot's jumps of a type; whether they were others'."""
        if (robot, jump_type) == self._of:
            return False
        self._of = robot, jump_type
        self._table.content = tuning_table(entries_of(robot, jump_type))
        self._table.visible = True
        return True

    def show(self, tuning: Tuning) -> None:
        """How much is changed; the numbers themselves are the page's script's to show."""
        count = len(tuning.weights) + len(tuning.limits)
        changed = f"{count} {'number differs' if count == 1 else 'numbers differ'}"
        self._line.content = note(_CHANGED.format(changed) if count else _LINE)
        self.reset.disabled = not count
