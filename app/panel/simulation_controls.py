"""The controls that say in what scenario a plan is followed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import viser

from app.guard.validation import number, put
from app.panel.html import note
from app.panel.push_controls import PushControls
from llsrbm.request.scenario import Scenario
from llsrbm.robots import RobotFile
from llsrbm.simulation.surroundings import TO_SPARE

_NO_SEEDS = "No seeds tried yet: each one is another disturbance of the same plan."
_STEP = 5  # mm
_LARGEST_SEED = 9999


class SimulationControls:
    """Board, push, disturbance and several seeds, added to the container that is open.

    Attributes:
        push: the controls of a push, and of planning anew.
        seeds: the button for several seeds; worst: the one that opens the worst of them.
    """

    def __init__(self, gui: viser.GuiApi, robot_file: RobotFile) -> None:
        """No board, nothing disturbed; boards that fit under the robot."""
        self._thickest = _thickest(robot_file)
        self._noise: float | None = None  # of what was shown; for when it is disturbed again
        self._board = gui.add_slider(
            "Board [mm]", 0, self._thickest, _STEP, 0, hint="Slid under the robot in mid-flight"
        )
        self._half = gui.add_checkbox(
            "Half board",
            initial_value=False,
            hint="Under the front feet only, or under the front half of soles side by side",
        )
        self.push = PushControls(gui)
        self._disturb = gui.add_checkbox(
            "Disturb",
            initial_value=False,
            hint="Trunk mass, friction, contacts, delay and noise that the controller ignores",
        )
        self._seed = gui.add_number(
            "Seed", 0, min=0, max=_LARGEST_SEED, step=1, hint="Which disturbance is drawn"
        )
        self.seeds = gui.add_button(
            "Simulate 20 seeds", hint="The same plan under 20 disturbances: how many land"
        )
        self._results = gui.add_html(note(_NO_SEEDS))
        self.worst = gui.add_button(
            "Open the worst",
            visible=False,
            hint="Show the simulation that fell first or erred most",
        )

    @property
    def handles(self) -> list[Any]:
        """The controls whose updates change the scenario."""
        return [self._board, self._half, *self.push.handles, self._disturb, self._seed]

    def show_seeds(self, results: str, *, worst: bool) -> None:
        """How several seeds went, as HTML; whether the worst of them can be opened."""
        self._results.content = results or note(_NO_SEEDS)
        self.worst.visible = worst

    def read(self, current: Scenario) -> tuple[Scenario, list[str]]:
        """The scenario as the controls stand, and what had to be corrected in them.

        Args:
            current: holds what has no control.
        """
        complaints: list[str] = []
        board = number("Board [mm]", self._board.value, (0, self._thickest), complaints) / 1000
        seed, noise = None, None
        if self._disturb.value:
            noise = self._noise
            seed = round(number("Seed", self._seed.value, (0, _LARGEST_SEED), complaints))
        # Half of no board is no board.
        half = bool(self._half.value) and board > 0
        scenario = replace(current, board=board, half_board=half, seed=seed, noise=noise)
        return self.push.read(scenario, complaints), complaints

    def show(self, scenario: Scenario, robot_file: RobotFile) -> None:
        """Put the controls where this scenario has them, with boards that fit under the robot."""
        self._thickest = self._board.max = _thickest(robot_file)
        self._noise = scenario.noise
        put(self._board, round(1000 * scenario.board))
        put(self._half, scenario.half_board)
        self.push.show(scenario)
        put(self._disturb, scenario.seed is not None)
        if scenario.seed is not None:
            put(self._seed, scenario.seed)


def _thickest(robot_file: RobotFile) -> int:
    """The thickest board that surely passes under the feet of a level jump, mm, in whole steps."""
    room = 1000 * (robot_file.limits.clearance - TO_SPARE)
    return max(_STEP, int(room / _STEP + 1e-6) * _STEP)
