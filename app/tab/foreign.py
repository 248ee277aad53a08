"""Another tool's motion that is open, as a value: its certificate, and its repair."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from app.motion import colours
from app.motion.baked import ForeignMotion
from app.motion.colours import Rgb
from llsrbm.certificate import Certificate
from llsrbm.look.palette import css
from llsrbm.motion.plan import Plan
from llsrbm.repairing.result import FAILED, Repair
from llsrbm.repairing.wording import check_rows, checked_sentence, repair_sentences

Offer = Literal["", "waits", "ready"]
"""Whether there is a motion to be repaired, and whether that can be begun by now."""

CHECKING = "Checking the motion at 1 kHz ..."


@dataclass(frozen=True, eq=False)
class Foreign:
    """A motion that was opened last, which is pinned, and what is known of it."""

    motion: ForeignMotion  # as it is drawn: of a repaired one, the stretch that was repaired
    colour: Rgb  # of its pin
    ticket: int = 0  # of the job that checks it; 0: none is under way
    before: Certificate | None = None  # of the file's motion, once it is there
    why_not: str = ""  # there is no certificate, and why
    repair: Repair | None = None  # once it was asked for
    progress: str = ""  # of the repair that is under way, if one is

    @property
    def robot(self) -> str:
        """Name of the robot that moves."""
        return self.motion.motion.robot.name

    @property
    def plan(self) -> Plan | None:
        """The plan in place of it; None: it was not repaired, or cannot be."""
        repair = self.repair
        return None if repair is None or repair.status == FAILED else repair.plan

    @property
    def repaired_name(self) -> str:
        """Name of the plan in place of it."""
        return f"{self.motion.name}, repaired"

    @property
    def hopeless(self) -> bool:
        """Whether it was found that it cannot be repaired."""
        return self.repair is not None and self.plan is None

    def is_shown(self, plan: Plan | None) -> bool:
        """Whether the plan that is shown is the repaired motion."""
        return plan is not None and plan is self.plan


def card(foreign: Foreign, *, repaired: bool, repairing: bool, offer: Offer) -> dict[str, Any]:
    """For the page (static/compare.js): which checks are broken, and after a repair.

    `repaired`: the plan that is shown is the repaired motion; `repairing`: a repair is under way.
    """
    name = foreign.motion.name
    note = CHECKING if foreign.ticket else ""
    if repairing:
        note = f"Repairing {foreign.progress or '...'}"
    names = {f"Before: {name}": foreign.colour, f"After: {foreign.repaired_name}": colours.PLANNED}
    if not repaired:
        names = {name: foreign.colour}
    return {
        "ways": [
            {"name": each, "colour": css(tint), "state": "busy" if note else "done"}
            for each, tint in names.items()
        ],
        "note": note,
        "sentence": "" if note else _sentence(foreign, ended=repaired or foreign.hopeless),
        "rows": [{"title": title, "values": values} for title, values in _rows(foreign, repaired)],
        "repair": offer,
    }


def _sentence(foreign: Foreign, *, ended: bool) -> str:
    if ended and foreign.repair is not None:
        return repair_sentences(foreign.repair)
    if foreign.before is None:
        return foreign.why_not
    # What is drawn was cut by its repair, and has another time since.
    cut = foreign.repair is not None and foreign.before.broken
    when = "In the file's own time: " if cut else ""
    return f"{when}{checked_sentence(foreign.before)}"


def _rows(foreign: Foreign, repaired: bool) -> list[tuple[str, tuple[str, ...]]]:
    if foreign.before is None:
        return []
    after = None if foreign.repair is None else foreign.repair.after
    return check_rows(foreign.before, *([after] if repaired and after else []))
