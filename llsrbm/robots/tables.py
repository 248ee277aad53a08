"""What the tables of a robot file have in common: strict, and numbers that must make sense."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field
from pydantic_core import PydanticCustomError


def _ordered(interval: tuple[float, float]) -> tuple[float, float]:
    if interval[0] > interval[1]:
        raise PydanticCustomError("interval", "the first number (lower) exceeds the second (upper)")
    return interval


Interval = Annotated[tuple[float, float], AfterValidator(_ordered)]
Vector = tuple[float, float, float]
Positive = Annotated[float, Field(gt=0)]
Length = Annotated[float, Field(ge=0)]
PositiveInterval = Annotated[tuple[Positive, Positive], AfterValidator(_ordered)]


class Table(BaseModel):
    """A table of a robot file: no unknown keys, no conversions, no changes."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


def with_tuples(value: Any) -> Any:
    """TOML arrays as tuples, which strict validation asks for."""
    if isinstance(value, dict):
        return {key: with_tuples(item) for key, item in value.items()}
    if isinstance(value, list):
        return tuple(with_tuples(item) for item in value)
    return value
