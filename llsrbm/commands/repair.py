"""`llsrbm repair`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from llsrbm.commands import console, options
from llsrbm.errors import InputError

if TYPE_CHECKING:
    from llsrbm.repairing.result import ClipRepair, Repair


def repair_command(
    context: typer.Context,
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="A native file, or another tool's (`llsrbm formats`)."),
    ],
    robot: options.Mover = "anymal",
    fps: options.Fps = None,
    jump: Annotated[
        int, typer.Option(metavar="N", help="Which of several jumps that are apart.")
    ] = 1,
    phases: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Contact phases in place of those found, JSON."),
    ] = None,
    out: options.Out = None,
    clip: Annotated[
        Path | None,
        typer.Option(metavar="OUT", help="Repair all jumps, and write the whole clip here."),
    ] = None,
    format_: Annotated[
        str,
        typer.Option(
            "--format", metavar="F", help="The clip's format: one of motions for learning."
        ),
    ] = "motion-npz",
    as_json: options.AsJson = False,
) -> int:
    """Find the motion nearest to one of any tool's whose certificate holds.

    Its jump is found by how the feet move, and stays near: postures, durations and where the feet
    stand. With --clip all of its jumps are repaired and joined with what is beside them. The exit
    status is 1 where a jump could not be repaired; one line says why.
    """
    _check_words(context, clip is not None)
    with console.result_stream(as_json=as_json) as stdout:
        import llsrbm
        from llsrbm.formats import check_motion_format, load_any, remarks_of

        if clip is not None:
            check_motion_format(format_)
        motion = load_any(file, robot, fps)
        remarks = remarks_of(motion)
        console.print_remarks(remarks)
        found: Repair | ClipRepair
        if clip is None:
            found = llsrbm.repair(motion, jump=jump, phases=phases, progress=console.show_planning)
            if out is not None and found.plan is not None:
                llsrbm.with_feedback(found.plan).save(out)
            rows = _description(found)
        else:
            found = llsrbm.repair_clip(motion, phases=phases, progress=console.show_planning)
            if found.motion is not None:
                llsrbm.export(found.motion, clip, format=format_)
            rows = _clip_description(found)
        summary: dict[str, Any] = {"file": str(file), "remarks": list(remarks), **found.as_dict()}
        console.print_result(summary, {} if as_json else rows, stdout, as_json=as_json)
        if found.status == "failed":
            console.print_error(f"{file}: {found.why}")
    return console.FAILED if found.status == "failed" else console.DONE


def _check_words(context: typer.Context, of_clip: bool) -> None:
    """Raise `InputError` where options of one jump and of a whole clip are given together."""
    beside = [name for name in ("jump", "out") if options.is_given(context, name)]
    if of_clip and beside:
        raise InputError(
            f"--clip and --{beside[0]}: expected one of them; a clip has all its jumps"
        )
    if not of_clip and options.is_given(context, "format_"):
        raise InputError("--format: is that of a whole clip; expected --clip OUT with it")


def _clip_description(found: ClipRepair) -> dict[str, str]:
    from llsrbm.repairing.wording import broken_checks, moved_in_words

    rows = {"Result": found.status, "Before": broken_checks(found.before)}
    if found.after is not None:
        rows["After"] = broken_checks(found.after)
    for number, jump in enumerate(found.jumps, start=1):
        start, end = jump.phases[0].start_s, jump.phases[-1].end_s
        by = "" if jump.moved is None else f", {moved_in_words(jump.moved)}"
        rows[f"Jump {number}"] = f"{start:.2f} to {end:.2f} s: {jump.status}{by}"
    if found.motion is not None:
        rows["Clip"] = f"{found.motion.time[-1]:.2f} s"
    if found.joins:
        feet = max(join.feet_m for join in found.joins)
        rows["Joins"] = (
            f"{len(found.joins)}, in which standing feet move {1000 * feet:.1f} mm at most"
        )
    if found.why and found.status != "failed":
        rows["Remark"] = found.why
    return rows


def _description(found: Repair) -> dict[str, str]:
    from llsrbm.repairing.wording import broken_checks, moved_in_words

    rows = {"Result": found.status}
    for phase in found.phases:
        feet = ", ".join(phase.feet) or "no foot"
        when = f"{phase.start_s:.2f} to {phase.end_s:.2f} s"
        name = phase.name if phase.name not in rows else f"{phase.name}, {when}"
        rows[name] = f"{when}: {feet}"
    rows["Before"] = broken_checks(found.before)
    if found.after is not None:
        rows["After"] = broken_checks(found.after)
    if found.plan is not None:
        rows["Plan"] = options.in_words(found.plan.jump)
    if found.moved is not None:
        rows["Moved"] = moved_in_words(found.moved)
    if found.why and found.status != "failed":
        rows["Remark"] = found.why
    return rows
