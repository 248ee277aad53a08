"""`llsrbm identify`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from llsrbm.commands import console, options

if TYPE_CHECKING:
    from llsrbm.identification import Identified
    from llsrbm.robots import Robot


def identify_command(
    log: Annotated[
        Path, typer.Argument(metavar="LOG", help="A robot in the air: .csv, or a play's .mcap.")
    ],
    robot: options.Robot,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Write [drives] for a robot file here (toml, a new one)."
        ),
    ] = None,
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw measured and modelled torques (png, svg, pdf)."),
    ] = None,
    as_json: options.AsJson = False,
) -> int:
    """Tell rotors, friction, damping and delay of the drives from a log of joints in the air.

    `llsrbm deploy --excite` makes such a log. A CSV log has the columns time, and q:NAME, dq:NAME,
    tau:NAME (rad, rad/s, Nm as commanded) of each joint, a row a command.
    """
    with console.result_stream(as_json=as_json) as stdout:
        from llsrbm.files.picture import check_picture
        from llsrbm.identification import identify, read_log
        from llsrbm.identification.drives_file import check_place, write_drives
        from llsrbm.identification.picture import write_picture
        from llsrbm.robots import load_robot

        loaded = load_robot(robot)
        if out is not None:
            check_place(out)
        if plot is not None:
            check_picture(plot)
        found = identify(loaded, read_log(log, loaded))
        if out is not None:
            write_drives(found, out)
        if plot is not None:
            write_picture(found, plot)
        console.print_result(
            _result(found, loaded), _in_words(found, loaded), stdout, as_json=as_json
        )
    return console.DONE


def _result(found: Identified, robot: Robot) -> dict[str, Any]:
    return {
        "log": found.log.name,
        "robot": robot.name,
        "base": "held" if found.log.gyro is None else "inertial unit",
        "delay_s": found.delay,
        "delay_s_error": found.delay_error,
        "speed_lag_s": found.speed_lag,
        "joints": {name: vars(drive) for name, drive in found.joints.items()},
        "undetermined": found.undetermined,
        "zeros": dict(zip(robot.joint_names, found.zeros.tolist(), strict=True)),
        "zero_errors": dict(zip(robot.joint_names, found.zero_errors.tolist(), strict=True)),
    }


def _in_words(found: Identified, robot: Robot) -> dict[str, str]:
    held = "taken as held and level, as the log has no inertial unit"
    lines = {
        "base": held if found.log.gyro is None else "by its inertial unit",
        "delay": f"{1e3 * found.delay:.2f} +- {1e3 * found.delay_error:.2f} ms",
        "": f"{'armature':>20}  {'friction':>20}  {'damping':>20}  {'zero':>18}   residual",
    }
    zeros = dict(zip(robot.joint_names, zip(found.zeros, found.zero_errors), strict=True))
    for name, drive in found.joints.items():
        slides = name in robot.sliding_joints
        numbers = (
            (drive.armature, drive.armature_error),
            (drive.friction, drive.friction_error),
            (drive.damping, drive.damping_error),
        )
        shown = "  ".join(f"{value:>9.4g} +- {error:<7.2g}" for value, error in numbers)
        zero, error = (1e3 * each for each in zeros[name])
        off = f"{zero:>7.2f} +- {error:<4.2g} {'mm' if slides else 'mrad'}"
        unit = "N" if slides else "Nm"
        lines[name] = f"{shown}  {off}   {drive.residual:.2g} {unit}"
    return {**lines, **{name: f"not told: {why}" for name, why in found.undetermined.items()}}
