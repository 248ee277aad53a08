"""A jump type as a small gait diagram: a row a leg, bars where its foot stands, flights empty.

Columns are the phases in order, all of one width, for how long they take is the plan's. A body that
turns over has an arrow in its first flight, as it turns for an eye to the right of the robot
(flips) or behind it (rolls).
"""

import math
from html import escape
from itertools import groupby

from app.panel.html import DIM
from app.panel.jump_types import turn_title
from llsrbm.errors import InputError
from llsrbm.request.jump import Jump
from llsrbm.request.jump_types import JumpType, Legs
from llsrbm.request.schedule import Schedule

HEIGHT = 70  # px, of any type: what stands below must not move as another one is chosen

_WIDTH, _ROWS = 168, 52  # px: of the drawing, and of all its rows together
_UNDER = 12  # px, from the rows down to the foot of the letters below them
_ROW = 13.0  # px, of a row at most
_LETTER = 7.2  # px, of a leg's name
_LONGEST = 8  # letters of a leg's name that are shown
_ARC = 135  # deg to each side of the top, that an arrow goes around
_HEAD = 3.6  # px


def _beside(drawing: str, words: str) -> str:
    words = escape(words)
    return (
        f'<div class="llsrbm-type" style="display:flex;align-items:center;gap:8px;'
        f'height:{HEIGHT}px;overflow:hidden">{drawing}'
        f'<div title="{words}" style="{DIM};flex:1;font-size:12px;line-height:1.25;'
        'overflow:hidden;display:-webkit-box;-webkit-box-orient:vertical;-webkit-line-clamp:4">'
        f"{words[:1].upper()}{words[1:]}</div></div>"
    )


EMPTY = _beside("", "")
"""Its place, while nothing is known of the robot."""


def type_picture(kind: JumpType, robot: Legs, jump: Jump) -> str:
    """HTML: the schedule that a request of this type has on a robot, and the type in one line.

    Without a drawing where the robot has no such feet.
    """
    try:
        drawing = gait_diagram(kind.schedule(robot, jump), jump)
    except InputError:
        drawing = ""
    return _beside(drawing, kind.summary)


def gait_diagram(schedule: Schedule, jump: Jump) -> str:
    """SVG: a bar for each stretch of time in which a foot stands; the turn of `jump`."""
    left = 4 + _LETTER * min(max(map(len, schedule.legs)), _LONGEST)
    column = (_WIDTH - left) / len(schedule)
    row = min(_ROW, _ROWS / len(schedule.legs))
    bottom = row * len(schedule.legs)
    height = bottom + (HEIGHT - _ROWS if jump.turns else 0)
    parts = [f"<title>{escape(_in_words(schedule, jump))}</title>"]
    for leg, name in enumerate(schedule.legs):
        middle = (leg + 0.5) * row
        parts.append(
            f'<text x="0" y="{middle:.1f}" font-size="{min(12.0, row):.1f}" '
            f'dominant-baseline="central">{escape(name[:_LONGEST])}</text>'
            f'<path d="M{left:.1f} {middle:.1f}H{_WIDTH}" stroke="currentColor" opacity="0.2"/>'
        )
        for first, last in _stances(schedule, leg):
            x, width = left + first * column, (last + 1 - first) * column
            parts.append(
                f'<rect x="{x:.1f}" y="{middle - 0.3 * row:.1f}" width="{width:.1f}" '
                f'height="{0.6 * row:.1f}" rx="1" opacity="0.8"/>'
            )
    if jump.turns:
        middle = left + (schedule.flights[0] + 0.5) * column
        parts.append(_arrow(middle, bottom / 2, min(0.36 * column, 0.36 * bottom), jump))
        parts.append(
            f'<text x="{middle:.1f}" y="{bottom + _UNDER:.1f}" font-size="12" text-anchor="middle">'
            f"{_seen_from(jump)}</text>"
        )
    return (
        f'<svg role="img" width="{_WIDTH}" height="{height:.0f}" fill="currentColor" '
        f'style="flex:none">{"".join(parts)}</svg>'
    )


def _stances(schedule: Schedule, leg: int) -> list[tuple[int, int]]:
    """First and last phase of each stretch in which a foot stands."""
    stands = enumerate(schedule.stands[:, leg].tolist())
    runs = [(on, [phase for phase, _ in run]) for on, run in groupby(stands, lambda each: each[1])]
    return [(phases[0], phases[-1]) for on, phases in runs if on]


def _arrow(x: float, y: float, radius: float, jump: Jump) -> str:
    """Three quarters of a circle around (x, y) px, clockwise for positive turns."""
    side = math.copysign(1.0, jump.pitch or jump.roll)
    ends = []
    for angle in (-_ARC, _ARC):  # deg, clockwise from the top
        s, c = math.sin(math.radians(angle)), math.cos(math.radians(angle))
        ends.append((x + side * radius * s, y - radius * c))
    (x0, y0), (x1, y1) = ends
    # Onwards and outwards at the arrow's end.
    s, c = math.sin(math.radians(_ARC)), math.cos(math.radians(_ARC))
    on, out = (side * c, s), (side * s, -c)
    head = [
        (x1 + _HEAD * (a * on[0] + b * out[0]), y1 + _HEAD * (a * on[1] + b * out[1]))
        for a, b in ((1.4, 0.0), (0.0, 1.0), (0.0, -1.0))
    ]
    corners = "L".join(f"{u:.1f} {v:.1f}" for u, v in head)
    return (
        f'<path d="M{x0:.1f} {y0:.1f}A{radius:.1f} {radius:.1f} 0 1 {int(side > 0)} '
        f'{x1:.1f} {y1:.1f}" fill="none" stroke="currentColor" stroke-width="1.6"/>'
        f'<path d="M{corners}Z"/>'
    )


def _seen_from(jump: Jump) -> str:
    return "seen from its right" if jump.pitch else "seen from behind"


def _in_words(schedule: Schedule, jump: Jump) -> str:
    phases = [
        f"{phase.name}: {schedule.standing_words(index)}" for index, phase in enumerate(schedule)
    ]
    if jump.turns:
        phases.append(f"turn: {turn_title(jump)}, {_seen_from(jump)}")
    return "; ".join(phases)
