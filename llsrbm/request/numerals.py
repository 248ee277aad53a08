"""Numbers as text: with so many decimals, and never a zero with a minus sign."""

from __future__ import annotations


def decimal(value: float, places: int = 0, *, signed: bool = False) -> str:
    """With so many digits after the point; `signed`: with a plus where there is no minus."""
    return f"{value:+z.{places}f}" if signed else f"{value:z.{places}f}"


def percent(share: float, places: int = 0, *, signed: bool = False) -> str:
    """A share, of which 1 is all, in per cent."""
    return f"{decimal(100 * share, places, signed=signed)}%"


def power(value: float, places: int = 1) -> str:
    """As a power of ten, for what may be very small."""
    return f"{value:z.{places}e}"


def short(value: float) -> str:
    """With up to six digits, and none that say nothing."""
    return f"{value:zg}"


def duration(seconds: float) -> str:
    """For instance "40 s", "12 min", "3.5 h" or "2.1 days"."""
    for unit, size, limit in (("s", 1.0, 90.0), ("min", 60.0, 5400.0), ("h", 3600.0, 172_800.0)):
        if seconds < limit:
            amount = seconds / size
            return f"{amount:.1f} {unit}" if unit == "h" else f"{amount:.0f} {unit}"
    return f"{seconds / 86_400:.1f} days"
