"""Some jumps of a sweep, planned and simulated in this process: what a worker does.

A jump's rows depend on the spec alone: every plan starts from the analytic guess, never from
another plan, and solvers take their compiled functions before the first jump, never in between.
Failures are rows.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from llsrbm.cache import content_key
from llsrbm.errors import Error, InputError, NotConverged
from llsrbm.sweep import rows as row
from llsrbm.sweep.figures import figures, short, solved, stopped
from llsrbm.sweep.points import Point, Points
from llsrbm.sweep.spec import Spec
from llsrbm.version import package_version

if TYPE_CHECKING:
    from llsrbm.motion.plan import Plan
    from llsrbm.motion.rollout import Rollout
    from llsrbm.planning.solve.planner import Planner
    from llsrbm.robots.robot import Robot

_HASH_DIGITS = 16


@dataclass
class Shard:
    """What a worker hands back.

    Attributes:
        jumps: numbers of the jumps that were computed, in order.
        table: their rows, as Arrow's file format.
        trajectories: group -> quantity -> array, see `llsrbm.sweep.trajectories`; empty if not
            asked for.
        origin: what the rows depend on beside the spec, see `origin`.
        seconds: in all; planning: of them from request to plan; simulating: likewise.
    """

    jumps: list[int]
    table: bytes
    trajectories: dict[str, dict[str, Any]] = field(default_factory=dict)
    origin: dict[str, str] = field(default_factory=dict)
    seconds: float = 0.0
    planning: float = 0.0
    simulating: float = 0.0


def run_shard(spec: str, jumps: Sequence[int]) -> Shard:
    """Plan, and simulate, some jumps of a sweep.

    Args:
        spec: as `Spec.as_json` wrote it; jumps: numbers of its `Points`.
    """
    from threadpoolctl import threadpool_limits

    start = time.perf_counter()
    points = _points(spec)
    found, plans = [], []
    with threadpool_limits(limits=1):  # a process a core: more threads would only wait
        for number in jumps:
            point = points[number]
            made, plan = _rows_of(point, points.spec)
            found += made
            if plan is not None and points.spec.trajectories:
                plans.append((point, plan))
    shard = Shard(list(jumps), packed(found, points.spec))
    if plans:
        from llsrbm.sweep.trajectories import arrays_of

        shard.trajectories = arrays_of(plans)
    shard.simulating = sum(values.get("simulation_time_s") or 0.0 for values in found)
    # Once a jump, not once a row.
    shard.planning = sum({v["jump"]: v["plan_time_s"] for v in found}.values())
    shard.origin = origin(points.spec)
    shard.seconds = time.perf_counter() - start
    return shard


def packed(found: list[dict[str, Any]], spec: Spec) -> bytes:
    """Rows as Arrow's file format, to be sent and kept."""
    import pyarrow as pa

    table = row.table_of(found, tuple(spec.limits))
    sink = pa.BufferOutputStream()
    with pa.ipc.new_file(sink, table.schema) as writer:
        writer.write_table(table)
    return bytes(sink.getvalue())


def lost_shard(spec: Spec, point: Point, message: str) -> Shard:
    """The rows of a jump whose worker died of it again and again."""
    found = [
        {**asked(point, index, seed), "status": row.FAILED, "message": message}
        for index, seed in zip(point.rows, point.seeds, strict=True)
    ]
    return Shard([point.number], packed(found, spec), origin=origin(spec))


def prepare(spec: str) -> dict[str, str]:
    """Build what a sweep's jumps need, so that this machine's cache has it.

    Returns:
        Robot -> hash of its files; "llsrbm" -> the version, to be compared.
    """
    points = _points(spec)
    for point in points.kinds():
        try:
            _planner(point)
        except Error:
            continue  # a request that cannot be: its row says so
    return origin(points.spec)


def origin(spec: Spec) -> dict[str, str]:
    """What rows depend on beside the spec: robot -> hash of its files, "llsrbm" -> version."""
    return {"llsrbm": package_version(), **{robot: robot_hash(robot) for robot in spec.robots}}


def robot_hash(name_or_path: str) -> str:
    """Of a robot's file and its URDF.

    Raises:
        InputError: no such robot.
        RobotFileError: its file is wrong.
    """
    from llsrbm.robots import load_robot

    robot = load_robot(name_or_path)
    return _hash(robot.path, robot.urdf_path)


