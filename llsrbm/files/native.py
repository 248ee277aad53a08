"""Common to the native files of plans and rollouts: a schema, JSON at `meta`, declared arrays."""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, NotRequired, TypeVar

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainSerializer,
    ValidationError,
    field_validator,
)
from typing_extensions import TypedDict  # of `typing` before 3.12 it is too little for pydantic

from llsrbm.errors import Error, FileFormatError, InputError, printable
from llsrbm.files.npz import LARGEST_NUMBER, Arrays, text
from llsrbm.files.quantity import Kind, Quantity
from llsrbm.installed import package_version
from llsrbm.request.jump import Jump
from llsrbm.request.stones import stone_rows

_SAME_INSTANT = 1e-9  # s
_LONGEST = 100.0  # s; jumps take two
_LARGEST_WHOLE = 2**64
_STORED: dict[Kind, type[np.generic]] = {
    Kind.REAL: np.float64,
    Kind.WHOLE: np.int64,
    Kind.TEXT: np.str_,
}


def _one_line(value: str) -> str:
    if not value.isprintable():
        raise ValueError("expected one line of printable text")
    return value


_Name = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(_one_line)]
_Names = list[_Name]
_Vector = Annotated[list[float], Field(min_length=3, max_length=3)]


def _first(error: ValidationError) -> str:
    first = error.errors()[0]
    place = printable(".".join(str(part) for part in first["loc"])) or "JSON"
    return f"{place}: {printable(first['msg'].removeprefix('Value error, '), 200)}"


_Text = Annotated[str, Field(max_length=500), AfterValidator(_one_line)]
_Length = Annotated[float, Field(ge=-LARGEST_NUMBER, le=LARGEST_NUMBER)]


class StatedFinding(TypedDict):
    """One check's finding as `llsrbm.certificate.Finding.as_dict` has it."""

    worst: _Length | None
    limit: _Length | None
    unit: _Text
    where: _Text
    time_s: _Length | None
    holds: bool | None
    allowed: _Length | None
    why: _Text
    beyond_s: NotRequired[_Length | None]


StatedCertificate = Annotated[dict[_Name, StatedFinding], Field(max_length=100)]
"""Name of a check -> its finding: the certificate that a file carries."""


class _RobotLimits(BaseModel):
    friction: Annotated[float, Field(gt=0, le=1e3)] = 0.5


class _RobotNumbers(BaseModel):
    """Those of a robot's numbers that the library itself looks at, where a file has them."""

    name: str = ""
    mass: Annotated[float, Field(gt=0, le=1e6)] = 1.0
    inertia: Annotated[list[_Vector], Field(min_length=3, max_length=3)] | None = None
    legs: dict[_Name, Any] = Field(default_factory=dict)
    joint_names: _Names = Field(default_factory=list)
    sliding_joints: _Names = Field(default_factory=list)
    limits: _RobotLimits | None = None


def _with_rows(request: Any) -> Any:
    if not isinstance(request, Mapping) or "stones" not in request:
        return request
    return {**request, "stones": stone_rows(request["stones"])}


StatedJump = Annotated[Jump, BeforeValidator(_with_rows), PlainSerializer(Jump.as_dict)]
"""A request as files have it."""


class Meta(BaseModel):
    """The JSON at `meta`: where the arrays come from."""

    # JSON has no NaN, which the cost of a plan that did not converge may be.
    model_config = ConfigDict(ser_json_inf_nan="strings")

    request: StatedJump
    model: str
    robot_parameters: dict[str, Any]
    package_version: str = Field(default_factory=package_version)
    certificate: StatedCertificate | None = None

    @field_validator("robot_parameters")
    @classmethod
    def _as_they_are_used(cls, value: dict[str, Any]) -> dict[str, Any]:
        try:
            _RobotNumbers.model_validate(value, strict=True)
        except ValidationError as error:
            raise ValueError(_first(error)) from None
        return value


_MetaType = TypeVar("_MetaType", bound=Meta)


