"""Weights and limits as a table of HTML: name, value, unit and default, a row each.

The page's script (app/static/tuning.js) puts the numbers in and sends what is typed.
"""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import Literal

from llsrbm.planning.problem.costs import COSTS, default_weights
from llsrbm.planning.problem.placement import limits_of
from llsrbm.request import jump_types
from llsrbm.request.messages import short
from llsrbm.robots import Robot

Group = Literal["weights", "limits"]
"""The fields of `Tuning`."""

_LARGEST_WEIGHT = 1e6  # a thousand times the largest default; the solver's numbers stay sound
_TITLES: dict[Group, str] = {"weights": "Weights", "limits": "Limits"}
_POWERS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Entry:
    """One number of a robot's planner.

    Attributes:
        group: the field of `Tuning` it belongs to.
        name: in there.
        default: the jump type's value, or the robot's own.
        lowest: accepted; highest: accepted.
        unit: of all of these; "1": none.
        effect: what increasing it does.
    """

    group: Group
    name: str
    default: float
    lowest: float
    highest: float
    unit: str
    effect: str

    @property
    def title(self) -> str:
        """For people."""
        return self.name.replace("_", " ")


def entries_of(robot: Robot, jump_type: str) -> tuple[Entry, ...]:
    """Every number that a request of a type may change."""
    kind = jump_types.load_type(jump_type)
    weights = default_weights() | dict(robot.file.planning) | kind.weights
    return (
        *(
            Entry("weights", c.name, weights[c.name], 0.0, _LARGEST_WEIGHT, c.unit, c.effect)
            for c in COSTS
        ),
        *(
            Entry(
                "limits",
                limit.name,
                kind.limits.get(limit.name, own),
                limit.lowest,
                limit.highest,
                limit.unit,
                limit.effect,
            )
            for limit, own in limits_of(robot).values()
        ),
    )


def tuning_table(entries: tuple[Entry, ...]) -> str:
    """The tables, with every number at its default."""
    tables = "".join(
        _table(_TITLES[group], [entry for entry in entries if entry.group == group])
        for group in _TITLES
    )
    return f'<div class="llsrbm-tuning">{tables}</div>'


def _table(title: str, entries: list[Entry]) -> str:
    head = (
        '<tr><th scope="col">Name</th><th scope="col" class="number">Value</th>'
        '<th scope="col">&nbsp;Unit</th><th scope="col" class="number">Default</th><td></td></tr>'
    )
    rows = "".join(_row(entry) for entry in entries)
    return (
        f"<table><caption>{escape(title)}</caption><thead>{head}</thead>"
        f"<tbody>{rows}</tbody></table>"
    )


def _row(entry: Entry) -> str:
    title, unit, own = escape(entry.title), escape(_unit(entry.unit)), short(entry.default)
    named = title if entry.unit == "1" else f"{title} [{escape(entry.unit)}]"
    return (
        f'<tr data-group="{entry.group}" data-name="{escape(entry.name)}" data-default="{own}">'
        f'<th scope="row" title="Increasing it: {escape(entry.effect)}">{title}</th>'
        f'<td class="number"><input type="number" step="any" value="{own}" aria-label="{named}" '
        f'min="{entry.lowest:g}" max="{entry.highest:g}"></td>'
        f'<td>{unit}</td><td class="number">{own}</td>'
        f'<td><button type="button" data-reset aria-label="Reset {title}" '
        f'title="Reset to {own}">↺</button></td></tr>'
    )


def _unit(unit: str) -> str:
    """As it is written: squares above the line."""
    if unit == "1":
        return ""
    base = "".join(
        c.translate(_POWERS) if c.isdigit() and i and unit[i - 1] in "^)mgsN" else c
        for i, c in enumerate(unit)
    )
    return base.replace("^", "")
