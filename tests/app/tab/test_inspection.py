"""Questions about the motion that is shown: parts of the robot, and certificates."""

import pytest

from app.link import CertificateAsked, PartAsked, PartPlotted
from app.panel.acts import Act
from app.panel.certificate import certificate_table
from app.plots.choice import ChartChoice
from app.tab.acts import is_enabled
from app.tab.effects import Queue, ShowPart
from app.workers.reports import Cancelled, Checked, Failed
from app.workers.tasks import CheckMotion
from llsrbm.certificate import Certificate, Finding
from tests.app.planners import CERTIFICATE
from tests.app.pure_tab import PureTab, planned_tab

# ---- parts of the robot


@pytest.fixture(scope="module")
def shown():
    return planned_tab()


def test_a_part_says_what_it_does(shown):
    shown.take(PartAsked("LF_KFE"))
    (shows,) = shown.of(ShowPart)
    assert shows.reading["part"] == "LF_KFE"
    assert "Torque" in [row["title"] for row in shows.reading["rows"]]


def test_of_a_part_that_is_not_there_nothing_is_known(shown):
    shown.take(PartAsked("tail"))
    (shows,) = shown.of(ShowPart)
    assert shows.reading["rows"] == []


def test_before_there_is_a_motion_nothing_is_said():
    tab = PureTab()
    assert tab.take(PartAsked("LF_KFE")) == ()


def test_a_row_becomes_a_chart_once():
    tab = planned_tab()
    charts = tab.state.plots.charts
    for _ in range(2):
        tab.take(PartPlotted("LF_KFE", 2))
        assert tab.state.plots.charts == (*charts, ChartChoice("joint_torque", ("LF_KFE",)))
    assert tab.state.plots.open
    tab.take(PartPlotted("LF_KFE", 99))
    tab.take(PartPlotted("tail", 0))
    assert len(tab.state.plots.charts) == len(charts) + 1


# ---- certificates: made once, when they are asked for, in a process


@pytest.fixture
def tab():
    return planned_tab()


@pytest.mark.parametrize("event", [Act.CHECK, CertificateAsked()])
def test_the_verdict_and_the_button_ask_for_it_once(tab, event):
    assert is_enabled(Act.CHECK, tab.state)
    tab.take(event)
    assert (tab.one.queue, type(tab.one.task)) == (Queue.CHECK, CheckMotion)
    assert tab.one.task.motion is tab.state.plan
    assert tab.state.check.note == "Checking ..."
    assert not is_enabled(Act.CHECK, tab.state)
    assert tab.take(event) == ()
    tab.report(Checked(0, CERTIFICATE))
    assert (tab.state.check.certificate, tab.state.check.note) == (CERTIFICATE, "")
    assert tab.take(event) == ()


def test_a_simulation_has_its_own(tab):
    tab.take(Act.CHECK)
    old = tab.one
    tab.take(Act.SIMULATE)
    tab.finish_simulation()
    assert is_enabled(Act.CHECK, tab.state)
    tab.take(Act.CHECK)
    assert tab.one.task.motion is tab.state.rollout
    tab.report(Checked(0, CERTIFICATE), submit=old)  # too late
    assert tab.state.check.certificate is None


def test_what_fails_says_so_and_what_is_given_up_can_be_asked_for_again(tab):
    tab.take(Act.CHECK)
    tab.report(Failed(0, "no such robot"))
    assert tab.state.check.note == "Not checked: no such robot"
    tab = planned_tab()
    tab.take(Act.CHECK)
    tab.report(Cancelled(0))
    assert is_enabled(Act.CHECK, tab.state)


def test_exports_carry_it(tab):
    tab.take(Act.EXPORT)
    assert tab.one.task.trajectory.certificate is None
    tab.take(Act.CHECK)
    tab.report(Checked(0, CERTIFICATE))
    tab.take(Act.EXPORT)
    assert tab.one.task.trajectory.certificate == CERTIFICATE.as_dict()


def test_without_a_plan_there_is_nothing_to_check():
    tab = PureTab()
    assert not is_enabled(Act.CHECK, tab.state)
    assert tab.take(CertificateAsked()) == ()


def test_a_limit_of_zero_and_a_distance_just_below_it_are_told_in_words_of_their_own():
    pulls = Finding("contact_force", 1.002, 0.0, "N", "LF", 0.1, holds=True, allowed=1.01)
    near = Finding("clearance", -0.00002, -0.005, "m", "LF", 0.1, holds=True, allowed=-0.005)
    table = certificate_table(Certificate((pulls, near)), "plan")
    assert "0.2 % of the weight" in table
    assert ">0.0 mm" in table
    assert "−5.0 mm" in table


def test_the_table_has_every_finding_and_the_instant_to_look_at():
    table = certificate_table(CERTIFICATE, "plan")
    assert "1 check of the plan does not hold." in table
    assert "116.4 %" in table
    assert "30.1 rad/s" in table
    assert 'data-seek="0.7400"' in table
    assert "0.4 mm" in table
    assert "10.0 mm" in table
    assert "pushes act beside the contacts" in table
    held = certificate_table(Certificate(CERTIFICATE.findings[1:2]), "simulation")
    assert "All checks of the simulation hold." in held
