"""Numbers as people read them, and tables: − for a minus, no sign on zero, °, other units apart.

For prose and tables, of the page and of the command line. JSON and files have plain numbers.
"""

import math
from collections.abc import Sequence


def decimal(value: float, places: int = 0, *, signed: bool = False) -> str:
    """With so many digits after the point; `signed`: with a plus where there is no minus."""
    text = f"{value:+z.{places}f}" if signed else f"{value:z.{places}f}"
    # "z" takes the minus from a zero, but leaves a plus.
    return _minus(text.lstrip("+") if float(text) == 0 else text)


def short(value: float, digits: int = 6) -> str:
    """With up to so many significant digits, without trailing zeros."""
    return _minus(f"{value:z.{digits}g}")


def power(value: float, places: int = 1) -> str:
    """As a power of ten, for small values."""
    return _minus(f"{value:z.{places}e}")


def percent(share: float, places: int = 0, *, signed: bool = False) -> str:
    """A share, of which 1 is all, in per cent."""
    return f"{decimal(100 * share, places, signed=signed)} %"


def degrees(angle: float, places: int = 1, *, signed: bool = False) -> str:
    """An angle (rad), in degrees."""
    return f"{decimal(math.degrees(angle), places, signed=signed)}°"


def duration(seconds: float) -> str:
    """For instance "40 s", "12 min", "3.5 h" or "2.1 days"."""
    for unit, size, limit in (("s", 1.0, 90.0), ("min", 60.0, 5400.0), ("h", 3600.0, 172_800.0)):
        if seconds < limit:
            amount = seconds / size
            return f"{amount:.1f} {unit}" if unit == "h" else f"{amount:.0f} {unit}"
    return f"{seconds / 86_400:.1f} days"


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Lines of a table, its columns as wide as their longest cell."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    pad = (zip(row, widths, strict=True) for row in rows)
    return ["  ".join(f"{cell:<{width}}" for cell, width in cells).rstrip() for cells in pad]


def _minus(text: str) -> str:
    return text.replace("-", "−")
