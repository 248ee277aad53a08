"""A repair in words: which checks a motion breaks, by how much and when, and how far it moves."""

from __future__ import annotations

from llsrbm.certificate import Certificate, Finding
from llsrbm.repairing.result import FAILED, UNCHANGED, Moved, Repair

_LISTED = 3  # checks that a sentence names; a table has all of them


def broken_checks(certificate: Certificate) -> str:
    """The checks that do not hold, by how much and when; or that all that is known does."""
    if not certificate.broken:
        return "holds" if certificate.holds else "holds as far as it is known"
    return "; ".join(f"{each.name}{_worst(each)}" for each in certificate.broken)


def moved_in_words(by: Moved) -> str:
    """How far a motion had to move."""
    return (
        f"joints {by.joint_rms_rad:.3f} rad (rms), base {100 * by.base_rms_m:.1f} cm (rms), "
        f"landing {100 * by.landing_m:.1f} cm"
    )


def checked_sentence(certificate: Certificate) -> str:
    """Which of its checks a motion breaks, by how much, and when in its own time."""
    words = _checked(certificate)
    return f"{words[0].upper()}{words[1:]}"


def _checked(certificate: Certificate) -> str:
    broken = certificate.broken
    count, known = _counted(certificate)
    if not broken:
        return f"{count} hold{known}."
    listed = [f"{_name(each)}{_worst(each)}" for each in broken[:_LISTED]]
    if len(broken) > _LISTED:
        listed.append(f"and {len(broken) - _LISTED} more")
    return (
        f"{len(broken)} of {len(certificate.findings)} checks broken{known}: {'; '.join(listed)}."
    )


def repair_sentences(repair: Repair) -> str:
    """A repair: checks before and after, how far the motion moved, and remarks."""
    when = ", in the file's own time" if repair.before.broken else ""
    before = f"Before{when}: {_checked(repair.before)}"
    if repair.status == FAILED or repair.after is None:
        return f"{before} Not repaired: {repair.why}"
    sentences = [before, f"After: {_checked(repair.after)}"]
    if repair.status == UNCHANGED:
        sentences.append("It can be done as it is.")
    if repair.moved is not None:
        sentences.append(f"Moved: {moved_in_words(repair.moved)}.")
    return " ".join([*sentences, repair.why]).strip()


def check_rows(*certificates: Certificate) -> list[tuple[str, tuple[str, ...]]]:
    """A row a check that is known of one of them: its name, and a text of each certificate.

    Checks that are broken in one of them come first.
    """
    known = [
        found
        for found in zip(*certificates, strict=True)
        if any(each.worst is not None for each in found)
    ]
    known.sort(key=lambda found: all(each.holds is not False for each in found))
    return [(_name(found[0]), tuple(map(_cell, found))) for found in known]


def _name(found: Finding) -> str:
    return found.name.replace("_", " ")


def _worst(found: Finding) -> str:
    if found.worst is None:
        return ""
    against = ""
    if found.is_length and found.allowed is not None:
        against = f" against {found.shown(found.allowed)}"
    return f" {found.shown(found.worst)}{against} at {found.where} ({found.when})"


def _counted(certificate: Certificate) -> tuple[str, str]:
    """All of the checks in words, or those that are known, and how many are not."""
    unknown = sum(each.holds is None for each in certificate)
    count = len(certificate.findings) - unknown
    if not unknown:
        return f"all {count} checks", ""
    return f"all {count} known checks", f" ({unknown} not known)"


def _cell(found: Finding) -> str:
    if found.worst is None:
        return "not known" if found.holds is None else "✓"
    sign = {True: "✓", False: "✗", None: "–"}[found.holds]
    where = found.where.replace("_", " ")
    return f"{sign} {found.shown(found.worst)}, {where}, {found.when}"
