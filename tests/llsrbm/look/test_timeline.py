"""Strips and marks of the timeline: the phases of the schedule, each with its feet."""

from dataclasses import replace

import numpy as np
import pytest

from llsrbm.look import palette
from llsrbm.look.timeline import timeline
from llsrbm.motion.replan import Replan
from llsrbm.request.scenario import Push, Scenario
from tests.llsrbm.synthetic import TWO_HOPS, TWO_HOPS_DURATIONS, synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout


@pytest.fixture(scope="module")
def hops():
    return synthetic_plan(schedule=TWO_HOPS, durations=TWO_HOPS_DURATIONS)


def test_take_off_flight_landing():
    plan = synthetic_plan()
    events = timeline(plan)
    (row,) = events.rows
    assert [(piece.name, piece.colour, piece.feet) for piece in row.pieces] == [
        ("take-off", palette.TAKE_OFF, "all feet"),
        ("flight", palette.FLIGHT, "no foot"),
        ("landing", palette.LANDING, "all feet"),
    ]
    assert sorted(mark.name for mark in events.marks) == [
        "apex",
        "lift-off",
        "push-off",
        "touchdown",
    ]
    assert events.summary == "lift-off 0.50 s, touchdown 0.90 s"
    lowest = plan.time[np.argmin(np.where(plan.time <= 0.5, plan.com[:, 2], np.inf))]
    assert {mark.name: mark.time for mark in events.marks}["push-off"] == lowest
    assert events.end == plan.duration


def test_a_rollout_of_it():
    rollout = synthetic_rollout()
    events = timeline(rollout.plan, rollout)
    assert [row.name for row in events.rows] == ["plan", "simulation"]
    assert [piece.name for piece in events.rows[1].pieces] == [
        "take-off", "flight", "landing", "standing", "force control",
    ]  # fmt: skip
    assert events.summary.startswith(
        "touchdown 0.900 s, simulated 0.890 s, detected +5.0 ms, force control 0.90 to 1.09 s"
    )
    marks = {mark.name: mark.time for mark in events.marks}
    assert marks["first contact"] == rollout.outcome.touchdown_true_s
    assert marks["detected"] == rollout.outcome.touchdown_detected_s


def test_every_phase_of_several_jumps(hops):
    events = timeline(hops)
    pieces = events.rows[0].pieces
    assert tuple(piece.name for piece in pieces) == TWO_HOPS.names
    edges = [piece.start for piece in pieces] + [pieces[-1].end]
    assert edges == pytest.approx(hops.phase_start)
    assert [piece.feet for piece in pieces[:2]] == ["all feet", "LH, RH"]
    # Fewer feet are paler.
    assert pieces[1].colour != palette.TAKE_OFF
    assert all(a > b for a, b in zip(pieces[1].colour, palette.TAKE_OFF, strict=True))
    marks = {mark.name: mark.time for mark in events.marks}
    assert marks["lift-off"] == pytest.approx(0.6)
    assert marks["touchdown"] == pytest.approx(0.9)
    assert marks["lift-off 2"] == pytest.approx(1.3)
    assert marks["touchdown 2"] == pytest.approx(1.65)
    assert marks["push-off"] <= marks["lift-off"] <= marks["apex"] <= marks["touchdown"]
    assert marks["touchdown"] <= marks["push-off 2"] <= marks["lift-off 2"]
    assert marks["lift-off 2"] <= marks["apex 2"] <= marks["touchdown 2"]


def test_pushes_are_marks_by_their_size():
    rollout = synthetic_rollout()
    pushes = (Push(0.6, (3.0, 4.0, 0.0)), Push(0.7, (0.0, 0.0, 1.0)))
    rollout = replace(
        rollout,
        scenario=Scenario(pushes=pushes),
        disturbance=replace(rollout.disturbance, random_push=Push(0.8, (0.0, -7.5, 0.0))),
    )
    marks = timeline(rollout.plan, rollout).marks
    assert [(mark.name, mark.time) for mark in marks if mark.colour == palette.FORCE] == [
        ("push 5 N s", 0.6),
        ("push 1 N s", 0.7),
        ("push 7.5 N s", 0.8),
    ]


def planned_anew(asked, computing_time, *, solved=True, applied=1.0):
    none = np.zeros((0, 4, 3))
    return Replan(
        measured=asked,
        applied=applied,
        computing_time=computing_time,
        solved=solved,
        iterations=3,
        touchdown=np.nan,
        time=np.zeros(0),
        com=np.zeros((0, 3)),
        base_quat=np.zeros((0, 4)),
        foot_position=none,
        foot_quat=np.zeros((0, 4, 4)),
    )


def test_computing_times_are_bars_over_their_deadline():
    replans = (
        planned_anew(0.48, 0.005, applied=np.nan),  # the robot kept to its first plan
        planned_anew(0.50, 0.005),
        planned_anew(0.52, 0.030, applied=np.nan),
        planned_anew(0.54, 0.010, solved=False, applied=np.nan),
    )
    rollout = replace(synthetic_rollout(), replans=replans)
    bars = timeline(rollout.plan, rollout).bars
    in_time = {0.48: True, 0.50: True, 0.52: False, 0.54: False}
    assert {bar.time: bar.in_time for bar in bars} == in_time
    assert [bar.height for bar in bars] == pytest.approx([0.25, 0.25, 1.5, 0.5])
    assert [bar.words.partition(": ")[2] for bar in bars] == [
        "5.0 ms of 20 ms, not followed",
        "5.0 ms of 20 ms",
        "30.0 ms of 20 ms, too late to be followed",
        "10.0 ms of 20 ms, no solution",
    ]
    assert timeline(rollout.plan).bars == ()


def test_the_mark_of_a_fall_is_when_it_fell():
    rollout = synthetic_rollout()
    outcome = replace(rollout.outcome, status="fell", fell_at_s=0.6)
    events = timeline(rollout.plan, replace(rollout, outcome=outcome))
    assert {mark.name: mark.time for mark in events.marks}["fell"] == 0.6
