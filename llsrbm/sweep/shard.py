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

import numpy as np

from llsrbm.cache import content_key
from llsrbm.errors import Error, InputError, NotConverged
from llsrbm.sweep import rows as row
from llsrbm.sweep.points import Point, Points
from llsrbm.sweep.spec import Spec
from llsrbm.version import package_version

if TYPE_CHECKING:
    from llsrbm.motion.plan import Plan
    from llsrbm.motion.rollout import Rollout
    from llsrbm.planning.planner import Planner
    from llsrbm.robots.robot import Robot

_HASH_DIGITS = 16
# Share of the robot's weight below which a contact's force says nothing of friction.
_LOADED = 0.02
_LONGEST_MESSAGE = 500  # characters of a row's message


@dataclass
class Shard:
    """What a worker hands back.

    Attributes:
        jumps: numbers of the jumps that were worked off, in order.
        table: their rows, as Arrow's file format.
        trajectories: group -> quantity -> array, see `llsrbm.sweep.trajectories`; empty if not
            asked for.
        statuses: robot -> status -> rows.
        strict: robot -> simulated rows that landed by the strict measure.
        origin: what the rows depend on beside the spec, see `origin`.
        seconds: in all; planning: of them from request to plan; simulating: likewise.
    """

    jumps: list[int]
    table: bytes
    trajectories: dict[str, dict[str, Any]] = field(default_factory=dict)
    statuses: dict[str, dict[str, int]] = field(default_factory=dict)
    strict: dict[str, int] = field(default_factory=dict)
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
    _count(shard, found)
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
        {**_asked(point, index, seed), "status": row.FAILED, "message": message}
        for index, seed in zip(point.rows, point.seeds, strict=True)
    ]
    shard = Shard([point.number], packed(found, spec), origin=origin(spec))
    _count(shard, found)
    return shard


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
    from llsrbm.planning.planner import planner_of

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
        values = {**_asked(point, index, seed), **planned}
        if plan is not None and spec.simulated:
            values |= _simulated(point, plan, spec, seed)
        made.append(values)
    return made, plan


def _asked(point: Point, index: int, seed: int | None) -> dict[str, Any]:
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
        return {**_stopped(error, spec.diagnose), **_solved(error.plan)}, None
    except InputError as error:
        return {"status": row.REFUSED, "message": _short(error)}, None
    except Exception as error:  # noqa: BLE001  # a sweep goes on, and the row says why
        return {"status": row.FAILED, "message": _short(error)}, None
    return {"status": row.PLANNED, **_solved(plan), **_figures(plan, _robot(point))}, plan


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


def _solved(plan: Plan) -> dict[str, Any]:
    report = plan.report
    amounts = [violation.amount for violation in plan.violations.values()]
    return {
        "iterations": report.iterations,
        "attempts": report.attempts,
        "cost": report.cost,
        "solve_time_s": report.solve_time_s,
        "violation": max(amounts, default=None),
    }


def _stopped(error: NotConverged, diagnosed: bool) -> dict[str, Any]:
    """What stops a jump: diagnosed, the limit; else the constraint that is violated most."""
    from llsrbm.planning.residuals import severity

    violations = error.plan.violations
    worst = max(violations, key=lambda name: severity(violations[name]), default=None)
    values: dict[str, Any] = {
        "status": row.NOT_PLANNED,
        "stopped_by": worst,
        "constraint": worst,
        "message": _short(error),
        "violations": {name: violation.amount for name, violation in violations.items()},
    }
    if diagnosed and error.stops and error.stops[0].limit is not None:
        stop = error.stops[0]
        values |= {
            "stopped_by": stop.limit,
            "stop_limit": stop.limit,
            "stop_value": stop.value,
            "stop_needed": stop.needed,
        }
    return values


