"""The rows of one jump, planned and simulated in a process beside its Dask worker.

They depend on spec and point alone: every plan starts from the analytic guess, never from another
plan, and solvers take their compiled functions before the first jump, never in between. Failures
are rows: a solve that hangs, or code that crashes, ends the process instead of the worker, and no
other jump is lost with it.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING, Any

import numpy as np
from threadpoolctl import threadpool_limits

from llsrbm.errors import Error, InputError, NotConverged
from llsrbm.installed import package_version
from llsrbm.sweep import rows
from llsrbm.sweep.points import Point, request_in
from llsrbm.sweep.rows import FAILED, TIMED_OUT, TableRow
from llsrbm.sweep.spec import Spec

if TYPE_CHECKING:
    from llsrbm.motion.plan import Plan
    from llsrbm.motion.rollout import Rollout
    from llsrbm.planning.answer.planner import Planner
    from llsrbm.robots.robot import Robot


# Share of the robot's weight below which a contact's force is no measure of friction.
_LOADED = 0.02
_LONGEST_MESSAGE = 500  # characters of a row's message
_OUTCOMES = {column.name for column in rows.COLUMNS} - {"status"}


def rows_of(spec: Spec, point: Point) -> list[TableRow]:
    """Plan a jump and simulate it once a seed: one row a seed. Raises `InputError`: the robot's
    file is not on this machine.
    """
    request = request_of(point)
    start = time.perf_counter()
    planned, plan = _planned(spec, point)
    planned["plan_time_s"] = time.perf_counter() - start
    found = []
    for place, seed in zip(point.rows, point.seeds, strict=True):
        row = {**request, "index": place, "seed": seed, **planned}
        if plan is not None and spec.simulated:
            row |= _simulated(spec, point, plan, seed)
        found.append(row)
    if plan is not None and spec.trajectories:
        found[0] |= rows.motion_of(plan)
    return found


def failed_rows(point: Point, status: str, message: str) -> list[TableRow]:
    """The rows of a jump that could not be computed."""
    row = {**request_of(point), "status": status, "message": message}
    pairs = zip(point.rows, point.seeds, strict=True)
    return [{**row, "index": place, "seed": seed} for place, seed in pairs]


def prepare(spec: Spec, points: Sequence[Point]) -> None:
    """Build the solvers of these jumps, so that this machine's cache has them."""
    for point in points:
        try:
            _planner(point)
            if not spec.draft:  # the whole body's are built for a plan
                plan_of(spec, point)
        except Error:
            continue  # a contradictory request: its row has the error


def request_of(point: Point) -> TableRow:
    """Request, version and robot of a point's rows."""
    return {
        "jump": point.number,
        "id": point.id,
        **request_in(point.jump),
        "drive_torque": point.drive_torque,
        "drive_speed": point.drive_speed,
        "version": package_version(),
        "robot_hash": rows.robot_hash(point.jump.robot),
        **{rows.LIMIT + name: value for name, value in point.limits.items()},
    }


def plan_of(spec: Spec, point: Point) -> Plan:
    """A jump's plan, the same wherever and whenever it is computed. Raises `Error`: see
    `Planner.plan`.

    The whole body's with its certificate, unless drafts are asked for or none is found: begun from
    the robot's table, where it leads there, else from a draft.
    """
    from llsrbm.certified_nearest import all_or_less
    from llsrbm.certified_plan import CertifiedPlanner
    from llsrbm.planning.problem.placement import make_task

    robot = _robot(point)
    planner = CertifiedPlanner(robot, settles=True)
    if not spec.draft:
        task = make_task(point.jump, robot, limits=point.limits)
        found = all_or_less(planner, task, less=False)
        if found is not None:
            return found.plan
    draft = _planner(point).plan(
        point.jump, limits=point.limits, patient=spec.patient, explains=spec.diagnose
    )
    return draft if spec.draft else replace(planner, guesses=False).plan(draft)


def rollout_of(spec: Spec, point: Point, plan: Plan, seed: int | None) -> Rollout:
    """The simulation of a plan, likewise. Raises `InputError`: see `llsrbm.simulate`, or the spec
    simulates nothing.
    """
    from llsrbm.simulation.simulate import simulate

    scenario = spec.scenario()
    if scenario is None:
        raise InputError("a sweep of plans has no simulations; expected a spec with [simulate]")
    return simulate(plan, _robot(point), scenario if seed is None else scenario.but(seed=seed))