def native_arrays(
    schema: str, meta: Meta, trajectory: Any, layout: Mapping[str, Quantity]
) -> Arrays:
    """A trajectory's file: schema, `meta`, and the attributes in `layout` that are not None.

    Raises `Error` for numbers that are not finite.
    """
    arrays: Arrays = {"schema": np.array(schema), "meta": np.array(meta.model_dump_json())}
    for key, quantity in layout.items():
        known = getattr(trajectory, key)
        if known is None:
            continue
        value = np.asarray(known, dtype=_STORED[quantity.kind])
        if value.dtype.kind == "f" and not (np.abs(value) <= LARGEST_NUMBER).all():
            raise Error(
                f"{type(trajectory).__name__.lower()}.{key} holds numbers that are not finite or "
                f"beyond {LARGEST_NUMBER:g}; it is not written"
            )
        arrays[key] = value
    return arrays


def part_of(arrays: Arrays, prefix: str) -> Arrays:
    """The arrays whose keys begin with a prefix, without it."""
    return {key.removeprefix(prefix): a for key, a in arrays.items() if key.startswith(prefix)}


def check_schema(arrays: Arrays, path: str | Path, *known: str) -> str:
    """The schema of an archive, which is one of `known`; else raises `FileFormatError`."""
    schema = text(arrays, "schema", path)
    if schema in known:
        return schema
    kind, _, number = schema.partition("/")
    for each in known:
        own_kind, _, own = each.partition("/")
        if kind == own_kind and re.fullmatch(r"[1-9][0-9]{0,5}", number) and int(number) > int(own):
            raise FileFormatError(
                f'{path}: schema "{schema}", written by a newer llsrbm{_version(arrays, path)}; '
                f"llsrbm {package_version()} reads {', '.join(known)}; expected an older file, or "
                "update llsrbm"
            )
    quoted = " or ".join(f'"{each}"' for each in known)
    raise FileFormatError(f'{path}: schema "{printable(schema)}"; expected {quoted}')


def _version(arrays: Arrays, path: str | Path) -> str:
    """Version of the package that wrote the file, in brackets; "" where it cannot be read."""
    try:
        version = json.loads(text(arrays, "meta", path))["package_version"]
    except (FileFormatError, ValueError, LookupError, TypeError, RecursionError):
        return ""
    return f" ({printable(str(version), 20)})"


def read_meta(kind: type[_MetaType], arrays: Arrays, path: str | Path) -> _MetaType:
    """The JSON that an archive has at `meta`; `FileFormatError` unless as `kind` describes."""
    content = text(arrays, "meta", path)
    where = f'{path}: key "meta"'
    try:
        meta = kind.model_validate_json(content)
    except ValidationError as error:
        raise FileFormatError(f"{where}: {_first(error)}") from error
    except InputError as error:  # the request's own checks
        raise FileFormatError(f"{where}: {printable(str(error), 300)}") from error
    if _has_endless_numbers(meta.model_dump()):
        raise FileFormatError(f"{where}: expected whole numbers up to 2^64")
    return meta


def _has_endless_numbers(value: Any) -> bool:
    if isinstance(value, dict):
        return any(map(_has_endless_numbers, value.values()))
    if isinstance(value, list | tuple):
        return any(map(_has_endless_numbers, value))
    return isinstance(value, int) and abs(value) > _LARGEST_WHOLE


def check_times(time: Any, path: str | Path) -> None:
    """Raise `FileFormatError` unless there are two or more times that increase from 0 on."""
    apart = (np.diff(time) >= _SAME_INSTANT).all()
    if len(time) < 2 or not apart or abs(time[0]) > _SAME_INSTANT or time[-1] > _LONGEST:
        raise FileFormatError(
            f'{path}: key "time": expected 2 or more strictly increasing times from 0 s on, up to '
            f"{_LONGEST:g} s"
        )


def check_phases(phase: Any, names: tuple[str, ...], path: str | Path, order: str = "") -> None:
    """Raise `FileFormatError` unless numbers are phases of a schedule with these names."""
    if order or not np.isin(phase, range(len(names))).all():
        listed = ", ".join(f"{number} ({name})" for number, name in enumerate(names))
        raise FileFormatError(f'{path}: key "phase": expected {printable(listed, 300)}{order}')
