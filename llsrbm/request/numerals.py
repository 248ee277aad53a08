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