def _robot(point: Point) -> Robot:
    """With the point's drives, and those of a robot that turns over if the jump does."""
    from llsrbm.robots import load_robot
    from llsrbm.robots.drives.variants import with_drives, with_strength

    robot = load_robot(point.jump.robot)
    robot = robot.turning if point.jump.turns else robot
    robot = with_drives(robot, point.drive_torque, point.drive_speed)
    strength, battery = (point.limits.get(name, 1.0) for name in ("drive_strength", "battery"))
    return with_strength(robot, strength, battery)


def _planner(point: Point) -> Planner:
    from llsrbm.planning.answer.planner import planner_of

    planner = planner_of(point.jump, robot=_robot(point), limits=point.limits)
    planner.formulation.solver.settle()
    return planner


def _planned(spec: Spec, point: Point) -> tuple[TableRow, Plan | None]:
    try:
        plan = plan_of(spec, point)
        row = {"status": rows.PLANNED, **_solve(plan), **_figures(plan, _robot(point))}
        if not spec.draft:
            row |= _certificate(plan)
        return row, plan if row["status"] == rows.PLANNED else None
    except NotConverged as error:
        return {**_stop(error, spec.diagnose), **_solve(error.plan)}, None
    except Exception as error:  # noqa: BLE001  # a sweep goes on, and the row has the error
        return _failure(error), None


def _certificate(plan: Plan) -> TableRow:
    """Whether its certificate holds; why not, if it does not or if there is none."""
    from llsrbm.analysis.drafts import draft_reason
    from llsrbm.certificate import stated

    certificate = stated(plan)
    broken = () if certificate is None else certificate.broken
    row: TableRow = {"certified": plan.certified, "uncertified": [found.name for found in broken]}
    if plan.certified:
        return row
    return {**row, "status": rows.NOT_CERTIFIED, "message": draft_reason(plan)}


def _simulated(spec: Spec, point: Point, plan: Plan, seed: int | None) -> TableRow:
    start = time.perf_counter()
    try:
        outcome = asdict(rollout_of(spec, point, plan, seed).outcome)
    except Exception as error:  # noqa: BLE001  # likewise
        return _failure(error)
    return {
        **{name: value for name, value in outcome.items() if name in _OUTCOMES},
        "landed": outcome["status"] == "landed",
        "fall": outcome["reason"] or None,
        "simulation_time_s": time.perf_counter() - start,
    }


def _failure(error: Exception) -> TableRow:
    status = rows.REFUSED if isinstance(error, InputError) else rows.FAILED
    return {"status": status, "message": _one_line(error)}


def _one_line(error: Exception) -> str:
    text = " ".join(str(error).split()) or type(error).__name__
    return text if len(text) <= _LONGEST_MESSAGE else f"{text[:_LONGEST_MESSAGE]}..."


def _solve(plan: Plan) -> TableRow:
    """Effort and result of a solve, whether it converged or not."""
    return {
        "iterations": plan.effort.iterations,
        "attempts": plan.report.attempts,
        "cost": plan.cost,
        "solve_time_s": plan.effort.solve_time_s,
        "violation": max((each.amount for each in plan.violations.values()), default=None),
    }


def _stop(error: NotConverged, diagnosed: bool) -> TableRow:
    """The limit that stops a jump if it was diagnosed, else the constraint violated most."""
    from llsrbm.planning.problem.violations import worst_of

    violations = error.plan.violations
    worst = worst_of(violations)
    row: TableRow = {
        "status": rows.NOT_PLANNED,
        "stopped_by": worst,
        "constraint": worst,
        "message": _one_line(error),
        "violations": {name: violation.amount for name, violation in violations.items()},
    }
    if diagnosed and error.stops and error.stops[0].limit is not None:
        stop = error.stops[0]
        row |= {"stopped_by": stop.limit, "stop_limit": stop.limit}
        row |= {"stop_value": stop.value, "stop_needed": stop.needed if stop.amount else None}
    return row


def _figures(plan: Plan, robot: Robot) -> TableRow:
    from llsrbm.analysis.summaries import peak_yaw_rate, planned_peak_load, planned_torque_shares
    from llsrbm.mechanics import final_yaw

    durations = np.diff(plan.phase_start)
    row: TableRow = {
        "duration_s": plan.duration,
        "takeoff_s": plan.lift_off,
        "flight_s": plan.airborne,
        "landing_s": plan.duration - plan.touchdown,
        "lift_off_s": plan.lift_off,
        "touchdown_s": plan.touchdown,
        "phase_durations_s": durations.tolist(),
        "final_yaw": final_yaw(plan.time, plan.base_quat, plan.angular_velocity[:, 2]),
        "peak_yaw_rate": peak_yaw_rate(plan),
        "apex": float(plan.com[:, 2].max() - plan.com[0, 2]),
        "joint_torque_ratio": planned_torque_shares(plan),
    }
    load = planned_peak_load(plan)
    if load is not None:
        row |= {"torque_share": load.ratio, "torque_joint": load.joint, "torque_phase": load.phase}
    return row | _joints(plan, robot) | _forces(plan, robot)


