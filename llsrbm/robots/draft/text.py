"""A proposal as the text of a robot file, with a comment at everything that is a guess."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

from llsrbm.robots.draft.anatomy import Anatomy
from llsrbm.robots.draft.proposal import Proposal

_TABLES = (
    "foot", "reach", "arm_reach", "limits", "drives", "drives.arms", "drives.known", "timing",
    "turning", "turning.reach", "turning.timing", "task", "example",
)  # fmt: skip
_COMMENTS = {
    "reach": "Where a foot may be, seen from its hip: x forward, y outward, m.",
    "arm_reach": "Where the first arm may be, joint angles, rad; the other one mirrored.",
    "limits": "Nm or N and rad/s or m/s, a number a joint of a leg; m, m/s.",
    "drives": "Rotors as joints feel them, kg m2; friction, Nm; damping, Nm s/rad; sliding: kg, N.",
    "drives.known": "What is left out is assumed.",
    "timing": "s, shortest and longest.",
    "turning": "For flips, in place of the tables above.",
    "task": "What may be asked: rad, m.",
    "example": "The jump that a page shows first, rad.",
    "foot": "What touches the ground, in the frame of a foot, m; turns in rad.",
    "control": "How the controller follows plans.",
}


def robot_file_text(name: str, urdf: dict[str, str], anatomy: Anatomy, proposal: Proposal) -> str:
    """A robot file of that short name, table [urdf] and proposal."""
    title = name.replace("_", " ").replace("-", " ").title()
    limbs = [*anatomy.names, *(arm.name for arm in anatomy.arms)]
    lines = [
        f"# {title}, {anatomy.mass:.4g} kg. Written by `llsrbm robot new` from the URDF alone:",
        '# check what is marked "guessed", docs/add_a_robot.md says how.',
        f"name = {_value(name)}",
        f"title = {_value(title)}",
        "",
        "[urdf]",
        *(f"{key} = {_value(value)}" for key, value in urdf.items()),
        *_held(anatomy),
        *_frames(anatomy),
        "",
        "# foot: the frame of the contact point. hip: the joint that swings the leg forward.",
        "[legs]",
        *(
            f"{leg} = {{ foot = {_value(foot)}, hip = {_value(hip)} }}"
            for leg, foot, hip in zip(anatomy.names, anatomy.feet, anatomy.hips, strict=True)
        ),
        *_arms(anatomy, proposal),
        "",
        f"# Guessed: {proposal.guessed['posture']}. Joint angles, rad, from the base outwards.",
        "[posture]",
        *(f"{limb} = {_value(proposal.values[f'posture.{limb}'])}" for limb in limbs),
    ]
    for table in _TABLES:
        lines += _table(table, proposal)
        if table in proposal.left_out:
            lines += ["", f"# No [{table}]: {proposal.left_out[table]}."]
    if any(key.startswith("control.") for key in proposal.values):
        lines += _table("control", proposal)
        for inner in ("gains", "weights"):
            lines += _table(f"control.{inner}", proposal)
    return "\n".join(lines) + "\n"


def _held(anatomy: Anatomy) -> list[str]:
    if not anatomy.held:
        return []
    rows = [f"{_key(name)} = {_value(angle)}" for name, angle in anatomy.held.items()]
    what = "neither leg nor arm" if anatomy.arms else "no leg"
    comment = f"# Joints of {what} stay at these angles, rad. Guessed: at zero, or next to it."
    return ["", comment, "[urdf.held]", *rows]


def _arms(anatomy: Anatomy, proposal: Proposal) -> list[str]:
    if not anatomy.arms:
        return []
    rows = [f"{arm.name} = {{ hand = {_value(arm.hand)} }}" for arm in anatomy.arms]
    return ["", f"# Guessed: {proposal.guessed['arms']}.", "[arms]", *rows]


def _frames(anatomy: Anatomy) -> list[str]:
    rows = [
        f"{_key(name)} = {{ link = {_value(frame.link)}, xyz = {_value([*frame.xyz])}"
        + (f", rpy = {_value([*frame.rpy])}" if any(frame.rpy) else "")
        + " }"
        for name, frame in anatomy.frames.items()
    ]
    what = "Middles of the soles on the ground" if anatomy.has_soles else "Middles of the feet"
    comment = f"# {what}. Guessed: from the geometry there."
    return ["", comment, "[urdf.frames]", *rows] if rows else []


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _value(name)


def _table(table: str, proposal: Proposal) -> list[str]:
    """Its lines, an empty one before them; none if nothing is proposed."""
    start = table + "."
    rows = {
        key.removeprefix(start): value
        for key, value in proposal.values.items()
        if key.startswith(start) and "." not in key.removeprefix(start)
    }
    if not rows:
        return []
    comments = [_COMMENTS[table]] if table in _COMMENTS else []
    if table in proposal.guessed:
        comments.append(f"Guessed: {proposal.guessed[table]}.")
    lines = ["", f"[{table}]"] if not comments else ["", f"# {' '.join(comments)}", f"[{table}]"]
    for key, value in rows.items():
        guess, source = (of.get(f"{table}.{key}") for of in (proposal.guessed, proposal.sources))
        note = f"guessed: {guess}" if guess else source
        lines.append(f"{key} = {_value(value)}" + (f"  # {note}" if note else ""))
    return lines


def _value(value: Any) -> str:
    """As TOML; strings are names and paths, without control characters."""
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    if isinstance(value, list):
        return f"[{', '.join(_value(item) for item in value)}]"
    return repr(value)


def urdf_beside(urdf: Path, out: Path) -> dict[str, str]:
    """The table [urdf] of a robot file at `out`: where the URDF is, seen from there."""
    return {"file": Path(os.path.relpath(urdf, out.absolute().parent)).as_posix()}
