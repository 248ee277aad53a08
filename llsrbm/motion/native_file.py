"""What the native files of plans and rollouts share: a schema, JSON at `meta`, finite arrays."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, ValidationError

from llsrbm.errors import Error, FileFormatError, InputError
from llsrbm.jump import Jump
from llsrbm.motion.archive import Arrays, Entry, text, write_archive

_UNIT_QUATERNION = 1e-3  # largest deviation of a norm from 1 that still is an attitude
_STORED: dict[str, type[np.generic]] = {"real": np.float64, "whole": np.int64, "text": np.str_}


class Meta(BaseModel):
    """The JSON at `meta`: where the arrays come from."""

    # JSON has no NaN, which the cost of a plan that did not converge may be.
    model_config = ConfigDict(ser_json_inf_nan="strings")

    request: Jump
    model: str
    robot_parameters: dict[str, Any]
    package_version: str


_MetaType = TypeVar("_MetaType", bound=Meta)


def write_native(
    path: str | Path, schema: str, meta: Meta, trajectory: Any, layout: Mapping[str, Entry]
) -> None:
    """Write the attributes of `trajectory` that `layout` names, atomically.

    Raises:
        InputError: the file cannot be written.
        Error: the trajectory holds numbers that are not finite.
    """
    arrays: Arrays = {}
    for key, entry in layout.items():
        value = np.asarray(getattr(trajectory, key), dtype=_STORED[entry.kind])
        if value.dtype.kind == "f" and not np.isfinite(value).all():
            what = type(trajectory).__name__.lower()
            raise Error(f"{what}.{key} holds numbers that are not finite; it is not written")
        arrays[key] = value
    write_archive(
        path, {"schema": np.array(schema), "meta": np.array(meta.model_dump_json()), **arrays}
    )


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
    """Raise `FileFormatError` unless there are two or more times that increase."""
    if len(time) < 2 or (np.diff(time) <= 0).any():
        raise FileFormatError(f'{path}: key "time": expected 2 or more strictly increasing times')


def check_quaternions(values: Arrays, keys: tuple[str, ...], path: str | Path) -> None:
    """Raise `FileFormatError` unless what is at `keys`, (..., 4), are attitudes."""
    for key in keys:
        if (np.abs(np.linalg.norm(values[key], axis=-1) - 1) > _UNIT_QUATERNION).any():
            raise FileFormatError(f'{path}: key "{key}": expected unit quaternions w, x, y, z')