def _joints(plan: Plan, robot: Robot) -> TableRow:
    """Largest speed and smallest margin at knots; between them would take a tenth of a plan."""
    q, (lower, upper) = plan.joint_position, robot.joint_stops
    room = np.minimum(q - lower, upper - q)
    tightest = int(room.min(axis=0).argmin())
    row: TableRow = {
        "joint_margin": float(room[:, tightest].min()),
        "margin_joint": plan.joint_names[tightest],
    }
    if plan.joint_velocity is not None:
        with np.errstate(divide="ignore", invalid="ignore"):  # joints without a speed limit
            shares = np.abs(plan.joint_velocity).max(axis=0) / robot.speed_limit
        fastest = int(shares.argmax())
        row |= {"speed_share": float(shares[fastest]), "speed_joint": plan.joint_names[fastest]}
    return row


def _forces(plan: Plan, robot: Robot) -> TableRow:
    from llsrbm.mechanics import GRAVITY

    force = plan.contact_force
    tangential = np.hypot(force[..., 0], force[..., 1])
    loaded = force[..., 2] > _LOADED * robot.mass * GRAVITY
    used = float((tangential[loaded] / force[..., 2][loaded]).max()) if loaded.any() else 0.0
    return {
        "friction_share": used,
        "friction_margin": plan.friction - used,
        "peak_force": float(np.linalg.norm(force, axis=-1).max()),
    }


# ---- the process beside a worker

_ATTEMPTS = 3  # processes that may die of a jump: a machine short of memory kills one by chance

_lock = threading.Lock()  # CasADi is not safe to use from two threads
_running: _Process | None = None


class ProcessDied(Exception):
    """The process ended before it had an answer."""


class _Process:
    def __init__(self) -> None:
        # Dask's nanny starts workers as daemons, which may have no children. This one ends when
        # its connection to the worker does.
        multiprocessing.current_process().daemon = False
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
        self._process.start()
        theirs.close()

    def call(self, function: Callable[..., Any], arguments: Any, limit: float | None) -> Any:
        try:
            self._connection.send((function, arguments))
            if not self._connection.poll(limit):
                raise TimeoutError
            return self._connection.recv()
        except (EOFError, ConnectionError) as error:
            self._process.join(1.0)
            raise ProcessDied(f"exit status {self._process.exitcode}") from error

    def end(self) -> None:
        self._process.kill()
        self._process.join()
        self._connection.close()


def run_jump(spec: Spec, point: Point, limit: float) -> list[TableRow]:
    """A jump's rows, computed within `limit` seconds or failed; called by Dask in a worker. Raises
    `Error`: this machine lacks the robot's file, or something else that all jumps need.
    """
    died = ""
    for _ in range(_ATTEMPTS):
        try:
            found: list[TableRow] = compute(rows_of, spec, point, limit=limit)
        except TimeoutError:
            return failed_rows(point, TIMED_OUT, f"no result within {limit:g} s")
        except ProcessDied as error:
            died = f"{_ATTEMPTS} processes died while they computed it ({error})"
        else:
            return found
    return failed_rows(point, FAILED, died)


def run_prepare(spec: Spec, points: Sequence[Point]) -> None:
    """Fill this machine's cache; called by Dask in a worker."""
    compute(prepare, spec, points, limit=None)


def compute(function: Callable[..., Any], *arguments: Any, limit: float | None) -> Any:
    """A function's result, computed in the worker's process within `limit` seconds.

    Raises `TimeoutError`: it takes longer; `ProcessDied`: the process ended; `Error`: the function
    raised something.
    """
    global _running  # one a worker
    with _lock:
        _running = _running or _Process()
        try:
            result = _running.call(function, arguments, limit)
        except (TimeoutError, ProcessDied):
            _running.end()
            _running = None
            raise
    if isinstance(result, Error):
        raise result
    return result


def _serve(connection: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # of the terminal: the command ends its workers
    # A process a core: more threads would only wait, those of libraries that are loaded later too.
    os.environ["OMP_NUM_THREADS"] = "1"
    with threadpool_limits(limits=1):
        while True:
            try:
                function, arguments = connection.recv()
                connection.send(_answer(function, arguments))
            except (EOFError, ConnectionError):
                return


def _answer(function: Callable[..., Any], arguments: Any) -> Any:
    try:
        return function(*arguments)
    except Exception as error:  # noqa: BLE001  # as text: not every exception can be sent
        return Error(f"{type(error).__name__}: {error}")
