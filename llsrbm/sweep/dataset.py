"""The strict jumps of a sweep as trainers' files: computed again, a file each, with an index.

    OUT/dataset.json     which sweep, format and options it is of, with which drives of its robots:
                         armature, friction, damping by joint, delay, how known; written first
    OUT/motions/N.…      a motion, N its row in the sweep; LeRobot: see `llsrbm.formats.datasets`
    OUT/index.parquet    a row a motion: file, request, seed, outcome, licence, versions
    OUT/index.csv        the same

The same request gives the same plan and rollout as long as version and robot are the same. A data
set that was cut off goes on with the motions that are not there yet. The index comes last.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from llsrbm.errors import Error, InputError, require
from llsrbm.files.atomic import staged
from llsrbm.formats.base import Options
from llsrbm.formats.datasets import DatasetFormat, Episode, find_dataset_format
from llsrbm.installed import package_version
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.robots.drives.stated import stated_drives
from llsrbm.robots.drives.variants import driven
from llsrbm.sweep import rows as row
from llsrbm.sweep.folder import TABLE, begin_folder, check_empty, difference, disk_errors, stated_of
from llsrbm.sweep.jump import plan_of, rollout_of
from llsrbm.sweep.points import REQUEST, Point
from llsrbm.sweep.spec import Spec

if TYPE_CHECKING:
    import pyarrow as pa

    from llsrbm.motion.trajectory import Trajectory

SOURCES = ("rollout", "plan")
SCHEMA = "llsrbm.dataset/1"
LICENCE = "BSD-3-Clause (llsrbm); the robot's description has a licence of its own"

_INDEX = "index"
_DIGITS = 8  # of a motion's number in its file's name: as many as a sweep may have rows
_REQUEST = ("id", *REQUEST, "drive_torque", "drive_speed")
_OF_PLANS = ("duration_s", "takeoff_s", "flight_s", "landing_s", "apex", "torque_share", "cost")
_OUTCOMES = (
    *("landed", "strict", "final_yaw_error", "final_position_error", "final_tilt"),
    *("foot_error", "peak_tilt", "peak_torque_ratio"),
)


@dataclass(frozen=True)
class Summary:
    """Motions of a data set, those computed now, its table, and rows that are strict no more."""

    motions: int
    computed: int
    left_out: tuple[int, ...]
    index: Path


class _Sweep(NamedTuple):
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
    progress: Callable[[int, int], None] = lambda *_: None,
) -> Summary:
    """Write the strict jumps of the sweep in a folder, which is done, to the data set in another.

    Args:
        format_name: of `llsrbm formats`, or "lerobot"; robot: of these alone.
        source: "rollout": the simulated motions, one a seed; "plan": the planned motions of jumps
            that were strict with every seed.
        limit: motions at most, the first of the sweep; fps: frames/s; None: as the format has it.
        progress: called with the number of motions that are there, and with their total.

    Raises:
        InputError: no sweep there, of another version or robot, nothing strict in it, an unknown
            name, or a folder of something else.
        Error: it cannot be written, or nothing is strict any more.
    """
    require("data sets need pyarrow", "sweep", "pyarrow")
    if limit is not None and limit < 1:
        raise InputError(f"limit: expected 1 or more motions, got {limit}")
    format_, options = _format(format_name, source, fps)
    opened = _open(sweep)
    chosen = _strict(opened, robot, source)[:limit]
    _check(opened, chosen, format_)
    _begin(out, opened, format_, {"source": source, "robot": robot, "limit": limit}, options)
    whole = format_.finished is not None and (out / format_.finished).is_file()
    computed, left_out = 0, []
    kept: list[tuple[dict[str, Any], Path]] = []
    for values in chosen:
        file = _file(out, format_, values, source)
        if not (whole or file.exists()):
            trajectory = _computed(values, opened.spec, source)
            if trajectory is None:
                left_out.append(values["index"])
                continue
            with disk_errors(out):
                file.parent.mkdir(parents=True, exist_ok=True)
            format_.write(trajectory, file, options)
            computed += 1
        kept.append((values, file))
        progress(len(kept), len(chosen) - len(left_out))
    if not kept:
        raise Error(f"{sweep}: none of {len(chosen)} strict rows is strict when computed again")
    if format_.finish is not None and not whole:
        with disk_errors(out):
            format_.finish(out, [Episode(file, _task(values)) for values, file in kept], options)
    index = _write_index(out, kept, format_, options, source)
    return Summary(len(kept), computed, tuple(left_out), index)


def _format(name: str, source: str, fps: float | None) -> tuple[DatasetFormat, Options]:
    if source not in SOURCES:
        raise InputError(f'source: expected {" or ".join(SOURCES)}, got "{source}"')
    format_ = find_dataset_format(name)
    if fps is None:
        return format_, format_.defaults
    if "fps" not in format_.options:
        raise InputError(f'fps: format "{format_.name}" has no rate; expected no --fps')
    from llsrbm.motion.sampling import check_rate

    check_rate(fps)
    options = replace(format_.defaults, fps=fps)
    if format_.check is not None:
        format_.check(options)
    return format_, options


def _open(path: Path) -> _Sweep:
    import pyarrow as pa
    import pyarrow.dataset

    stated = stated_of(path)
    try:
        spec = Spec.from_table(stated["spec"])
        plain = [
            *("index", "jump", *_REQUEST, "seed", "status", *_OF_PLANS, *_OUTCOMES),
            *("version", "robot_hash", *(row.LIMIT + name for name in spec.limits)),
        ]
        found = pyarrow.dataset.dataset(path / TABLE)
        # Sweeps from before robots had arms do not have the column.
        of_old = {"arms"} - {*found.schema.names}
        table = found.to_table(columns=[name for name in plain if name not in of_old])
        for name in of_old:
            table = table.append_column(name, pa.array([Jump.arms] * len(table)))
    except (ValueError, KeyError, TypeError, OSError, pa.ArrowException) as error:
        raise InputError(f"{path}: the sweep is damaged; expected one of llsrbm sweep") from error
    if len(table) < stated["rows"]:
        raise InputError(
            f"{path}: the sweep is not done: {len(table)} of {stated['rows']} rows; expected all: "
            "run llsrbm sweep again"
        )
    return _Sweep(path, spec, stated["digest"], stated["origin"], table)


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
    strict: list[dict[str, Any]] = table.filter(table["strict"]).to_pylist()
    if source == "plan":
        seeds, counted = sweep.spec.rows_a_jump(), Counter(each["jump"] for each in strict)
        whole = (each for each in strict if counted[each["jump"]] == seeds)
        strict = [each for each in whole if each["index"] == each["jump"] * seeds]
    if not strict:
        of = "" if robot is None else f" of {robot}"
        raise InputError(
            f"{sweep.path}: none of {len(table)} rows{of} is strict; expected a sweep in which "
            "some land by the strict measure"
        )
    return strict


def _check(sweep: _Sweep, chosen: Sequence[dict[str, Any]], format_: DatasetFormat) -> None:
    robots = list(dict.fromkeys(values["robot"] for values in chosen))
    if format_.one_robot and len(robots) > 1:
        raise InputError(
            f'format "{format_.name}" holds one robot, the sweep has {", ".join(robots)}; expected '
            "--robot with one of them"
        )
    now = row.origin(sweep.spec)
    other = difference(sweep.origin, {name: now[name] for name in ("llsrbm", *robots)})
    if other:
        raise InputError(
            f"{sweep.path}: the sweep is of {other}: its motions would be others; expected the "
            "same, or a new sweep"
        )


def _begin(
    out: Path, sweep: _Sweep, format_: DatasetFormat, choice: dict[str, Any], options: Options
) -> None:
    used = {name: value for name, value in asdict(options).items() if name in format_.options}
    stated = {
        "schema": SCHEMA,
        "format": format_.name,
        "options": used,
        **choice,
        "sweep": {"title": sweep.spec.title, "digest": sweep.digest, "origin": sweep.origin},
        "drives": _drives(sweep),
        "licence": LICENCE,
        "package_version": package_version(),
    }
    path, text = out / "dataset.json", json.dumps(stated, indent=2) + "\n"
    with disk_errors(out):
        begin_folder(out)
        if not path.is_file():
            check_empty(out, "data set")
            with staged(path) as target:
                target.write_text(text, encoding="utf-8")
        elif path.read_text(encoding="utf-8") != text:
            raise InputError(
                f"{out}: holds another data set; expected the same sweep and options, or another "
                "folder for --out"
            )


def _drives(sweep: _Sweep) -> dict[str, Any]:
    """Each robot's drives with which its motions were made: rotors, friction, damping, delay."""
    scenario = sweep.spec.scenario() or Scenario()
    return {
        name: stated_drives(driven(load_robot(name), scenario.drives)) for name in sweep.spec.robots
    }