def _figures(plan: Plan, robot: Robot) -> dict[str, Any]:
    """Durations, margins and loads of a plan."""
    from llsrbm.analysis.peak_loads import planned_peak_load, planned_torque_shares
    from llsrbm.analysis.summary import peak_yaw_rate
    from llsrbm.motion.rotation import final_yaw

    durations = np.diff(plan.phase_start)
    load = planned_peak_load(plan)
    flights = sum(durations[flight] for flight in plan.schedule.flights)
    values: dict[str, Any] = {
        "duration_s": plan.duration,
        "takeoff_s": plan.lift_off,
        "flight_s": float(flights),
        "landing_s": plan.duration - plan.touchdown,
        "lift_off_s": plan.lift_off,
        "touchdown_s": plan.touchdown,
        "phase_durations_s": durations.tolist(),
        "final_yaw": final_yaw(plan.time, plan.base_quat, plan.angular_velocity[:, 2]),
        "peak_yaw_rate": peak_yaw_rate(plan),
        "apex": float(plan.com[:, 2].max() - plan.com[0, 2]),
        "joint_torque_ratio": planned_torque_shares(plan),
    }
    if load is not None:
        values |= {
            "torque_share": load.ratio,
            "torque_joint": load.joint,
            "torque_phase": load.phase,
        }
    return values | _joints(plan, robot) | _forces(plan, robot)


def _joints(plan: Plan, robot: Robot) -> dict[str, Any]:
    """Largest speed and smallest margin at knots; between them would take a tenth of a plan."""
    q, model = plan.joint_position, robot.model
    room = np.minimum(q - model.lowerPositionLimit[7:], model.upperPositionLimit[7:] - q)
    tightest = int(room.min(axis=0).argmin())
    values: dict[str, Any] = {
        "joint_margin": float(room[:, tightest].min()),
        "margin_joint": plan.joint_names[tightest],
    }
    if plan.joint_velocity is not None:
        with np.errstate(divide="ignore", invalid="ignore"):  # joints without a speed limit
            shares = np.abs(plan.joint_velocity).max(axis=0) / robot.speed_limit
        fastest = int(shares.argmax())
        values |= {"speed_share": float(shares[fastest]), "speed_joint": plan.joint_names[fastest]}
    return values


def _forces(plan: Plan, robot: Robot) -> dict[str, Any]:
    """Forces at contacts, and how much of the friction they use."""
    from llsrbm.planning.stage import GRAVITY

    force = plan.contact_force
    tangential = np.hypot(force[..., 0], force[..., 1])
    loaded = force[..., 2] > _LOADED * robot.mass * GRAVITY
    used = float((tangential[loaded] / force[..., 2][loaded]).max()) if loaded.any() else 0.0
    friction = plan.tuning.limits.get("friction", robot.file.limits.friction)
    return {
        "friction_share": used,
        "friction_margin": friction - used,
        "peak_force": float(np.linalg.norm(force, axis=-1).max()),
    }


def _simulated(point: Point, plan: Plan, spec: Spec, seed: int | None) -> dict[str, Any]:
    """How the whole robot did with a plan."""
    start = time.perf_counter()
    try:
        outcome = asdict(rollout_of(point, plan, spec, seed).outcome)
    except InputError as error:
        return {"status": row.REFUSED, "message": _short(error)}
    except Exception as error:  # noqa: BLE001  # a sweep goes on, and the row says why
        return {"status": row.FAILED, "message": _short(error)}
    known = {column.name for column in row.COLUMNS}
    return {
        **{name: value for name, value in outcome.items() if name in known and name != "status"},
        "landed": outcome["status"] == "landed",
        "fall": outcome["reason"] or None,
        "simulation_time_s": time.perf_counter() - start,
    }


def _count(shard: Shard, found: list[dict[str, Any]]) -> None:
    for values in found:
        robot = values["robot"]
        of_robot = shard.statuses.setdefault(robot, {})
        of_robot[values["status"]] = of_robot.get(values["status"], 0) + 1
        shard.strict[robot] = shard.strict.get(robot, 0) + bool(values.get("strict"))
        shard.simulating += values.get("simulation_time_s") or 0.0
    # Once a jump, not once a row.
    shard.planning += sum({v["jump"]: v.get("plan_time_s") or 0.0 for v in found}.values())


def _short(error: BaseException) -> str:
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= _LONGEST_MESSAGE else f"{text[:_LONGEST_MESSAGE]}..."
