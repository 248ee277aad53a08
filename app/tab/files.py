"""Files that a tab opens and saves, beside all that it plans and simulates."""

from dataclasses import dataclass, replace

from app import gallery
from app.link import ExportChosen, FiguresWanted, MotionChosen
from app.motion.baked import bake_foreign
from app.panel.acts import Act
from app.panel.file_controls import PLAN, FileChoice
from app.tab.acts import Step, joined, on, reads, submit_beside
from app.tab.effects import Download, Notify, Play, Queue, Reported, SendFigures, ShowExports, Stop
from app.tab.foreign import Foreign
from app.tab.planning.requests import plan_design, remember
from app.tab.repairing import check_foreign
from app.tab.showing import show_given
from app.tab.shown import Given
from app.tab.state import Pin, TabState, free_colour
from app.workers import reports, tasks
from app.workers.opened_file import OpenedFile, States
from llsrbm.errors import Error
from llsrbm.formats import FORMATS, availability, by_purpose
from llsrbm.formats import file_name as export_name
from llsrbm.look.titles import title
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.request.design import Design, dump_design, file_name
from llsrbm.robots import load_robot

# ---- opening


@dataclass(frozen=True, eq=False)
class FileChosen:
    """A file was opened, whatever it is: its name as the browser has it, and its content."""

    name: str
    content: bytes


@on(FileChosen)
def open_file(state: TabState, event: FileChosen) -> Step:
    """Have a file read."""
    fps = None
    if event.name.lower().endswith(".csv"):  # the others say their own
        fps = state.export.rate
        state = replace(state, export=replace(state.export, rate_needed=True))
    task = tasks.OpenFile(event.name, event.content, state.design.jump.robot, fps)
    state, effects = submit_beside(state, Queue.OPEN, task)
    return state.with_files(opening=state.tickets, opening_note=""), effects


@on(MotionChosen)
def open_motion(state: TabState, event: MotionChosen) -> Step:
    """Have a motion of the library opened."""
    if event.name not in gallery.motion_names():
        return state, ()
    state, effects = submit_beside(state, Queue.OPEN, tasks.OpenMotion(event.name))
    return state.with_files(opening=state.tickets, opening_note=""), effects


@on(FiguresWanted)
def send_figures(state: TabState, event: FiguresWanted) -> Step:
    """Have the page draw the motions that are in view."""
    return state, (SendFigures(event.names),)


@on(tasks.OpenFile, tasks.OpenMotion)
def take_opening(state: TabState, event: Reported) -> Step:
    """A file is being read, or has been."""
    if event.ticket != state.files.opening:
        return state, ()
    match event.report:
        case reports.Progress(text=text):
            return state.with_files(opening_note=text), ()
        case reports.Opened(file=file):
            return show_file(state.with_files(opening=0, opening_note=""), file)
        case reports.Failed(message=message):
            return _refused(state.with_files(opening=0, opening_note=""), message)
    return state.with_files(opening=0, opening_note=""), ()


