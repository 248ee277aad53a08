"""Another tool's motion: checked, repaired, beside what it was; as values."""

from dataclasses import replace

import numpy as np
import pytest

from app.link import ComparisonClosed, PageReady, RepairAsked
from app.motion.colours import PINNED
from app.panel.acts import Act
from app.panel.status import Verdict
from app.tab.acts import is_visible
from app.tab.effects import Play, Queue, Seek, Stop, Submit
from app.tab.files import FileChosen
from app.tab.foreign import card
from app.tab.plotting import titles
from app.tab.repairing import offer
from app.tab.start.opening import left, resume
from app.workers.opened_file import OpenedFile
from app.workers.reports import Cancelled, Checked, Failed, Opened, Progress, Repaired
from app.workers.tasks import CheckForeign, CheckMotion, RepairMotion, SimulateJump
from tests.app.planners import CERTIFICATE, NO_FLIGHT, repair_of, turning_states
from tests.app.pure_tab import planned_tab

STATES = turning_states("anymal")
BROKEN = "joint speed 116.4 % at FL_calf_joint (0.74 s)"


@pytest.fixture
def tab():
    """With the file opened, of which the certificate is on its way."""
    tab = planned_tab()
    tab.take(FileChosen("turn.csv", b"content"))
    tab.report(Opened(0, OpenedFile("turn.csv", STATES)))
    return tab


@pytest.fixture
def checked(tab):
    tab.report(Checked(0, CERTIFICATE))
    return tab


@pytest.fixture
def repaired(checked):
    checked.take(RepairAsked())
    checked.report(Repaired(0, repair_of(STATES)))
    return checked


def words(tab):
    """The page's card."""
    state = tab.state
    return card(
        state.foreign,
        repaired=state.foreign.is_shown(state.plan),
        repairing=state.repairing,
        offer=offer(state),
    )


def test_a_file_that_is_opened_is_checked_beside_the_plan_and_plays(tab):
    submit, play = tab.effects
    assert (submit.queue, submit.lane, play) == (Queue.CHECK, 1, Play())
    assert isinstance(submit.task, CheckForeign)
    assert np.array_equal(submit.task.motion.motion().qpos, STATES.motion().qpos)
    assert tab.state.beside
    shown = words(tab)
    assert (shown["note"], shown["sentence"]) == ("Checking the motion at 1 kHz ...", "")
    assert [way["state"] for way in shown["ways"]] == ["busy"]
    assert shown["repair"] == "waits"
    assert tab.take(RepairAsked()) == ()


def test_the_plans_own_certificate_is_another_one(tab):
    foreign = tab.submits[-1]
    tab.take(Act.CHECK)
    assert type(tab.one.task) is CheckMotion
    assert tab.one.lane != foreign.lane
    tab.report(Checked(0, CERTIFICATE), submit=foreign)
    assert tab.state.check.certificate is None
    assert tab.state.foreign.before is CERTIFICATE


def test_its_broken_checks_are_said_by_how_much_and_when(checked):
    shown = words(checked)
    assert shown["sentence"] == f"1 of 3 checks broken (1 not known): {BROKEN}."
    assert shown["rows"][0] == {
        "title": "joint speed",
        "values": ("✗ 116.4 %, FL calf joint, 0.74 s",),
    }
    assert shown["repair"] == "ready"


@pytest.mark.parametrize(
    ("report", "why"), [(Failed(0, "no room"), "no room"), (Cancelled(0), "it was stopped.")]
)
def test_a_motion_that_was_not_checked_can_be_repaired_all_the_same(tab, report, why):
    tab.report(report)
    assert words(tab)["sentence"] == f"Not checked: {why}"
    assert words(tab)["repair"] == "ready"


def test_a_press_has_it_repaired_as_a_plan_is_made(checked):
    plan = checked.state.plan
    checked.take(RepairAsked())
    assert checked.one.queue is Queue.MOTION
    assert isinstance(checked.one.task, RepairMotion)
    checked.report(Progress(0, "near to the motion", iteration=3))
    assert checked.told == (Verdict.PLANNING, "a repair (near to the motion, step 3) ...")
    assert checked.state.status.busy
    assert words(checked)["note"] == "Repairing (near to the motion, step 3) ..."
    assert words(checked)["repair"] == "waits"
    assert is_visible(Act.CANCEL, checked.state)
    assert checked.take(RepairAsked()) == ()
    assert checked.take(Act.CANCEL) == (Stop(Queue.MOTION),)
    checked.report(Cancelled(0))
    assert checked.told == (Verdict.CANCELLED, "The plan is still there.")
    assert checked.state.plan is plan
    assert words(checked)["repair"] == "ready"