@lru_cache(maxsize=32)
def _hash(*paths: Path) -> str:
    return content_key(*paths).hex()[:_HASH_DIGITS]


@lru_cache(maxsize=4)
def _points(spec: str) -> Points:
    return Points(Spec.from_json(spec))


def _robot(point: Point) -> Robot:
    """With the drives that are asked for; of jumps that turn over, as those are."""
    from llsrbm.robots import load_robot
    from llsrbm.robots.drives import with_drives

    robot = load_robot(point.jump.robot)
    if point.jump.turns:
        robot = robot.turning
    return with_drives(robot, point.drive_torque, point.drive_speed)


def _planner(point: Point) -> Planner:
    from llsrbm.planning.solve.planner import planner_of

    planner = planner_of(point.jump, robot=_robot(point))
    planner.formulation.solver.settle()
    return planner


def _rows_of(point: Point, spec: Spec) -> tuple[list[dict[str, Any]], Plan | None]:
    """A jump's rows, and its plan if there is one."""
    start = time.perf_counter()
    planned, plan = _planned(point, spec)
    planned["plan_time_s"] = time.perf_counter() - start
    made = []
    for index, seed in zip(point.rows, point.seeds, strict=True):
        values = {**asked(point, index, seed), **planned}
        if plan is not None and spec.simulated:
            values |= _simulated(point, plan, spec, seed)
        made.append(values)
    return made, plan


def asked(point: Point, index: int, seed: int | None) -> dict[str, Any]:
    """What the row is about."""
    return {
        "index": index,
        "jump": point.number,
        "id": point.id,
        **asdict(point.jump),
        "drive_torque": point.drive_torque,
        "drive_speed": point.drive_speed,
        "seed": seed,
        "version": package_version(),
        "robot_hash": robot_hash(point.jump.robot),
        **{row.LIMIT + name: value for name, value in point.limits.items()},
    }


def _planned(point: Point, spec: Spec) -> tuple[dict[str, Any], Plan | None]:
    """What planning came to, and the plan if it is one."""
    try:
        plan = plan_of(point, spec)
    except NotConverged as error:
        return {**stopped(error, spec.diagnose), **solved(error.plan)}, None
    except InputError as error:
        return {"status": row.REFUSED, "message": short(error)}, None
    except Exception as error:  # noqa: BLE001  # a sweep goes on, and the row says why
        return {"status": row.FAILED, "message": short(error)}, None
    return {"status": row.PLANNED, **solved(plan), **figures(plan, _robot(point))}, plan


def plan_of(point: Point, spec: Spec) -> Plan:
    """A jump's plan, the same wherever and whenever it is asked for.

    Raises:
        Error: see `Planner.plan`.
    """
    return _planner(point).plan(
        point.jump, limits=point.limits, patient=spec.patient, explains=spec.diagnose
    )


def rollout_of(point: Point, plan: Plan, spec: Spec, seed: int | None) -> Rollout:
    """What the whole robot does with a plan, likewise.

    Raises:
        InputError: see `llsrbm.simulate`, or the spec simulates nothing.
    """
    from llsrbm.simulation.simulate import simulate

    scenario = spec.scenario()
    if scenario is None:
        raise InputError("a sweep of plans has no simulations; expected a spec with [simulate]")
    if seed is not None:
        scenario = scenario.but(seed=seed)
    return simulate(plan, _robot(point), scenario)


def _simulated(point: Point, plan: Plan, spec: Spec, seed: int | None) -> dict[str, Any]:
    """How the whole robot did with a plan."""
    start = time.perf_counter()
    try:
        outcome = asdict(rollout_of(point, plan, spec, seed).outcome)
    except InputError as error:
        return {"status": row.REFUSED, "message": short(error)}
    except Exception as error:  # noqa: BLE001  # a sweep goes on, and the row says why
        return {"status": row.FAILED, "message": short(error)}
    known = {column.name for column in row.COLUMNS}
    return {
        **{name: value for name, value in outcome.items() if name in known and name != "status"},
        "landed": outcome["status"] == "landed",
        "fall": outcome["reason"] or None,
        "simulation_time_s": time.perf_counter() - start,
    }
