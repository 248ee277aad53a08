"""The certificate of a motion as a table, each finding with the instant to look at."""

from html import escape

from app.panel.html import DIM, SMALL
from llsrbm.certificate import Certificate, Finding

_SIGNS = {True: ("✓", "holds"), False: ("✗", "does not hold"), None: ("–", "not known")}
_CELL = "padding:0.1em 0.5em 0.1em 0;vertical-align:top;text-align:left;font-weight:normal"
_HEADS = ("", "Check", "Worst, limit", "Where, when")


def certificate_table(certificate: Certificate, of: str) -> str:
    """All findings; `of`: what was checked, in words."""
    head = "".join(f'<th scope="col" style="{_CELL};{DIM}">{title}</th>' for title in _HEADS)
    rows = "".join(map(_row, certificate))
    return (
        f'<div style="{SMALL}"><b>{escape(_verdict(certificate, of))}</b>'
        f'<table class="llsrbm-certificate" style="border-spacing:0"><tr>{head}</tr>{rows}</table>'
        "</div>"
    )


def _verdict(certificate: Certificate, of: str) -> str:
    if certificate.holds:
        return f"All checks of the {of} hold."
    broken = len(certificate.broken)
    if not broken:
        return f"No check of the {of} fails; some could not be evaluated."
    return f"{broken} {'check' if broken == 1 else 'checks'} of the {of} {_do(broken)} not hold."


def _do(count: int) -> str:
    return "does" if count == 1 else "do"


def _row(found: Finding) -> str:
    sign, words = _SIGNS[found.holds]
    name = found.name.replace("_", " ")
    mark = (
        f'<td style="{_CELL}" aria-label="{words}" title="{words}">{sign}</td>'
        f'<th scope="row" style="{_CELL}">{escape(name)}</th>'
    )
    if found.worst is None or found.time_s is None or found.limit is None:
        return f'<tr>{mark}<td colspan="2" style="{_CELL};{DIM}">{escape(found.why)}</td></tr>'
    limit = f"{found.limit:.3g} {found.unit}".strip()
    if found.is_length and found.allowed is not None:
        limit = found.shown(found.allowed)
    # A wide name may break where its words end.
    where = f"{found.where.replace('_', ' ')}, {found.when}{': ' if found.why else ''}{found.why}"
    return (
        f'<tr>{mark}<td style="{_CELL};white-space:nowrap">{found.shown(found.worst)}'
        f'<br><span style="{DIM}">{escape(limit)}</span></td><td style="{_CELL}">'
        f'<button type="button" data-seek="{found.time_s:.4f}" '
        f'title="Go to that instant">{escape(where)}</button></td></tr>'
    )