def test_it_is_the_pages_plan_beside_what_it_was(repaired):
    state = repaired.state
    assert state.plan is state.foreign.repair.plan
    assert (state.design.jump, state.note) == (state.plan.jump, "Repaired from turn.csv.")
    assert state.status.verdict is Verdict.FEASIBLE
    assert repaired.effects[-2:] == (Seek(0.0), Play())
    assert state.beside
    (pin,) = state.pins
    assert (pin.motion, pin.colour) == (state.foreign.motion, PINNED[0])
    part = pin.motion.motion  # from where its repair begins, in the plan's frame
    assert part.time[[0, -1]] == pytest.approx([0.0, 1.4])
    assert titles(state) == ("turn.csv, repaired", "turn.csv")
    shown = words(repaired)
    assert [way["name"] for way in shown["ways"]] == [
        "Before: turn.csv",
        "After: turn.csv, repaired",
    ]
    assert shown["sentence"] == (
        f"Before, in the file's own time: 1 of 3 checks broken (1 not known): {BROKEN}. "
        "After: all 3 checks hold. "
        "Moved: joints 0.052 rad (rms), base 3.4 cm (rms), landing 1.2 cm."
    )
    assert {len(row["values"]) for row in shown["rows"]} == {2}
    assert shown["repair"] == ""


def test_it_is_undone_and_done_again_without_a_second_repair(repaired):
    plan, before = repaired.state.plan, repaired.state.history.back[-1]
    repaired.take(Act.UNDO)
    assert repaired.state.design == before
    assert repaired.state.plan is not plan
    assert words(repaired)["repair"] == "ready"
    assert [way["name"] for way in words(repaired)["ways"]] == ["turn.csv"]
    assert words(repaired)["sentence"].startswith("In the file's own time: 1 of 3 checks broken")
    repaired.take(Act.REDO)
    assert repaired.state.plan is plan
    repaired.take(Act.UNDO)
    repaired.take(RepairAsked())
    assert repaired.state.plan is plan
    assert not repaired.of(Submit)


def test_it_is_simulated_as_any_plan(repaired):
    repaired.take(Act.SIMULATE)
    task = repaired.submits[-1].task
    assert isinstance(task, SimulateJump)
    assert task.plan is repaired.state.foreign.repair.plan


def test_one_that_cannot_be_repaired_leaves_the_plan(checked):
    plan, pins = checked.state.plan, checked.state.pins
    checked.take(RepairAsked())
    checked.report(Repaired(0, replace(repair_of(STATES), status="failed", why=NO_FLIGHT)))
    assert checked.state.plan is plan
    assert checked.state.pins == pins
    assert checked.told == (Verdict.FAILED, f"turn.csv was not repaired. {NO_FLIGHT}")
    shown = words(checked)
    assert shown["sentence"].endswith(f"{BROKEN}. Not repaired: {NO_FLIGHT}")
    assert shown["repair"] == ""
    assert checked.take(RepairAsked()) == ()


def test_another_request_ends_the_repair(checked):
    checked.take(RepairAsked())
    running = checked.one
    checked.move(forward=0.1)
    before = checked.state
    assert checked.report(Repaired(0, repair_of(STATES)), submit=running) == ()
    assert checked.state is before
    assert words(checked)["note"] == ""


def test_another_robots_motion_is_not_repaired(checked):
    checked.move(robot="go2")
    checked.settle()
    assert words(checked)["repair"] == ""
    assert checked.take(RepairAsked()) == ()


def test_numbers_that_no_design_may_have_are_no_repair(checked):
    found = repair_of(STATES)
    far = replace(found.plan, jump=replace(found.plan.jump, twist=1e6))
    checked.take(RepairAsked())
    checked.report(Repaired(0, replace(found, plan=far)))
    assert checked.state.status.verdict is Verdict.FAILED
    assert "twist: expected" in words(checked)["sentence"]
    assert words(checked)["repair"] == ""


def test_it_is_closed_with_its_card_or_its_pin(checked):
    other = planned_tab()
    other.state = checked.state
    checked.take(Act.UNPIN)
    assert checked.state.foreign is None
    other.take(RepairAsked())
    assert other.take(ComparisonClosed()) == (Stop(Queue.MOTION),)
    assert other.state.foreign is None
    assert len(other.state.pins) == 1
    other.report(Repaired(0, repair_of(STATES)))
    assert other.told == (Verdict.CANCELLED, "The plan is still there.")


def test_a_tab_that_comes_back_has_it_checked_anew(tab):
    tab.have(resume(left(tab.state), PageReady(software=True)))
    assert tab.of(Submit)[0].ticket == tab.state.foreign.ticket
    tab.report(Checked(0, CERTIFICATE))
    assert tab.state.foreign.before is CERTIFICATE
