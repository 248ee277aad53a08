"""`llsrbm robot-sim`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from llsrbm.commands import console, options
from llsrbm.errors import Error, InputError, require
from llsrbm.signals import stop_on_signal

if TYPE_CHECKING:
    from llsrbm.motion.surroundings import Surroundings
    from llsrbm.robots import Robot
    from llsrbm.simulation.contacts import Touch
    from llsrbm.wire.dds import DdsRobot
    from llsrbm.wire.real_time import Punctuality
    from llsrbm.wire.simulated_robot import Conditions, SimulatedRobot, TrueTick


_OWN_CONTROLLER = "normal"  # of a Go2


_DelayMs = Annotated[
    float, typer.Option(metavar="MS", help="Delay from a command until motors follow it.")
]
_DelaySpreadMs = Annotated[
    float, typer.Option(metavar="MS", help="Delay jitter, drawn for each command.")
]
_Lost = Annotated[
    float,
    typer.Option(metavar="SHARE", help="Share of messages that are lost, in both directions."),
]
_Late = Annotated[float, typer.Option(metavar="SHARE", help="Share of messages that come late.")]
_LateMs = Annotated[float, typer.Option(metavar="MS", help="Extra delay of late messages.")]
_Held = Annotated[
    bool,
    typer.Option(
        "--held/--free",
        help="A controller of its own writes commands until its motion switcher releases it.",
    ),
]
_Hung = Annotated[bool, typer.Option("--hung", help="The robot hangs, its feet over the ground.")]
_Battery = Annotated[bool, typer.Option("--battery/--no-battery", help="Voltage falls with power.")]


def robot_sim_command(
    robot: options.Robot,
    interface: options.Interface = "lo",
    domain: options.Domain = None,
    plan: Annotated[
        Path | None,
        typer.Option(metavar="PLAN.npz", help="Stand among the boxes of this plan's jump."),
    ] = None,
    delay_ms: _DelayMs = 2.0,
    delay_spread_ms: _DelaySpreadMs = 1.0,
    lost: _Lost = 0.0,
    late: _Late = 0.0,
    late_ms: _LateMs = 20.0,
    held: _Held = True,
    hung: _Hung = False,
    battery: _Battery = True,
    seed: Annotated[int, typer.Option(help="Draws delays, losses and the sensors' errors.")] = 0,
    duration: Annotated[
        float | None, typer.Option(metavar="S", help="Simulated time [default: until Ctrl-C].")
    ] = None,
    fifo: Annotated[
        bool, typer.Option("--fifo", help="Run before all else; the system must allow it.")
    ] = False,
    as_json: options.AsJson = False,
) -> int:
    """A robot in MuJoCo behind the topics of the real one, in real time, without a window.

    It stands until the first command arrives, keeps each until the next, and brakes after 50 ms
    without one. Motors apply tau + kp (q_d - q) + kd (dq_d - dq) within their limits; sensors err.
    The exit status is 1 if the simulation diverges.
    """
    require("a robot's wire needs Cyclone DDS", "wire", "cyclonedds")
    if duration is not None and not duration > 0:
        raise InputError(f"duration: expected more than 0 s, got {duration:g}")
    with console.result_stream(as_json=as_json) as stdout:
        from llsrbm.wire.channel import Faults
        from llsrbm.wire.simulated_robot import Conditions

        faults = Faults(lost, late, late_ms / 1000)
        conditions = Conditions(delay_ms / 1000, delay_spread_ms / 1000, faults, battery)
        if fifo:
            from llsrbm.wire.real_time import go_first

            go_first()  # threads that are begun from here on do, too
        wire = interface, domain, _OWN_CONTROLLER if held else ""
        simulated, end = _begun(robot, wire, plan, conditions, seed, hung=hung)
        if not as_json:
            does = "hangs" if hung else "stands"
            print(f"{simulated.robot.file.title} {does}, {end.place}.", flush=True)
        result = _run(simulated, end, duration)
        console.print_result(result, _in_words(result), stdout, as_json=as_json)
    return console.DONE


def _begun(
    name: str,
    wire: tuple[str, int | None, str],
    plan: Path | None,
    conditions: Conditions,
    seed: int,
    *,
    hung: bool,
) -> tuple[SimulatedRobot, DdsRobot]:
    """`wire`: interface, domain, and the robot's own controller that commands it at first."""
    from llsrbm.robots import load_robot
    from llsrbm.wire.dds import DdsRobot
    from llsrbm.wire.motor_map import MotorMap
    from llsrbm.wire.simulated_robot import SimulatedRobot

    robot = load_robot(name)
    end = DdsRobot(robot, *wire)
    simulated = SimulatedRobot(
        robot,
        conditions,
        seed,
        surroundings=_surroundings(plan, robot),
        hung=hung,
        foot_force=MotorMap.of(robot).family == "unitree_go",
    )
    return simulated, end


