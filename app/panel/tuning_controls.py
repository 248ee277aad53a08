"""Weights and limits for those who want them: made from what the planner itself declares."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from typing import Any

import viser

from app.panel.html import SMALL
from app.panel.validation import number, put
from llsrbm.planning.costs import COSTS, default_weights
from llsrbm.planning.limits import limits_of
from llsrbm.robots import Robot
from llsrbm.tuning import Tuning

_LARGEST_WEIGHT = 1e6
_SAME = 1e-9  # relative; what a browser sends back of a default may differ in the last bits


@dataclass(frozen=True, eq=False)
class _Entry:
    """One number: of the weights or the limits, with its default and range."""

    name: str
    kind: str
    default: float
    lowest: float
    highest: float
    handle: Any

    def label(self) -> str:
        return str(self.handle.label)


class TuningControls:
    """A number for each weight and limit of a robot, added to the folder that is open."""

    def __init__(self, client: viser.ClientHandle, changed: Callable[..., Any]) -> None:
        """Empty until there is a robot.

        Args:
            client: whose tab.
            changed: viser's callback for a number that was changed.
        """
        self._gui = client.gui
        self._changed = changed
        self._told = self._gui.add_html(_told([]))
        self._reset = self._gui.add_button("Reset all", disabled=True, hint="The robot's own")
        self._folder = self._gui.add_folder("Numbers")
        self._entries: list[_Entry] = []
        self._robot: Robot | None = None

        @self._reset.on_click
        async def _(event: viser.GuiEvent[Any]) -> None:
            if event.client_id is not None:
                for entry in self._entries:
                    put(entry.handle, entry.default)
                await self._changed(event)

    def show_robot(self, robot: Robot) -> bool:
        """The weights and limits of this robot, none changed; whether they were another one's."""
        if robot is self._robot:
            return False
        for entry in self._entries:
            entry.handle.remove()
        self._robot = robot
        of_robot = default_weights() | dict(robot.file.planning)
        with self._folder:
            self._entries = [
                self._add(
                    cost.name,
                    "weights",
                    of_robot[cost.name],
                    (0.0, _LARGEST_WEIGHT),
                    cost.unit,
                    cost.effect,
                )
                for cost in COSTS
            ] + [
                self._add(
                    limit.name,
                    "limits",
                    default,
                    (limit.lowest, limit.highest),
                    limit.unit,
                    limit.effect,
                )
                for limit, default in limits_of(robot).values()
            ]
        self._tell()
        return True

    def read(self) -> tuple[Tuning, list[str]]:
        """What is changed, and what had to be corrected."""
        complaints: list[str] = []
        changed: dict[str, dict[str, float]] = {"weights": {}, "limits": {}}
        for entry in self._entries:
            value = number(
                entry.label(), entry.handle.value, (entry.lowest, entry.highest), complaints
            )
            if not math.isclose(value, entry.default, rel_tol=_SAME, abs_tol=_SAME):
                changed[entry.kind][entry.name] = value
        self._tell()
        return Tuning(**changed), complaints

    def show(self, tuning: Tuning) -> None:
        """Put the numbers where a design has them."""
        given = {"weights": tuning.weights, "limits": tuning.limits}
        for entry in self._entries:
            value = given[entry.kind].get(entry.name)
            put(entry.handle, entry.default if value is None else value)
        self._tell()

    def _add(
        self,
        name: str,
        kind: str,
        default: float,
        ends: tuple[float, float],
        unit: str,
        effect: str,
    ) -> _Entry:
        handle = self._gui.add_number(
            f"{name.replace('_', ' ')} [{unit}]",
            default,
            min=ends[0],
            max=ends[1],
            step=_step(default),
            hint=f"{'Weight' if kind == 'weights' else 'Limit'}; raised: {effect}",
        )

        handle.on_update(self._changed)
        return _Entry(name, kind, default, *ends, handle)

    def _tell(self) -> None:
        lines = [
            f"{entry.label()}: {entry.handle.value:g} instead of {entry.default:g}"
            for entry in self._entries
            if isinstance(entry.handle.value, int | float)
            and not math.isclose(entry.handle.value, entry.default, rel_tol=_SAME, abs_tol=_SAME)
        ]
        self._told.content = _told(lines)
        self._reset.disabled = not lines


def _told(lines: list[str]) -> str:
    body = "".join(f"<div>{escape(line)}</div>" for line in lines) or (
        "The robot's own. Point at a name to read what happens when its number is raised."
    )
    return f'<div style="{SMALL}">{body}</div>'


def _step(value: float) -> float:
    """A tenth of a number's own size."""
    return 0.01 if value == 0 else float(10 ** (math.floor(math.log10(abs(value))) - 1))
