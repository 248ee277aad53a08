"""The controls of the scenario in which a plan is followed: board, push, replanning, disturbance.

A control more is a row here and its field in `Scenario`.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import viser

from app.panel import summaries
from app.panel.acts import Act, Buttons, Put, add_buttons
from app.panel.fields import Ends, Field, Fields, switch
from app.panel.html import note
from app.panel.status import SeedResult
from llsrbm.motion.surroundings import TO_SPARE
from llsrbm.request.scenario import LARGEST_IMPULSE, Push, Scenario
from llsrbm.robots import RobotFile
from llsrbm.simulation.sensors import ESTIMATORS

AUTOMATICALLY = "Simulate automatically"
_NO_SEEDS = "No seeds tried yet: each one is another disturbance of the same plan."
_STEP = 5  # mm
_LARGEST_SEED = 9999
_LATEST = 10.0  # s; later than any motion ends
_NO_PUSH = Push(0.0, (0.0, 0.0, 0.0))


def _thickest(file: RobotFile) -> Ends:
    """Boards, mm, up to the one that surely passes under the feet of a level jump."""
    room = 1000 * (file.limits.clearance - TO_SPARE)
    return 0.0, float(max(_STEP, int(room / _STEP + 1e-6) * _STEP))


def _with_board(scenario: Scenario, millimetres: float) -> Scenario:
    # Half of no board is no board.
    half = scenario.half_board and millimetres > 0
    return replace(scenario, board=millimetres / 1000, half_board=half)


def _first(scenario: Scenario) -> Push:
    return scenario.pushes[0] if scenario.pushes else _NO_PUSH


def _with_first(scenario: Scenario, **changes: Any) -> Scenario:
    first, *others = scenario.pushes
    return replace(scenario, pushes=(replace(first, **changes), *others))


def _with_seed(scenario: Scenario, wanted: bool) -> Scenario:
    if not wanted:
        return replace(scenario, seed=None, noise=None)
    return scenario if scenario.seed is not None else replace(scenario, seed=0)


def _impulse(axis: int) -> Field[Scenario]:
    def put_part(scenario: Scenario, shown: float) -> Scenario:
        impulse = scenario.pushes[0].impulse
        return _with_first(scenario, impulse=(*impulse[:axis], shown, *impulse[axis + 1 :]))

    return Field(
        f"Push {'xyz'[axis]} [N s]",
        "Impulse, world frame: x forward, y left, z up",
        get=lambda scenario: _first(scenario).impulse[axis],
        put=put_part,
        ends=(-LARGEST_IMPULSE, LARGEST_IMPULSE),
        step=0.1,
        there=_is_pushed,
    )


def _is_pushed(scenario: Scenario) -> bool:
    return bool(scenario.pushes)


BOARD: tuple[Field[Scenario], ...] = (
    Field(
        "Board under the feet [mm]",
        "Height of a board that is slid under the robot in flight",
        get=lambda scenario: 1000 * scenario.board,
        put=_with_board,
        ends=_thickest,
        step=_STEP,
        slider=True,
    ),
    Field(
        "Half board",
        "The board lies under the front feet only, or the front half of soles side by side",
        get=lambda scenario: scenario.half_board,
        put=lambda scenario, on: replace(scenario, half_board=on and scenario.board > 0),
    ),
)
PUSH: tuple[Field[Scenario], ...] = (
    Field(
        "Push",
        "Push the trunk at the current time; drag the tip of its arrow",
        get=_is_pushed,
        put=lambda scenario, wanted: replace(
            scenario, pushes=scenario.pushes or (_NO_PUSH,) if wanted else ()
        ),
    ),
    Field(
        "Push at [s]",
        "Time at which the push begins",
        get=lambda scenario: _first(scenario).time,
        put=lambda scenario, shown: _with_first(scenario, time=shown),
        ends=(0.0, _LATEST),
        step=0.001,
        there=_is_pushed,
    ),
    *(_impulse(axis) for axis in range(3)),
    Field(
        "Replan",
        "Replan flight and landing 50 times a second from measurements",
        get=lambda scenario: scenario.replan,
        put=lambda scenario, on: replace(scenario, replan=on),
    ),
)
DISTURBANCE: tuple[Field[Scenario], ...] = (
    Field(
        "Disturb",
        "Vary trunk mass, friction, contacts, drives, delay and noise, unknown to the controller",
        get=lambda scenario: scenario.seed is not None,
        put=_with_seed,
    ),
    Field(
        "Seed",
        "Number of the disturbance",
        get=lambda scenario: scenario.seed or 0,
        put=lambda scenario, shown: replace(scenario, seed=round(shown)),
        ends=(0.0, _LARGEST_SEED),
        there=lambda scenario: scenario.seed is not None,
        stays=True,
    ),
    Field(
        "Ideal drives",
        "Simulate and control drives without rotors, friction and delay, to compare",
        get=lambda scenario: scenario.drives == "ideal",
        put=lambda scenario, on: replace(scenario, drives="ideal" if on else "true"),
        there=lambda scenario: scenario.drives in ("true", "ideal"),
        stays=True,
    ),
    Field(
        "Estimator",
        "State estimate the controller uses: "
        + "; ".join(f"{name}, {kind.summary}" for name, kind in ESTIMATORS.items()),
        get=lambda scenario: scenario.estimator,
        put=lambda scenario, name: replace(scenario, estimator=name),
        options=tuple(ESTIMATORS),
        there=lambda scenario: scenario.estimator in ESTIMATORS,
        stays=True,
    ),
)


class ScenarioControls:
    """The table's controls with their buttons, and results of seeds; in the open container."""

    def __init__(self, gui: viser.GuiApi, file: RobotFile, acted: Put) -> None:
        self.fields = Fields(gui, Scenario(), file, acted, Act.SCENARIO)  # of the table
        gui.add_html('<div class="llsrbm-scenario llsrbm-wide"></div>')
        # whether every change is simulated
        self.automatic = switch(
            gui, AUTOMATICALLY, "Re-simulate after each change", acted, Act.AUTOMATIC
        )
        self.fields.add(*BOARD, *PUSH)
        self.buttons: Buttons = add_buttons(gui, "push", acted)  # between them
        self.fields.add(*DISTURBANCE)
        self.buttons |= add_buttons(gui, "drives", acted)
        self.buttons |= add_buttons(gui, "seeds", acted)
        self._results = gui.add_html(_wide(note(_NO_SEEDS)))
        self.buttons |= add_buttons(gui, "worst", acted)

    def show_seeds(self, results: Sequence[SeedResult], worst_seed: int | None) -> None:
        """The outcomes of several seeds; the worst of them is marked."""
        table = summaries.seeds_table(results, worst_seed)
        self._results.content = _wide(table or note(_NO_SEEDS))


def _wide(content: str) -> str:
    return f'<div class="llsrbm-wide">{content}</div>'
