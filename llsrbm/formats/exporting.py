"""Writing trajectories in any format: nobody ever sees half a file."""

from __future__ import annotations

import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from llsrbm.errors import InputError
from llsrbm.files.atomic import staged
from llsrbm.formats.base import Format, Options
from llsrbm.formats.registry import find
from llsrbm.motion.plan import Plan
from llsrbm.motion.trajectory import Trajectory


def export(
    trajectory: Trajectory,
    path: str | Path,
    format: str | Sequence[str] = "npz",  # noqa: A002  # the word of the public interface
    **options: Any,
) -> None:
    """Write a trajectory to a file, or in several formats into a zip.

    Args:
        trajectory: what `llsrbm.plan`, `llsrbm.simulate` or `llsrbm.load` returned.
        path: the file, or the folder of a format that is one; replaced when all has been written.
            A path that ends in ".zip" gets an archive of all that is written.
        format: a name, or several, of `llsrbm formats`.
        options: of `llsrbm.formats.base.Options`, as far as the formats take them: `fps`, `pad`,
            `order`, `size`, `camera`.

    Raises:
        InputError: no such format, or one that cannot hold the trajectory, whose packages are
            missing or that takes no such option; a value that makes no sense; a file that cannot be
            written. Nothing is left behind.
    """
    names = [format] if isinstance(format, str) else list(dict.fromkeys(format))
    if not names:
        raise InputError("no format is named; expected one or more of `llsrbm formats`")
    formats = [find(name) for name in names]
    chosen = [(each, _options(each, options)) for each in formats]
    for each in formats:
        _check(each, trajectory)
    _check_used(formats, options)
    path = Path(path)
    if path.suffix.lower() == ".zip":
        with staged(path) as target:
            _write_zip(trajectory, chosen, target)
        return
    if len(formats) > 1:
        raise InputError(
            f"{path}: {len(formats)} formats do not fit into one file; expected a path that ends "
            "in .zip"
        )
    with staged(path) as target:
        chosen[0][0].write(trajectory, target, chosen[0][1])


def stem(trajectory: Trajectory) -> str:
    """A name for files of a trajectory: robot, model, plan or rollout."""
    kind = "plan" if isinstance(trajectory, Plan) else "rollout"
    return f"{Path(trajectory.jump.robot).stem}-{trajectory.jump.model}-{kind}"


def file_name(trajectory: Trajectory, names: Sequence[str]) -> str:
    """Under which an export can be offered as one file."""
    formats = [find(name) for name in names]
    if len(formats) == 1 and formats[0].suffix:
        return stem(trajectory) + formats[0].suffix
    return stem(trajectory) + ".zip"


def _write_zip(
    trajectory: Trajectory, chosen: Sequence[tuple[Format, Options]], target: Path
) -> None:
    with tempfile.TemporaryDirectory() as folder:
        for format_, options in chosen:
            own = f"-{format_.name}" if len(chosen) > 1 else ""
            format_.write(
                trajectory, Path(folder) / f"{stem(trajectory)}{own}{format_.suffix}", options
            )
        with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in sorted(Path(folder).rglob("*")):
                if file.is_file():
                    archive.write(file, file.relative_to(folder))


def _options(format_: Format, given: dict[str, Any]) -> Options:
    """The format's own defaults, changed by what was given and is for it."""
    known = Options.__dataclass_fields__
    for name in given:
        if name not in known:
            raise InputError(f"no option {name} of an export; expected {', '.join(known)}")
    return replace(format_.defaults, **{n: v for n, v in given.items() if n in format_.options})


def _check_used(formats: Sequence[Format], given: dict[str, Any]) -> None:
    """An option that none of the formats takes would be ignored in silence."""
    for name in given:
        if not any(name in each.options for each in formats):
            taken = sorted({option for each in formats for option in each.options})
            listed = f"its options are {', '.join(taken)}" if taken else "it has no options"
            names = ", ".join(each.name for each in formats)
            raise InputError(f'{name}: is not for format "{names}"; {listed}')


def _check(format_: Format, trajectory: Trajectory) -> None:
    kind = "plan" if isinstance(trajectory, Plan) else "rollout"
    if kind not in format_.holds:
        raise InputError(
            f'format "{format_.name}" cannot hold a {kind}; expected a {" or ".join(format_.holds)}'
        )
    format_.check_installed()
