"""Weights and limits: a table made from what the planner itself declares, and its controls.

The page's script (app/static/tuning.js) puts the numbers into the table and sends what is typed.
"""

from dataclasses import dataclass
from html import escape
from typing import Literal

import viser

from app.panel.acts import Buttons, Put, add_buttons
from app.panel.html import note
from llsrbm.planning.problem.costs import COSTS, default_weights
from llsrbm.planning.problem.placement import limits_of
from llsrbm.request import jump_types
from llsrbm.request.tuning import Tuning
from llsrbm.robots import Robot

_LINE = "Defaults. Hover a name to see the effect of increasing it."
_CHANGED = "{} from the defaults. Hover a name to see the effect of increasing it."
_NO_ROBOT = "The weights and limits appear as soon as the robot is ready."

Group = Literal["weights", "limits"]  # The fields of `Tuning`

_LARGEST_WEIGHT = 1e6  # a thousand times the largest default; the solver's numbers stay sound
_TITLES: dict[Group, str] = {"weights": "Weights", "limits": "Limits"}
_POWERS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class Entry:
    """One number of a robot's planner."""

    group: Group  # the field of `Tuning` it belongs to
    name: str  # in there
    default: float  # the jump type's value, or the robot's own
    lowest: float  # accepted
    highest: float  # accepted
    unit: str  # of all of these; "1": none
    effect: str  # what increasing it does

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
            if c.concerns(robot)
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
    title, unit, own = escape(entry.title), escape(_unit(entry.unit)), f"{entry.default:g}"
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
    if unit == "1":
        return ""
    base = "".join(
        c.translate(_POWERS) if c.isdigit() and i and unit[i - 1] in "^)mgsN" else c
        for i, c in enumerate(unit)
    )
    return base.replace("^", "")


class TuningControls:
    """The table of a robot's weights and limits, in the container that is open."""

    def __init__(self, gui: viser.GuiApi, put: Put) -> None:
        self._line = gui.add_html(note(_NO_ROBOT))
        self.buttons: Buttons = add_buttons(gui, "limits", put)  # one takes every change back
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