def _run(simulated: SimulatedRobot, end: DdsRobot, duration: float | None) -> dict[str, Any]:
    """Run until the time is over or a signal comes. Raises `Error`: the simulation diverged."""
    from llsrbm.simulation.world import Diverged
    from llsrbm.wire.real_time import run

    touches: dict[Touch, float] = {}

    def note(tick: TrueTick) -> None:
        for touch, time in tick.result.touches:
            touches.setdefault(touch, time)

    simulated.observers.append(note)
    with stop_on_signal() as stop:
        try:
            kept = run(simulated, end, math.inf if duration is None else duration, stop.is_set)
        except Diverged as error:
            raise Error(str(error)) from error
        finally:
            end.close()
    return _result(simulated, kept, end.refused, touches)


def _surroundings(file: Path | None, robot: Robot) -> Surroundings:
    """Boxes of a plan's jump; flat ground without one."""
    from llsrbm.motion.surroundings import surroundings
    from llsrbm.simulation.world import FLAT

    if file is None:
        return FLAT
    from llsrbm.request.scenario import Scenario

    plan = options.read_plan(file)
    if set(plan.joint_names) != set(robot.joint_names):
        raise InputError(f"{file}: expected a plan of {robot.file.title}, got {plan.jump.robot}'s")
    around = surroundings(robot, plan, Scenario())
    if around.in_mid_flight:
        raise InputError(
            f"{file}: {around.in_mid_flight} expected a jump whose boxes stand from the start"
        )
    return around


def _result(
    robot: SimulatedRobot, kept: Punctuality, refused: int, touches: dict[Touch, float]
) -> dict[str, Any]:
    import numpy as np

    computing = np.array(kept.computing or [0.0])
    return {
        "time_s": round(robot.time, 3),
        "ticks": kept.ticks,
        "late_ticks": kept.late,
        "worst_late_s": round(kept.worst, 6),
        "slipped_s": round(kept.slipped, 6),
        "tick_p50_s": round(float(np.median(computing)), 6),
        "tick_p99_s": round(float(np.percentile(computing, 99)), 6),
        "commands": robot.heard,
        "wrong_checksums": refused,
        "braking": robot.braking,
        "touched": "; ".join(
            f"{touch.link} touched {touch.other} at {time:.2f} s" for touch, time in touches.items()
        ),
    }


def _in_words(result: dict[str, Any]) -> dict[str, str]:
    late = f"{result['late_ticks']} of {result['ticks']} ticks began late"
    if result["late_ticks"]:
        late += f", at worst by {1e3 * result['worst_late_s']:.1f} ms"
    if result["slipped_s"]:
        late += f"; the robot's clock slipped by {result['slipped_s']:.2f} s"
    wrong = result["wrong_checksums"]
    return {
        "time": f"{result['time_s']:.2f} s, {late}",
        "tick": f"{1e3 * result['tick_p50_s']:.2f} ms (p99 {1e3 * result['tick_p99_s']:.2f} ms)",
        "commands": f"{result['commands']}, {wrong} with a wrong checksum"
        + (", then silence: it brakes" if result["braking"] else ""),
        "touched": result["touched"] or "nothing but feet touched anything",
    }
