"""Tables of what a class declares beside its fields, for the API page.

`<!-- fields of Scenario -->` becomes the meaning and range of each field of a request, and
`<!-- arrays of Plan -->` the shape, unit, frame and meaning of each array of a result. Both stand
beside the types in the code (`llsrbm.request.messages`, `llsrbm.files.quantity`), where docstrings
do not repeat them.
"""

from __future__ import annotations

import re
import sys
from dataclasses import fields
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[2]))  # the declarations of this very checkout

from markdown_text import table

import llsrbm
from llsrbm.files.quantity import quantities
from llsrbm.request.messages import FieldSpec, field_specs

PLACE = re.compile(r"<!-- (fields|arrays) of (\w+) -->")


def on_page_markdown(markdown: str, **_: Any) -> str:
    """The page with the tables that it asks for."""
    return PLACE.sub(_table, markdown)


def _table(place: re.Match[str]) -> str:
    kind = getattr(llsrbm, place.group(2))
    return _fields(kind) if place.group(1) == "fields" else _arrays(kind)


def _fields(kind: type) -> str:
    defaults = {field.name: field.default for field in fields(kind)}
    rows = [
        (f"`{name}`", f"`{defaults[name]!r}`", spec.help, _accepted(spec))
        for name, spec in field_specs(kind).items()
    ]
    return table(("field", "default", "meaning", "range"), rows)


def _accepted(spec: FieldSpec) -> str:
    return spec.accepted or getattr(spec, "unit", "")


def _arrays(kind: type) -> str:
    rows = [
        (
            f"`{name}`",
            ", ".join(map(str, each.shape)) or "one number",
            each.unit or ", ".join(f"{k} {code}" for k, code in enumerate(each.codes)),
            each.frame,
            each.meaning,
        )
        for name, each in quantities(kind).items()
    ]
    return table(("array", "shape", "unit", "frame", "meaning"), rows)
