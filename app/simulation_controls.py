"""The controls that say in what world a plan is followed."""

from __future__ import annotations

import viser

from app.checked import number, put
from llsrbm.trajectory.rollout import Conditions

_THICKEST, _STEP = 60, 5  # mm; what passes under the feet of a usual jump
_LARGEST_SEED = 9999


class SimulationControls:
    """Board, disturbance and the button, added to the folder that is open."""

    def __init__(self, gui: viser.GuiApi) -> None:
        """No board, nothing disturbed."""
        self._board = gui.add_slider(
            "Board [mm]", 0, _THICKEST, _STEP, 0, hint="Slid under the robot in mid-flight"
        )
        self._half = gui.add_checkbox(
            "Half board", initial_value=False, hint="Under the front feet only"
        )
        self._disturb = gui.add_checkbox(
            "Disturb",
            initial_value=False,
            hint="Trunk mass, friction, contacts, delay and noise that the controller ignores",
        )
        self._seed = gui.add_number(
            "Seed", 0, min=0, max=_LARGEST_SEED, step=1, hint="Which disturbance is drawn"
        )
        self.button = gui.add_button("Simulate", hint="Follow the plan with the whole robot")

    def read(self) -> tuple[Conditions, list[str]]:
        """The conditions as the controls stand, and what had to be corrected in them."""
        complaints: list[str] = []
        board = number("Board [mm]", self._board.value, (0, _THICKEST), complaints) / 1000
        seed = None
        if self._disturb.value:
            seed = round(number("Seed", self._seed.value, (0, _LARGEST_SEED), complaints))
        # Half of no board is no board.
        half = bool(self._half.value) and board > 0
        return Conditions(board=board, half_board=half, seed=seed), complaints

    def show(self, conditions: Conditions) -> None:
        """Put the controls where corrected conditions have them."""
        put(self._board, round(1000 * conditions.board))
        if conditions.seed is not None:
            put(self._seed, conditions.seed)
