"""`llsrbm repair`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from llsrbm.commands import console, options

if TYPE_CHECKING:
    from llsrbm.certificate import Certificate
    from llsrbm.repairing.result import Repair


def repair_command(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="A native file, or another tool's (`llsrbm formats`)."),
    ],
    robot: options.Mover = "anymal",
    fps: options.Fps = None,
    jump: Annotated[
        int, typer.Option(metavar="N", help="Which of several jumps that are apart.")
    ] = 1,
    out: options.Out = None,
    as_json: options.AsJson = False,
) -> int:
    """Find the motion nearest to one of any tool's whose certificate holds.

    Its jump is found by how the feet move, and stays near: postures, durations and where the feet
    stand. The exit status is 1 where there is no such motion; one line says why.
    """
    with console.result_stream(as_json=as_json) as stdout:
        import llsrbm
        from llsrbm.formats import load_any, remarks_of

        motion = load_any(file, robot, fps)
        remarks = remarks_of(motion)
        console.print_remarks(remarks)
        found = llsrbm.repair(motion, jump=jump, progress=console.show_planning)
        if out is not None and found.plan is not None:
            llsrbm.with_feedback(found.plan).save(out)
        summary: dict[str, Any] = {"file": str(file), "remarks": list(remarks), **found.as_dict()}
        lines = {} if as_json else _description(found)
        console.print_result(summary, lines, stdout, as_json=as_json)
        if found.status == "failed":
            console.print_error(f"{file}: {found.why}")
    return console.FAILED if found.status == "failed" else console.DONE


def _description(found: Repair) -> dict[str, str]:
    rows = {"Result": found.status}
    for phase in found.phases:
        feet = ", ".join(phase.feet) or "no foot"
        when = f"{phase.start_s:.2f} to {phase.end_s:.2f} s"
        name = phase.name if phase.name not in rows else f"{phase.name}, {when}"
        rows[name] = f"{when}: {feet}"
    rows["Before"] = _broken(found.before)
    if found.after is not None:
        rows["After"] = _broken(found.after)
    if found.plan is not None:
        rows["Plan"] = options.in_words(found.plan.jump)
    if found.moved is not None:
        by = found.moved
        rows["Moved"] = (
            f"joints {by.joint_rms_rad:.3f} rad (rms), base {100 * by.base_rms_m:.1f} cm (rms), "
            f"landing {100 * by.landing_m:.1f} cm"
        )
    for beside in found.rest:
        rows[f"Beside, {beside.start_s:.2f} to {beside.end_s:.2f} s"] = _broken(beside.certificate)
    if found.why and found.status != "failed":
        rows["Remark"] = found.why
    return rows


def _broken(certificate: Certificate) -> str:
    """The checks that do not hold, by how much and when; or that all that is known does."""
    if not certificate.broken:
        return "holds" if certificate.holds else "holds as far as it is known"
    return "; ".join(
        f"{each.name} {each.shown(each.worst)} at {each.where} ({each.when})"
        if each.worst is not None
        else each.name
        for each in certificate.broken
    )
