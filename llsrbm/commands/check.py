"""`llsrbm check`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from llsrbm.commands import console, options

if TYPE_CHECKING:
    from llsrbm.certificate import Certificate, Finding
    from llsrbm.robots import Robot


def check_command(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="A native file, or another tool's (`llsrbm formats`)."),
    ],
    robot: options.Mover = "anymal",
    fps: options.Fps = None,
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw where each limit breaks (png, svg, pdf)."),
    ] = None,
    as_json: options.AsJson = False,
) -> int:
    """Print the certificate of a plan, a simulation or another tool's motion.

    Checked at 1 kHz on the robot's plain URDF, without the planner or its models: stops, speeds and
    torques of the joints, power, friction, contact forces, standing feet, distances, dynamics.
    The exit status is 1 if a check does not hold. Checks for which a file has too little are
    unknown.
    """
    with console.result_stream(as_json=as_json) as stdout:
        from llsrbm.certificate import certify
        from llsrbm.certificate.picture import write_picture
        from llsrbm.files.picture import check_picture
        from llsrbm.formats import load_any, remarks_of
        from llsrbm.motion.robot import robot_of
        from llsrbm.motion.whole_body import WholeBodyMotion
        from llsrbm.robots.drives.stated import known_drives

        if plot is not None:
            check_picture(plot)
        motion = load_any(file, robot, fps)
        remarks = remarks_of(motion)
        console.print_remarks(remarks)
        certificate = certify(motion)
        if plot is not None:
            write_picture(certificate, plot, file.name)
        mover = motion.robot if isinstance(motion, WholeBodyMotion) else robot_of(motion)
        result: dict[str, Any] = {
            "file": str(file),
            "remarks": list(remarks),
            "holds": certificate.holds,
            "certificate": certificate.as_dict(),
            "power": certificate.power.as_dict(),
            "drives": known_drives(mover.file),
        }
        if as_json:
            print(json.dumps(result, allow_nan=False), file=stdout)
        else:
            print(
                "\n".join([*certificate_table(certificate), *_power(certificate, mover)]),
                file=stdout,
            )
    return console.FAILED if certificate.holds is False else console.DONE


def certificate_table(certificate: Certificate) -> list[str]:
    """A head, a line a check and the result."""
    from llsrbm.number_text import aligned

    rows = [("check", "", "worst", "allowed", "limit", "where", "time"), *map(_row, certificate)]
    broken = ", ".join(found.name for found in certificate.broken)
    words = {True: "holds", False: f"does not hold: {broken}", None: "holds as far as it is known"}
    return [*aligned(rows), f"The certificate {words[certificate.holds]}."]


def _power(certificate: Certificate, robot: Robot) -> list[str]:
    """A line each: powers that are known, a power cut, how the drives are known."""
    from llsrbm.analysis.wording import power_cut, power_rows
    from llsrbm.robots.drives.stated import known_in_words

    lines = [f"{title}: {words}." for title, words in power_rows(certificate.power)]
    cut = power_cut(certificate)
    return [
        *lines,
        *([cut] if cut else []),
        f"Drives of {robot.name}: {known_in_words(robot.file)}.",
    ]


_WORDS = {True: "holds", False: "BROKEN", None: "unknown"}


def _row(found: Finding) -> tuple[str, ...]:
    head = found.name, _WORDS[found.holds]
    if found.worst is None or found.allowed is None:
        return (*head, "-", "-", "-", found.why, "")
    shown = [found.shown(value) for value in (found.worst, found.allowed)]
    limit = f"{found.limit:.4g} {found.unit}".strip()
    return (*head, *shown, limit, found.where, found.when)
