"""What the native files of plans and rollouts share: a schema, JSON at `meta`, finite arrays."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError

from llsrbm.errors import Error, FileFormatError, InputError
from llsrbm.jump import Jump
from llsrbm.motion.archive import Arrays, text
from llsrbm.motion.quantity import WXYZ, Kind, Quantity

_UNIT_QUATERNION = 1e-3  # largest deviation of a norm from 1 that still is an attitude
_SAME_INSTANT = 1e-9  # s
_STORED: dict[Kind, type[np.generic]] = {
    Kind.REAL: np.float64,
    Kind.WHOLE: np.int64,
    Kind.TEXT: np.str_,
}


class Meta(BaseModel):
    """The JSON at `meta`: where the arrays come from."""

    # JSON has no NaN, which the cost of a plan that did not converge may be.
    model_config = ConfigDict(ser_json_inf_nan="strings")

    request: Jump
    model: str
    robot_parameters: dict[str, Any]
    package_version: str


_MetaType = TypeVar("_MetaType", bound=Meta)


def native_arrays(
    schema: str, meta: Meta, trajectory: Any, layout: Mapping[str, Quantity]
) -> Arrays:
    """What a file holds of a trajectory: the attributes that `layout` names, schema and `meta`.

    Raises:
        Error: the trajectory holds numbers that are not finite.
    """
    arrays: Arrays = {"schema": np.array(schema), "meta": np.array(meta.model_dump_json())}
    for key, entry in layout.items():
        value = np.asarray(getattr(trajectory, key), dtype=_STORED[entry.kind])
        if value.dtype.kind == "f" and not np.isfinite(value).all():
            what = type(trajectory).__name__.lower()
            raise Error(f"{what}.{key} holds numbers that are not finite; it is not written")
        arrays[key] = value
    return arrays


def read_meta(kind: type[_MetaType], arrays: Arrays, path: str | Path) -> _MetaType:
    """What an archive has at `meta`.

    Raises:
        FileFormatError: missing, no JSON, or not what `kind` describes.
    """
    content = text(arrays, "meta", path)
    where = f'{path}: key "meta"'
    try:
        return kind.model_validate_json(content)
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"]) or "JSON"
        raise FileFormatError(f"{where}: {place}: {first['msg']}") from error
    except InputError as error:  # what the request or the scenario checks itself
        raise FileFormatError(f"{where}: {error}") from error


def check_times(time: Any, path: str | Path) -> None:
    """Raise `FileFormatError` unless there are two or more times that increase from 0 on."""
    if len(time) < 2 or (np.diff(time) <= 0).any() or abs(time[0]) > _SAME_INSTANT:
        raise FileFormatError(
            f'{path}: key "time": expected 2 or more strictly increasing times from 0 s on'
        )


def check_numbers(values: Arrays, layout: Mapping[str, Quantity], path: str | Path) -> None:
    """Raise `FileFormatError` unless attitudes are unit quaternions and codes are known ones."""
    for key, quantity in layout.items():
        where = f'{path}: key "{key}"'
        if quantity.axes[-1:] == (WXYZ,):
            off = np.abs(np.linalg.norm(values[key], axis=-1) - 1)
            if (off > _UNIT_QUATERNION).any():
                raise FileFormatError(f"{where}: expected unit quaternions w, x, y, z")
        if quantity.codes and not np.isin(values[key], range(len(quantity.codes))).all():
            meanings = (f"{number} ({meaning})" for number, meaning in enumerate(quantity.codes))
            raise FileFormatError(f"{where}: expected {', '.join(meanings)}")