def _file(out: Path, format_: DatasetFormat, values: dict[str, Any], source: str) -> Path:
    number = values["jump"] if source == "plan" else values["index"]
    robot = Path(values["robot"]).stem
    return out / format_.folder / f"{robot}-{number:0{_DIGITS}d}{format_.suffix}"


def _computed(values: dict[str, Any], spec: Spec, source: str) -> Trajectory | None:
    """The motion of a row; None: it is not strict when computed again."""
    point = Point(
        number=values["jump"],
        jump=Jump(**{name: values[name] for name in REQUEST}),
        limits={name: values[row.LIMIT + name] for name in spec.limits},
        drive_torque=values["drive_torque"],
        drive_speed=values["drive_speed"],
        seeds=(values["seed"],),
    )
    try:
        plan = plan_of(spec, point)
        if source == "plan":
            return plan
        rollout = rollout_of(spec, point, plan, values["seed"])
    except Error:
        return None
    return rollout if rollout.outcome.strict else None


def _task(values: dict[str, Any]) -> str:
    """The request in words, to whole degrees and centimetres."""
    parts = [f"twist {math.degrees(values['twist']):.0f} deg"]
    parts += [f"{name} {values[name] + 0.0:.2f} m" for name in ("forward", "lateral", "height")]
    parts += [
        f"{name} {math.degrees(values[name]):.0f} deg" for name in ("roll", "pitch") if values[name]
    ]
    parts += [f"{name} {values[name]:.1f} m/s" for name in ("speed", "end_speed") if values[name]]
    parts += [f"{name} {values[name]:.2f} m" for name in ("gap", "bar") if values[name]]
    parts += [f"{values['hops']} hops"] if values["hops"] > 1 else []
    parts += [] if values["arms"] == Jump.arms else [f"arms {values['arms']}"]
    kind = "" if values["type"] == Jump.type else f" ({values['type']})"
    return f"jump{kind}: {', '.join(parts)}"


def _write_index(
    out: Path,
    kept: Sequence[tuple[dict[str, Any], Path]],
    format_: DatasetFormat,
    options: Options,
    source: str,
) -> Path:
    import pyarrow as pa
    import pyarrow.parquet as pq
    from pyarrow import csv

    of_seeds = () if source == "plan" else ("index", "seed", *_OUTCOMES)
    own = [name for name in kept[0][0] if name.startswith(row.LIMIT)]
    names = ["jump", *of_seeds, *_REQUEST, *own, *_OF_PLANS]
    rate = options.fps if "fps" in format_.options else None
    rows = [
        {
            "episode": number,
            # Of a format that joins motions, the file is gone.
            "file": None if format_.finish else file.relative_to(out).as_posix(),
            "source": source,
            "format": format_.name,
            "fps": rate,
            "task": _task(values),
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
