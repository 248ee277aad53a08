"""Elements of a URDF and their numbers, checked as they were written.

What a reader would leave out without a word is an error here: a text that is no number, a second
element where one counts, an attribute or an element that is almost called like one that counts.
"""

from __future__ import annotations

import difflib
import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import dataclass

from llsrbm.errors import RobotFileError, printable
from llsrbm.request.messages import choices
from llsrbm.request.tables import LARGEST

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
FARTHEST = 100.0
"""Of lengths and of places seen from their parent, m: parts that are farther are in mm."""

_SMALLEST = 1e-6  # m: no length that a robot has is shorter
_ALMOST = 0.8  # likeness of names from which on one is taken for the other, misspelt
_WITH_A_PLACE = {
    *("robot", "link", "joint", "inertial", "visual", "collision", "geometry", "mass", "inertia"),
    *("parent", "child", "axis", "limit", "mimic"),
}
_XACRO = re.compile(r"\$\{|\$\(")


@dataclass(frozen=True)
class Part:
    """An element of a URDF, with how messages about it begin: the file, then link or joint."""

    element: ET.Element
    where: str

    @property
    def tag(self) -> str:
        """Its name."""
        return str(self.element.tag)

    def fault(self, text: str) -> RobotFileError:
        """An error about it."""
        return RobotFileError(f"{self.where}: {text}")

    def check(self, known: Iterable[str], strict: bool = False) -> None:
        """Refuse attributes almost called like a `known` one, or if `strict` all others."""
        for key in self.element.attrib:
            if key in known or key.startswith("{"):
                continue
            close = difflib.get_close_matches(key.lower(), known, 1, _ALMOST)
            if strict or close:
                raise self.fault(
                    f'<{self.tag} {printable(key)}="..."> has no meaning; {choices(key, known)}'
                )

    def children(self, known: Iterable[str]) -> None:
        """Refuse elements inside it that are almost called like a `known` one, or that have a
        meaning elsewhere in a URDF: readers would leave them out.
        """
        for tag in (str(child.tag) for child in self.element):
            close = difflib.get_close_matches(tag.lower(), known, 1, _ALMOST)
            if tag not in known and (close or tag in _WITH_A_PLACE):
                where = "" if close else f" in <{self.tag}>"
                raise self.fault(f"<{printable(tag)}> has no meaning{where}; {choices(tag, known)}")

    def one(self, tag: str) -> Part | None:
        """The element of that name inside it; None: it has none. Two are refused."""
        found = self.element.findall(tag)
        if len(found) > 1:
            raise self.fault(f"it has {len(found)} elements <{tag}>; expected one")
        return Part(found[0], self.where) if found else None

    def needed(self, tag: str) -> Part:
        """The element of that name inside it."""
        found = self.one(tag)
        if found is None:
            raise self.fault(f"<{self.tag}> has no <{tag}>; expected one")
        return found

    def text(self, key: str) -> str:
        """An attribute that must be there, and not empty."""
        value = self.element.get(key)
        if not value:
            raise self.fault(f'<{self.tag}> has no {key}; expected {key}="..."')
        if not value.isprintable():
            raise self.fault(
                f'<{self.tag} {key}="{printable(value)}"> has control codes or ends of lines; '
                "expected letters that can be printed"
            )
        return plain(value, self)

    def numbers(
        self,
        key: str,
        count: int,
        default: tuple[float, ...] | None = None,
        largest: float = LARGEST,
    ) -> list[float]:
        """So many numbers of an attribute, none beyond `largest` either way; without `default` it
        must be there.
        """
        value = self.element.get(key)
        if value is None and default is not None:
            return list(default)
        given = f'<{self.tag} {key}="{printable(value or "")}">'
        what = "a number" if count == 1 else f"{count} numbers"
        if value is None:
            raise self.fault(f"<{self.tag}> has no {key}; expected {what}")
        texts = plain(value, self).split()
        if len(texts) != count or not all(map(_NUMBER.fullmatch, texts)):
            raise self.fault(f'{given}: expected {what}, such as "{" ".join(["0.1"] * count)}"')
        found = [float(text) for text in texts]
        if not all(abs(number) <= largest and math.isfinite(number) for number in found):
            bound = f"up to {largest:g} either way" if largest < math.inf else "that can be held"
            raise self.fault(f"{given}: expected {what} in SI units, {bound}")
        return found

    def number(self, key: str, default: float | None = None, largest: float = LARGEST) -> float:
        """One number."""
        (found,) = self.numbers(key, 1, None if default is None else (default,), largest)
        return found

    def not_negative(self, **numbers: float) -> None:
        """Refuse attributes with a number below zero."""
        for key, value in numbers.items():
            if value < 0:
                raise self.fault(f'<{self.tag} {key}="{value:g}">: expected 0 or more')

    def positive(self, key: str, count: int) -> tuple[float, ...]:
        """Lengths."""
        found = self.numbers(key, count, largest=FARTHEST)
        if min(found) < _SMALLEST:
            shown = f'<{self.tag} {key}="{printable(self.element.get(key, ""))}">'
            raise self.fault(f"{shown}: expected more than 0 m, {_SMALLEST:g} m at least")
        return tuple(found)


def plain(value: str, part: Part) -> str:
    """A text in which nothing is left for xacro to do."""
    if _XACRO.search(value):
        raise part.fault(
            f'<{part.tag} ...="{printable(value)}"> is for xacro, which was not run; expected what '
            "`xacro robot.urdf.xacro > robot.urdf` writes"
        )
    return value
