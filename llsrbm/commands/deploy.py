"""`llsrbm deploy`."""

from __future__ import annotations

import contextlib
import gc
import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from llsrbm.commands import console, options
from llsrbm.commands.streams import OutputLost
from llsrbm.errors import Error, InputError, require
from llsrbm.signals import stop_on_signal

if TYPE_CHECKING:
    from llsrbm.player import Ended, Player, Tier
    from llsrbm.player.states import State
    from llsrbm.robots import Robot

_SHOWN = 3  # first commands of a dry run


class _Ready(NamedTuple):
    """A play: its name, its robot, what makes its tier anew, and what refuses it."""

    name: str
    robot: Robot
    make: Callable[[], Tier]
    check: Callable[[], object]


class _Wire(NamedTuple):
    """Where the robot is, and whether its own controller was ended by hand."""

    interface: str
    domain: int | None
    released: bool


_Released = Annotated[
    bool,
    typer.Option(
        "--released",
        help="The robot's own controller was ended by hand; no motion switcher has to answer.",
    ),
]
_Log = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE", help="Log of the play, MCAP [default: PLAN-<date>-<time>.mcap, here]."
    ),
]


def deploy_command(
    file: Annotated[
        Path | None,
        typer.Argument(metavar="PLAN.npz", help="A plan that converged; none with --excite."),
    ] = None,
    robot: Annotated[
        str | None,
        typer.Option(
            metavar="R", help="Name or file of the robot on the wire [default: the plan's]."
        ),
    ] = None,
    interface: options.Interface = "lo",
    domain: options.Domain = None,
    tier: Annotated[
        str, typer.Option(help="closed-loop (controller and estimator) or table (gains alone).")
    ] = "closed-loop",
    released: _Released = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Print states and first commands; send nothing.")
    ] = False,
    log: _Log = None,
    excite: Annotated[
        bool,
        typer.Option("--excite", help="No plan: move every joint, for `llsrbm identify`."),
    ] = False,
    hung: Annotated[
        bool, typer.Option("--hung", help="The robot hangs, and nothing is within its legs' reach.")
    ] = False,
    seconds: Annotated[float, typer.Option(metavar="S", help="Duration of the excitation.")] = 60.0,
    as_json: options.AsJson = False,
) -> int:
    """Play a plan on a robot over its own wire: check, ramp, stand, jump, damp.

    Nobody here has run this on a robot; `llsrbm robot-sim` is one to try it on. A plan whose
    certificate does not hold is refused. Ctrl-C damps the robot; so does whatever goes wrong: tilt,
    tracking error, an unresponsive drive, a lost link, late readings, missed deadlines. The robot's
    own controller is released first, by the maker's motion switcher; a robot that another program
    commands is left alone. The exit status is 1 if the plan was not played to its end.

    With --excite a hung robot moves all joints in small sums of sines about its default posture.
    """
    with console.result_stream(as_json=as_json) as stdout:
        ready = _excitation(file, robot, seconds, hung=hung) if excite else _plan(file, robot, tier)
        if dry_run:
            ready.check()
            result, text = _dry_run(ready)
            print(json.dumps(result, allow_nan=False) if as_json else text, file=stdout)
            return console.DONE
        ended, result = _logged(ready, _Wire(interface, domain, released), log, quiet=as_json)
        console.print_result(result, _in_words(result, ended), stdout, as_json=as_json)
        if ended.reason:
            console.print_error(ended.line)
            return console.FAILED
    return console.DONE


def _plan(file: Path | None, robot: str | None, tier: str) -> _Ready:
    """Plays a plan. Raises `InputError`: there is none, or no such tier."""
    from llsrbm.motion.robot import robot_of
    from llsrbm.player.requirements import check_plan
    from llsrbm.player.tiers import tier_called

    if file is None:
        raise InputError("deploy: no plan; expected PLAN.npz, or --excite with --robot and --hung")
    plan = options.read_plan(file)
    loaded, chosen = robot_of(plan, robot), tier_called(tier)
    return _Ready(
        file.stem,
        loaded,
        lambda: chosen(plan, loaded),
        lambda: check_plan(plan, loaded, chosen),
    )


def _excitation(file: Path | None, robot: str | None, seconds: float, *, hung: bool) -> _Ready:
    """Plays an excitation. Raises `InputError`: it is not said that the robot hangs, or which."""
    from llsrbm.identification.excitation import Excitation
    from llsrbm.robots import load_robot

    if file is not None or robot is None:
        raise InputError("--excite: plays no plan; expected --robot R and no PLAN.npz")
    if not hung:
        raise InputError(
            "--excite: moves every joint; expected --hung, which says that the robot hangs and "
            "nothing is within its legs' reach"
        )
    loaded = load_robot(robot)
    made = Excitation(loaded, seconds)
    return _Ready(f"excite-{loaded.name}", loaded, lambda: made, lambda: None)