def show_file(state: TabState, file: OpenedFile) -> Step:
    """Show a file's content: a design is planned, a plan or a simulation of one shown as it is.

    Any other motion becomes a pin, for looking and comparing; it is checked, and may be repaired.
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
            return _pin(state, file, states.motion())
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
    return state, (Notify("Not opened", message),)


def _show_motion(
    state: TabState, file: OpenedFile, design: Design, plan: Plan, rollout: Rollout | None = None
) -> Step:
    note = " ".join((f"Opened {file.name}.", *file.remarks))
    given = Given(plan, rollout, f"from file {file.name}", note)
    return show_given(remember(state, design, settled=True), given)


def _pin(state: TabState, file: OpenedFile, motion: WholeBodyMotion) -> Step:
    colour = free_colour(state.pins)
    if colour is None:
        body = f"{file.name}: unpin something first; all colours are taken"
        return state, (Notify("Not opened", body),)
    baked = bake_foreign(file.name, motion)
    at = "" if motion.fps is None else f", at {motion.fps:g} frames/s"
    note = f"{file.name} is pinned for looking and comparing{at}."
    state = replace(
        state,
        pins=(*state.pins, Pin(baked, None, None, colour)),
        pin_chosen=len(state.pins),
        beside=True,
        note=" ".join((note, *file.remarks)),
    )
    state, effects = check_foreign(state, Foreign(baked, colour))
    if state.plan is None:
        return joined(effects, plan_design(state))
    return state, (*effects, Play())


# ---- saving


reads(Act.FILES, lambda state, panel: panel.files.fields.read(state.file_choice, state.file_choice))


@on(FileChoice)
def choose_formats(state: TabState, choice: FileChoice) -> TabState:
    """Export otherwise; other formats come with options of their own."""
    if choice.formats != state.export.formats:
        choice = choice.with_own()
    return replace(state, export=choice)


@on(Act.SAVE)
def save_design(state: TabState) -> Step:
    """Send the design as a file."""
    design = state.design
    return state, (Download(file_name(design), dump_design(design).encode()),)


def _busy(state: TabState) -> bool:
    return bool(state.files.saving_note or state.files.opening_note)


def _has_motion(state: TabState) -> bool:
    return state.shown is not None and not _busy(state)


def _can_be_exported(state: TabState) -> bool:
    choice = state.file_choice
    return _has_motion(state) and not any(map(choice.hindrance, choice.formats))


def _exported(state: TabState) -> Plan | Rollout | None:
    """The motion that an export writes."""
    return state.plan if state.rollout is None or state.export.of == PLAN else state.rollout


@on(Act.CHOOSE_EXPORT, enabled=_has_motion)
def show_exports(state: TabState) -> Step:
    """Show the formats by what they are for."""
    motion, choice = _exported(state), state.file_choice
    if motion is None:
        return state, ()
    groups = {
        purpose.value: [
            {
                "name": each.name,
                "what": each.title,
                "file": export_name(motion, [each.name]),
                "hindrance": choice.hindrance(each.name),
            }
            for each in formats
        ]
        for purpose, formats in by_purpose().items()
    }
    kind = "plan" if isinstance(motion, Plan) else "simulation"
    return state, (ShowExports(f"the {kind} of {title(motion)}", groups),)


@on(ExportChosen)
def export_as(state: TabState, event: ExportChosen) -> Step:
    """Have the motion written in one format, as if it were chosen in the menu."""
    if event.format not in FORMATS or not _has_motion(state):
        return state, ()
    choice = replace(state.export, format=event.format, also=())
    return export(choose_formats(state, choice))


@on(Act.EXPORT, enabled=_can_be_exported)
def export(state: TabState) -> Step:
    """Have the motion that is shown written in the chosen formats."""
    choice, motion = state.export, _exported(state)
    if motion is None:
        return state, (Notify("Nothing to export", "There is no plan yet."),)
    for name in choice.formats:
        if reason := availability(FORMATS[name], load_robot(motion.jump.robot)):
            return state, (Notify("Not exported", f'Format "{name}": {reason}.'),)
    saved = ", ".join(choice.formats)
    if state.check is not None and state.check.motion is motion and state.check.certificate:
        motion = replace(motion, certificate=state.check.certificate.as_dict())
    task = tasks.ExportMotion(motion, choice.formats, bool(choice.also), choice.options)
    state, effects = submit_beside(state, Queue.SAVE, task)
    note = f"Exporting {saved} ..."
    return state.with_files(saving=state.tickets, saved=saved, saving_note=note), effects


@on(tasks.ExportMotion)
def take_saving(state: TabState, event: Reported) -> Step:
    """A file is being written, or has been."""
    files, report = state.files, event.report
    if event.ticket != files.saving:
        return state, ()
    if isinstance(report, reports.Progress):
        waits = f" ({report.text})" if report.waiting else ""
        return state.with_files(saving_note=f"Exporting {files.saved}{waits} ..."), ()
    state = state.with_files(saving=0, saved="", saving_note="")
    match report:
        case reports.Exported(name=name, content=content):
            return state, (Download(name, content),)
        case reports.Failed(message=message):
            return state, (Notify("Not exported", message),)
        case reports.Cancelled():
            return state, (Notify("Not exported", f"Stopped: {files.saved}"),)
    return state, ()


@on(Act.STOP_FILES, visible=_busy)
def stop_files(state: TabState) -> Step:
    """Give up the file that is being read or written."""
    return state, (Stop(Queue.OPEN), Stop(Queue.SAVE))
