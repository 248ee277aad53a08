"""Files that a tab opens and saves, beside all that it plans and simulates."""

from __future__ import annotations

from dataclasses import replace

from app.motion.foreign_motion import bake_foreign
from app.panel.export_controls import PLAN
from app.tab.comparison import Pin, free_colour
from app.tab.effects import Download, Notify, ResetControls, Submit
from app.tab.events import ExportWanted, FileChosen, Reported
from app.tab.known_motion import show_known
from app.tab.lanes import Lane
from app.tab.requests import plan_design, remember
from app.tab.state import Known, TabState
from app.tab.steps import Step, also, joined, with_files
from app.workers.opened_file import OpenedFile, States
from app.workers.protocol import (
    Cancelled,
    Exported,
    ExportMotion,
    Failed,
    Opened,
    OpenFile,
    Progress,
    Report,
)
from llsrbm.errors import Error
from llsrbm.formats import FORMATS
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.request.design import Design, dump_design, file_name

# ---- opening


def open_file(state: TabState, event: FileChosen) -> Step:
    """Have a file read."""
    fps = None
    if event.name.lower().endswith(".csv"):  # the others say their own
        fps = event.rate
        state = replace(state, csv_rate=True)
    ticket = state.tickets + 1
    task = OpenFile(event.name, event.content, state.design.jump.robot, fps)
    state = with_files(replace(state, tickets=ticket), opening=ticket, opening_note="")
    return state, (Submit(Lane.OPEN, ticket, task),)


def take_opening(state: TabState, event: Reported) -> Step:
    """Take a report on the reading of a file."""
    if event.ticket != state.files.opening:
        return state, ()
    report: Report = event.report
    if isinstance(report, Progress):
        return with_files(state, opening_note=report.text), ()
    state = with_files(state, opening=0, opening_note="")
    if isinstance(report, Opened):
        return show_file(state, report.file)
    if isinstance(report, Failed):
        return _refused(state, report.message)
    return state, ()


def show_file(state: TabState, file: OpenedFile) -> Step:
    """Show a file's content: a design is planned, a plan or a simulation of one shown as it is.

    Any other motion becomes a pin: it is for looking and comparing.
    """
    design = _design_in(state, file)
    if design is not None:
        try:
            dump_design(design)  # as it is kept and shared: a file's numbers may be too large
        except Error as error:
            return _refused(state, f"{file.name}: {error}")
    match file.holds, design:
        case Design(), Design():
            state = replace(state, note=design.note)
            return plan_design(remember(state, design, settled=True))
        case Plan() as plan, Design():
            return _show_motion(state, file, design, plan)
        case Rollout() as rollout, Design():
            return _show_motion(state, file, design, rollout.plan, rollout)
        case States() as states, _:
            return _pin(state, file, states.motion(), None)
    return state, ()


def _design_in(state: TabState, file: OpenedFile) -> Design | None:
    """The design that a file's motion came of, where the file says it."""
    match file.holds:
        case Design() as design:
            return design
        case Plan() as plan:
            return Design(plan.jump, plan.tuning, state.design.scenario)
        case Rollout() as rollout:
            return Design(rollout.jump, rollout.plan.tuning, rollout.scenario)
    return None


def _refused(state: TabState, message: str) -> Step:
    return replace(state, note=f"Not opened: {message}"), (Notify("Not opened", message),)


def _show_motion(
    state: TabState, file: OpenedFile, design: Design, plan: Plan, rollout: Rollout | None = None
) -> Step:
    note = " ".join((f"Opened {file.name}.", *file.remarks))
    known = Known(plan, rollout, f"from file {file.name}", note)
    return show_known(remember(state, design, settled=True), known)


def _pin(
    state: TabState, file: OpenedFile, motion: Rollout | WholeBodyMotion, design: Design | None
) -> Step:
    """Keep a motion beside the one that is shown."""
    colour = free_colour(state.pins)
    if colour is None:
        body = f"{file.name}: unpin something first; all colours are taken"
        return state, (Notify("Not opened", body),)
    pin = Pin(bake_foreign(file.name, motion), None, design, colour)
    rate = getattr(motion, "fps", None)
    at = "" if rate is None else f", at {rate:g} frames/s"
    note = f"{file.name} is pinned for looking and comparing{at}."
    state = replace(
        state,
        pins=(*state.pins, pin),
        pin_chosen=len(state.pins),
        note=" ".join((note, *file.remarks)),
    )
    return plan_design(state) if state.plan is None else (state, ())


# ---- saving


def save_design(state: TabState) -> Step:
    """Send the design as a file."""
    design = state.design
    return state, (Download(file_name(design), dump_design(design).encode()),)


def export(state: TabState, event: ExportWanted) -> Step:
    """Have what is chosen of the motion that is shown written."""
    choice = event.choice
    before = (
        (Notify("Corrected", "; ".join(event.complaints)), ResetControls())
        if event.complaints
        else ()
    )
    rollout = state.rollout
    motion = state.plan if rollout is None or choice.of == PLAN else rollout
    if motion is None:
        return joined(before, (state, (Notify("Nothing to export", "There is no plan yet."),)))
    for name in choice.formats:
        extra = FORMATS[name].extra
        if extra is not None and extra.missing:
            body = (
                f'format "{name}" needs packages that are not installed; expected pip install '
                f'"llsrbm[{extra.name}]"'
            )
            return joined(before, (state, (Notify("Not exported", body),)))
    saved, ticket = ", ".join(choice.formats), state.tickets + 1
    task = ExportMotion(motion, choice.formats, choice.zipped, choice.options)
    state = with_files(
        replace(state, tickets=ticket),
        saving=ticket,
        saved=saved,
        saving_note=f"Exporting {saved} ...",
    )
    return also((state, before), Submit(Lane.SAVE, ticket, task))


def take_saving(state: TabState, event: Reported) -> Step:
    """Take a report on the writing of a file."""
    files, report = state.files, event.report
    if event.ticket != files.saving:
        return state, ()
    if isinstance(report, Progress):
        waits = f" ({report.text})" if report.waiting else ""
        return with_files(state, saving_note=f"Exporting {files.saved}{waits} ..."), ()
    state = with_files(state, saving=0, saved="", saving_note="")
    match report:
        case Exported(name=name, content=content):
            return state, (Download(name, content),)
        case Failed(message=message):
            return state, (Notify("Not exported", message),)
        case Cancelled():
            return state, (Notify("Not exported", f"Stopped: {files.saved}"),)
    return state, ()
