"""The strict jumps of a sweep as trainers' files: computed again, a file each, with an index.

    OUT/dataset.json     which sweep, format and options it is of; written first
    OUT/motions/N.…      a motion, N its row in the sweep; LeRobot: see `llsrbm.formats.datasets`
    OUT/index.parquet    a row a motion: file, request, seed, outcome, licence, versions
    OUT/index.csv        the same

A sweep's table says what was asked; the same request gives the same plan and rollout, as long as
version and robot are the same. A data set that was cut off goes on with the motions that are not
there yet. The index comes last.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from llsrbm.errors import Error, InputError
from llsrbm.files.writing import staged
from llsrbm.formats.base import Options
from llsrbm.formats.datasets.base import DatasetFormat, Episode
from llsrbm.formats.datasets.registry import find_dataset_format
from llsrbm.request.jump import Jump
from llsrbm.sweep import rows as row
from llsrbm.sweep.points import Point
from llsrbm.sweep.shard import origin, plan_of, rollout_of
from llsrbm.sweep.spec import Spec
from llsrbm.sweep.table import TABLE
from llsrbm.version import package_version

if TYPE_CHECKING:
    import pyarrow as pa

    from llsrbm.files.loading import Trajectory

SOURCES = ("rollout", "plan")
SCHEMA = "llsrbm.dataset/1"
LICENCE = "BSD-3-Clause (llsrbm); the robot's description has a licence of its own"

_INDEX = "index"
_DIGITS = 8  # of a motion's number in its file's name: as many as a sweep may have rows
_JUMP = tuple(Jump.__dataclass_fields__)
_ASKED = ("id", *_JUMP, "drive_torque", "drive_speed")
_OF_PLANS = ("duration_s", "takeoff_s", "flight_s", "landing_s", "apex", "torque_share", "cost")
_OUTCOMES = (
    *("landed", "strict", "final_yaw_error", "final_position_error", "final_tilt"),
    *("foot_error", "peak_tilt", "peak_torque_ratio"),
)


@dataclass(frozen=True)
class Summary:
    """What a data set came to.

    Attributes:
        motions: in it; of them `computed` were computed now.
        left_out: numbers of rows that were strict in the sweep, and are not when computed again.
        index: the table of motions.
    """

    motions: int
    computed: int
    left_out: tuple[int, ...]
    index: Path


@dataclass(frozen=True)
class _Sweep:
    """A sweep's folder: `spec`, the rows' `origin`, `table` without what names many numbers."""

    path: Path
    spec: Spec
    digest: str
    origin: dict[str, str]
    table: pa.Table


def make_dataset(
    sweep: Path,
    out: Path,
    format_name: str,
    *,
    robot: str | None = None,
    source: str = SOURCES[0],
    limit: int | None = None,
    fps: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Summary:
    """Write the strict jumps of a sweep.

    Args:
        sweep: the folder of a sweep that is done.
        out: folder of the data set; one that was cut off goes on.
        format_name: of `llsrbm formats`, or "lerobot".
        robot: of these alone.
        source: "rollout", what the whole robot did, each seed a motion; "plan": what was planned,
            of jumps that were strict with every seed.
        limit: motions at most, the first of the sweep.
        fps: frames/s; None: as the format has it.
        progress: told how many motions there are, and of how many.

    Raises:
        InputError: no sweep there, of another version or robot, nothing strict in it, an unknown
            name, or a folder of something else.
        Error: it cannot be written, or nothing is strict any more.
    """
    if source not in SOURCES:
        raise InputError(f'source: expected {" or ".join(SOURCES)}, got "{source}"')
    if limit is not None and limit < 1:
        raise InputError(f"limit: expected 1 or more motions, got {limit}")
    format_ = find_dataset_format(format_name, source)
    options = _options(format_, fps)
    opened = _open(sweep)
    chosen = _strict(opened, robot, source)[:limit]
    _check(opened, chosen, format_)
    _begin(out, opened, format_, {"source": source, "robot": robot, "limit": limit}, options)
    files = [_file(out, format_, values, source) for values in chosen]
    whole = format_.finished is not None and (out / format_.finished).is_file()
    there, computed, left_out = 0, 0, []
    kept: list[tuple[dict[str, Any], Path]] = []
    for values, file in zip(chosen, files, strict=True):
        if not (whole or file.exists()):
            trajectory = _computed(values, opened.spec, source)
            if trajectory is None:
                left_out.append(values["index"])
                continue
            with _told(out):
                file.parent.mkdir(parents=True, exist_ok=True)
            format_.write(trajectory, file, options)
            computed += 1
        there += 1
        kept.append((values, file))
        if progress is not None:
            progress(there, len(chosen) - len(left_out))
    if not kept:
        raise Error(f"{sweep}: none of {len(chosen)} strict rows is strict when computed again")
    if format_.finish is not None and not whole:
        episodes = [Episode(file, _in_words(values)) for values, file in kept]
        with _told(out):
            format_.finish(out, episodes, options)
    index = _write_index(out, kept, format_, options, source)
    return Summary(len(kept), computed, tuple(left_out), index)


def _options(format_: DatasetFormat, fps: float | None) -> Options:
    if fps is None:
        return format_.defaults
    if "fps" not in format_.options:
        raise InputError(f'fps: format "{format_.name}" has no rate; expected no --fps')
    from llsrbm.motion.instants import check_rate

    check_rate(fps)
    options = replace(format_.defaults, fps=fps)
    if format_.check is not None:
        format_.check(options)
    return options


def _open(path: Path) -> _Sweep:
    import pyarrow as pa
    import pyarrow.parquet as pq

    stated, table = path / "sweep.json", path / TABLE
    if not stated.is_file():
        raise InputError(f"{path}: no sweep is there; expected a folder that llsrbm sweep made")
    if not table.is_file():
        raise InputError(
            f"{path}: the sweep is not done; expected {TABLE} in it: run llsrbm sweep again"
        )
    try:
        told = json.loads(stated.read_text(encoding="utf-8"))
        spec, of, digest = Spec.from_json(json.dumps(told["spec"])), told["origin"], told["digest"]
        plain = [
            *("index", "jump", *_ASKED, "seed", "status", *_OF_PLANS, *_OUTCOMES),
            *("version", "robot_hash", *(row.LIMIT + name for name in spec.limits)),
        ]
        return _Sweep(path, spec, digest, of, pq.read_table(table, columns=plain))
    except (ValueError, KeyError, TypeError, OSError, pa.ArrowException) as error:
        raise InputError(f"{path}: the sweep is damaged; expected one of llsrbm sweep") from error


def _strict(sweep: _Sweep, robot: str | None, source: str) -> list[dict[str, Any]]:
    """Rows, in order; of plans one a jump."""
    import pyarrow.compute as pc

    table = sweep.table
    if not sweep.spec.simulated:
        raise InputError(
            f"{sweep.path}: its jumps were planned and not simulated, none is strict; expected a "
            "sweep with [simulate]"
        )
    if robot is not None:
        if robot not in sweep.spec.robots:
            raise InputError(
                f"{sweep.path}: nothing of robot {robot} is in it; expected "
                f"{' or '.join(sweep.spec.robots)}"
            )
        table = table.filter(pc.equal(table["robot"], robot))
    strict = table.filter(pc.fill_null(table["strict"], False))
    if source == "plan":
        seeds = sweep.spec.rows_a_jump()
        counted = strict.group_by("jump").aggregate([("strict", "count")])
        every = counted.filter(pc.equal(counted["strict_count"], seeds))["jump"]
        strict = strict.filter(pc.is_in(strict["jump"], every.combine_chunks()))
        strict = strict.filter(pc.equal(pc.subtract(strict["index"], _first(strict, seeds)), 0))
    if len(strict) == 0:
        of = "" if robot is None else f" of {robot}"
        raise InputError(
            f"{sweep.path}: none of {len(table)} rows{of} is strict; expected a sweep in which "
            "some land by the strict measure"
        )
    found: list[dict[str, Any]] = strict.to_pylist()
    return found


def _first(table: pa.Table, seeds: int) -> Any:
    """Numbers of the first rows of the same jumps."""
    import pyarrow.compute as pc

    return pc.multiply(table["jump"], seeds)


def _check(sweep: _Sweep, chosen: Sequence[dict[str, Any]], format_: DatasetFormat) -> None:
    robots = list(dict.fromkeys(values["robot"] for values in chosen))
    if format_.one_robot and len(robots) > 1:
        raise InputError(
            f'format "{format_.name}" holds one robot, the sweep has {", ".join(robots)}; expected '
            "--robot with one of them"
        )
    now = origin(sweep.spec)
    for name in ("llsrbm", *robots):
        if sweep.origin.get(name) != now[name]:
            what = "llsrbm" if name == "llsrbm" else f"robot {name}"
            raise InputError(
                f"{sweep.path}: the sweep is of {what} {sweep.origin.get(name)}, here is "
                f"{now[name]}: its motions would be others; expected the same, or a new sweep"
            )


def _begin(
    out: Path,
    sweep: _Sweep,
    format_: DatasetFormat,
    asked: dict[str, Any],
    options: Options,
) -> None:
    """Write what the folder is of, or compare."""
    used = {name: value for name, value in asdict(options).items() if name in format_.options}
    stated = {
        "schema": SCHEMA,
        "format": format_.name,
        "options": used,
        **asked,
        "sweep": {"title": sweep.spec.title, "digest": sweep.digest, "origin": sweep.origin},
        "licence": LICENCE,
        "package_version": package_version(),
    }
    path = out / "dataset.json"
    with _told(out):
        if out.exists() and not out.is_dir():
            raise InputError(f"{out}: is a file; expected a folder")
        out.mkdir(parents=True, exist_ok=True)
        if path.is_file():
            if path.read_text(encoding="utf-8") != _text(stated):
                raise InputError(
                    f"{out}: holds another data set; expected the same sweep and options, or "
                    "another folder for --out"
                )
            return
        others = [p.name for p in out.iterdir() if not p.name.startswith(".")]
        if others:
            raise InputError(f"{out}: holds {others[0]}, and no data set; expected an empty folder")
        with staged(path) as target:
            target.write_text(_text(stated), encoding="utf-8")


def _text(stated: dict[str, Any]) -> str:
    return json.dumps(stated, indent=2) + "\n"


def _file(out: Path, format_: DatasetFormat, values: dict[str, Any], source: str) -> Path:
    number = values["jump"] if source == "plan" else values["index"]
    robot = Path(values["robot"]).stem
    return out / format_.folder / f"{robot}-{number:0{_DIGITS}d}{format_.suffix}"


def _computed(values: dict[str, Any], spec: Spec, source: str) -> Trajectory | None:
    """The motion of a row; None: it is not what the row says."""
    point = Point(
        number=values["jump"],
        jump=Jump(**{name: values[name] for name in _JUMP}),
        limits={name: values[row.LIMIT + name] for name in spec.limits},
        drive_torque=values["drive_torque"],
        drive_speed=values["drive_speed"],
        seeds=(values["seed"],),
    )
    try:
        plan = plan_of(point, spec)
        if source == "plan":
            return plan
        rollout = rollout_of(point, plan, spec, values["seed"])
    except Error:
        return None
    return rollout if rollout.outcome.strict else None


def _in_words(values: dict[str, Any]) -> str:
    """What a motion does, to whole degrees and centimetres."""
    told = [f"twist {math.degrees(values['twist']):.0f} deg"]
    told += [f"{name} {values[name] + 0.0:.2f} m" for name in ("forward", "lateral", "height")]
    told += [
        f"{name} {math.degrees(values[name]):.0f} deg" for name in ("roll", "pitch") if values[name]
    ]
    told += [f"{name} {values[name]:.1f} m/s" for name in ("speed", "end_speed") if values[name]]
    told += [f"{values['hops']} hops"] if values["hops"] > 1 else []
    kind = "" if values["type"] == Jump.type else f" ({values['type']})"
    return f"jump{kind}: {', '.join(told)}"


def _write_index(
    out: Path,
    kept: Sequence[tuple[dict[str, Any], Path]],
    format_: DatasetFormat,
    options: Options,
    source: str,
) -> Path:
    """The table of motions, twice."""
    import pyarrow as pa
    import pyarrow.parquet as pq
    from pyarrow import csv

    of_seeds = () if source == "plan" else ("index", "seed", *_OUTCOMES)
    own = [name for name in kept[0][0] if name.startswith(row.LIMIT)]
    names = ["jump", *of_seeds, *_ASKED, *own, *_OF_PLANS]
    rate = options.fps if "fps" in format_.options else None
    rows = [
        {
            "episode": number,
            "file": _place(out, file, format_),
            "source": source,
            "format": format_.name,
            "fps": rate,
            "task": _in_words(values),
            **{name: values[name] for name in names},
            "licence": LICENCE,
            "version": values["version"],
            "robot_hash": values["robot_hash"],
        }
        for number, (values, file) in enumerate(kept)
    ]
    table = pa.Table.from_pylist(rows)
    path = out / f"{_INDEX}.parquet"
    with staged(out / f"{_INDEX}.csv") as target:
        csv.write_csv(table, target)
    with staged(path) as target:
        pq.write_table(table, target)
    return path


def _place(out: Path, file: Path, format_: DatasetFormat) -> str | None:
    """Of a motion's own file in the data set; None where all are in the same ones."""
    return None if format_.finish is not None else file.relative_to(out).as_posix()


class _told:
    """Say in one line what a disk refuses."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def __enter__(self) -> None:
        pass

    def __exit__(self, _: object, error: BaseException | None, __: object) -> None:
        if isinstance(error, OSError):
            raise Error(
                f"{self._path}: cannot be written ({error.strerror or error}); what is done is "
                "kept: run the same command again to go on"
            ) from error