def _log_file(log: Path | None, name: str) -> Path:
    """Where the log goes; `InputError`, before anything moves: there it cannot."""
    if log is None:
        log = Path(f"{name}-{time.strftime('%Y%m%d-%H%M%S')}.mcap")
    if log.suffix != ".mcap" or not log.parent.is_dir():
        raise InputError(f"--log {log}: expected a name that ends in .mcap, in a folder that is")
    return log


def _logged(
    ready: _Ready, wire: _Wire, log: Path | None, *, quiet: bool
) -> tuple[Ended, dict[str, Any]]:
    """Check, play and write the log: how it ended, and what came of it."""
    require("a robot's wire needs Cyclone DDS", "wire", "cyclonedds")
    require("the log of a play needs Foxglove's SDK", "mcap", "foxglove")
    path = _log_file(log, ready.name)
    ready.check()
    ended, player, tier = _play(ready, wire, quiet=quiet)
    result = _result(ended, player, tier, path)
    _write_log(player, path, result)
    return ended, result


def _play(ready: _Ready, wire: _Wire, *, quiet: bool) -> tuple[Ended, Player, str]:
    from threadpoolctl import threadpool_limits

    from llsrbm.player.player import Player
    from llsrbm.player.rehearsal import rehearse
    from llsrbm.wire.dds import DdsLink

    def announce(state: State) -> None:
        # A jump under way does not end because nobody reads any more.
        with contextlib.suppress(OutputLost):
            if not quiet:
                print(f"{state.name:<10}{state.summary}", flush=True)

    with threadpool_limits(1):  # one program a tick is too small to share
        rehearse(ready.make())
        link = DdsLink(ready.robot, wire.interface, wire.domain)
        try:
            done = link.take_over(released=wire.released)
        except Error:
            link.close()
            raise
        if not quiet:
            print(f"{'release':<10}{done}", flush=True)
        tier = ready.make()
        player = Player(tier, link, time.monotonic, announce)
        with stop_on_signal(player.stop):
            gc.collect()
            gc.disable()  # a collection takes several periods
            try:
                return player.run(), player, tier.name
            finally:
                gc.enable()
                link.close()


def _result(ended: Ended, player: Player, tier: str, log: Path) -> dict[str, Any]:
    import numpy as np

    from llsrbm.player.play_log import STATES

    computing = np.zeros(1)
    if len(player.log):
        columns = player.log.arrays()
        commanded = np.isin(columns["state"], [STATES.index("stand"), STATES.index("jump")])
        computing = columns["computing"][commanded] if commanded.any() else computing
    return {
        "played": not ended.reason,
        "reason": ended.reason,
        "stopped_in": ended.state if ended.reason else None,
        "tier": tier,
        "ticks": len(player.log),
        "computing_p50_s": round(float(np.median(computing)), 6),
        "computing_p99_s": round(float(np.percentile(computing, 99)), 6),
        "log": str(log),
    }


def _write_log(player: Player, path: Path, about: dict[str, Any]) -> None:
    from llsrbm.files.atomic import staged
    from llsrbm.player.mcap import write

    if len(player.log):
        with staged(path) as draft:
            write(player.log, draft, about)


def _in_words(result: dict[str, Any], ended: Ended) -> dict[str, str]:
    lines = {
        "computing": f"{1e3 * result['computing_p50_s']:.2f} ms from a reading to its command (p99 "
        f"{1e3 * result['computing_p99_s']:.2f} ms), {result['ticks']} ticks",
        "log": result["log"],
    }
    return lines if ended.reason else {**lines, "ended": ended.line}


def _dry_run(ready: _Ready) -> tuple[dict[str, Any], str]:
    """States and first commands, as data and as text."""
    from llsrbm.player.rehearsal import first_commands
    from llsrbm.player.states import outline

    robot, made = ready.robot, ready.make()
    states = outline(made, robot.posture[7:])
    commands = first_commands(made, _SHOWN)
    lines = [f"{state:<8}{duration:5.2f} s  {words}" for state, duration, words in states]
    lines += ["", f"First commands of the jump, tier {made.name}; of each joint q rad, dq rad/s, "]
    lines[-1] += "tau Nm, kp, kd:"
    for at, command in commands:
        lines.append(f"{1e3 * at:.0f} ms")
        for k, joint in enumerate(robot.joint_names):
            numbers = (command.q[k], command.dq[k], command.tau[k], command.kp[k], command.kd[k])
            lines.append(f"  {joint:<24}" + "".join(f"{number:10.3f}" for number in numbers))
    lines += ["", "Nothing was sent."]
    return {
        "tier": made.name,
        "states": [{"name": name, "duration_s": duration} for name, duration, _ in states],
        "joints": list(robot.joint_names),
        "commands": [
            {"time_s": at, **{name: values.tolist() for name, values in vars(command).items()}}
            for at, command in commands
        ],
    }, "\n".join(lines)
