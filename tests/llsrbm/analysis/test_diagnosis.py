"""A rollout that follows its references exactly, in which one thing goes wrong at a time."""

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from llsrbm.analysis.diagnosis import diagnose, fall_in_words
from llsrbm.request.scenario import Push
from tests.llsrbm.schedules import in_a_row
from tests.llsrbm.synthetic import quat_about_z, synthetic_plan
from tests.llsrbm.synthetic_rollout import RATE, TORQUE_LIMIT, synthetic_rollout

LIFT_OFF, TOUCHDOWN = 0.5, 0.89  # s, of the synthetic rollout
HEIGHT = 0.5  # m of its CoM
LEFT_FRONT, RIGHT_FRONT, LEFT_HIND = 0, 1, 2


def followed(plan=None):
    """The synthetic rollout, as if the controller had wanted just that."""
    rollout = synthetic_rollout(plan)
    foot = rollout.foot_position.copy()
    landing = rollout.phase == 2
    foot[landing] = foot[-1]
    return replace(
        rollout,
        foot_position=foot,
        torque=0.5 * rollout.torque,
        reference_com=rollout.com.copy(),
        reference_base_quat=rollout.base_quat.copy(),
        reference_foot_position=foot.copy(),
        reference_angular_momentum=rollout.angular_momentum.copy(),
    )


GOOD = followed()


def between(start, end, rollout=GOOD):
    return (rollout.time >= start - 1e-9) & (rollout.time < end - 1e-9)


def changed(rollout=GOOD, **columns):
    """With columns changed in place by functions of a copy."""
    copies = {name: getattr(rollout, name).copy() for name in columns}
    for name, change in columns.items():
        change(copies[name])
    return replace(rollout, **copies)


def put(where, what):
    def change(column):
        column[where] = what

    return change


def add(where, what):
    def change(column):
        column[where] += what

    return change


def ended(rollout, **outcome):
    return replace(rollout, outcome=replace(rollout.outcome, **outcome))


def only(rollout):
    (event,) = diagnose(rollout)
    return event


def test_nothing_is_found_where_nothing_went_wrong():
    assert diagnose(GOOD) == ()


def ramp(start, speed):
    """Growing evenly from `start` on, (T,)."""
    return speed * np.maximum(GOOD.time - start, 0.0)


@pytest.mark.parametrize(
    ("what", "direction", "speed", "threshold", "words"),
    [
        ("sink", [0, 0, -1], 0.5, 0.06 * HEIGHT, "the CoM sank 8 cm below the plan"),
        ("rise", [0, 0, 1], 1.0, 0.09 * HEIGHT, "the CoM rose 15 cm above the plan"),
        ("shift", [0.6, -0.8, 0], 0.5, 0.04 * HEIGHT, "the CoM moved 7 cm sideways from the plan"),
    ],
)
def test_a_com_that_leaves_the_plan_in_takeoff(what, direction, speed, threshold, words):
    away = ramp(0.2, speed)[:, None] * np.array(direction)
    event = only(ended(changed(com=add(..., away)), status="fell", fell_at_s=0.45))
    assert (event.what, event.words) == (what, words)
    assert event.time == pytest.approx(0.2 + 0.8 * threshold / speed, abs=1.5 / RATE)


def test_a_base_that_leans_away():
    """About x by the quaternion's second number, on top of the heading that it has."""
    lean = ramp(0.3, 1.0)
    zero = np.zeros_like(lean)
    about_x = np.stack([np.cos(lean / 2), np.sin(lean / 2), zero, zero], axis=-1)
    w, z = GOOD.base_quat[:, 0], GOOD.base_quat[:, 3]
    product = np.stack(
        [w * about_x[:, 0], w * about_x[:, 1], z * about_x[:, 1], z * about_x[:, 0]], axis=-1
    )
    event = only(ended(replace(GOOD, base_quat=product), status="fell", fell_at_s=0.48))
    threshold = math.radians(4.0)
    assert event.time == pytest.approx(0.3 + 0.8 * threshold, abs=1.5 / RATE)
    size = math.degrees(threshold + 0.1)  # as it grows on for a tenth of a second
    assert event.what == "lean"
    assert event.words == f"the base leaned {size:.0f}° away from the plan"


@pytest.mark.parametrize("turns", [0, 1, -2])
def test_a_base_that_turns_away_whatever_full_turns_it_has_made(turns):
    heading = 2 * np.arctan2(GOOD.base_quat[:, 3], GOOD.base_quat[:, 0])
    off = quat_about_z(heading - ramp(0.3, 1.0) + 2 * np.pi * turns)
    event = only(ended(replace(GOOD, base_quat=off), status="fell", fell_at_s=0.48))
    assert event.what == "turn"
    assert event.time == pytest.approx(0.3 + 0.8 * math.radians(3.0), abs=1.5 / RATE)


def test_what_is_large_in_takeoff_is_nothing_in_landing():
    assert diagnose(changed(com=add(between(1.2, 1.4), [0, 0, -0.2 * HEIGHT]))) == ()


def test_a_whole_body_that_turns_otherwise():
    turning = between(0.6, TOUCHDOWN)
    rate = np.array([0.9, 0.0, -1.2])
    excess = GOOD.inertia[turning] @ rate
    event = only(changed(angular_momentum=add(turning, excess)))
    assert (event.time, event.what) == (pytest.approx(0.6), "spin")
    assert event.words == "the whole body's turning rate was 1.5 rad/s off the plan"


def test_a_foot_that_slips():
    """From 0.3 s on, 0.4 m/s: 6 of 7.5 % of the CoM's height are 3 cm."""
    sliding = between(0.3, LIFT_OFF)
    slide = np.array([0.0, 0.4, 0.0]) * np.maximum(GOOD.time[sliding, None] - 0.3, 0)
    event = only(changed(foot_position=add((sliding, LEFT_HIND), slide)))
    assert event.what == "slip"
    assert event.words == "LH slipped 8 cm (friction 0.80)"
    assert event.time == pytest.approx(0.3 + 0.03 / 0.4, abs=1.5 / RATE)


def test_a_foot_that_is_lifted_in_takeoff():
    event = only(changed(contact=put((between(0.3, 0.36), RIGHT_FRONT), 0)))
    assert (event.time, event.what) == (pytest.approx(0.3), "contact lost")
    assert event.words == "RF was off the ground for 60 ms before lift-off"


def test_a_foot_that_stays_behind():
    staying = (between(0.4, LIFT_OFF + 0.05), LEFT_HIND)
    event = only(
        changed(
            contact=put(staying, 1), foot_position=put(staying, GOOD.foot_position[0, LEFT_HIND])
        )
    )
    assert (event.time, event.what) == (pytest.approx(LIFT_OFF), "lift-off")
    assert event.words == "LH stayed on the ground for 50 ms after lift-off"


def test_a_foot_that_bounces():
    event = only(changed(contact=put((between(0.95, 1.03), LEFT_FRONT), 0)))
    assert (event.time, event.what) == (pytest.approx(0.95), "contact lost")
    assert event.words == "LF lost the ground for 80 ms after touchdown"


def test_a_foot_that_misses_its_foothold():
    missing = GOOD.time >= TOUCHDOWN - 1e-9
    event = only(changed(foot_position=add((missing, RIGHT_FRONT), [0.0, 0.15, 0.0])))
    assert (event.time, event.what) == (pytest.approx(TOUCHDOWN), "foothold")
    assert event.words == "RF touched down 15 cm from its foothold"


@pytest.mark.parametrize(
    ("detected", "time", "what", "words"),
    [
        (0.95, TOUCHDOWN, "detection", "touchdown was noticed 60 ms late"),
        (None, TOUCHDOWN, "detection", "touchdown was not noticed"),
        (
            0.8,
            0.8,
            "false detection",
            "touchdown was detected without contact, 90 ms before the first",
        ),
    ],
)
def test_a_touchdown_that_is_not_seen_or_seen_wrongly(detected, time, what, words):
    event = only(ended(GOOD, touchdown_detected_s=detected))
    assert (event.time, event.what, event.words) == (pytest.approx(time), what, words)


@pytest.mark.parametrize(
    ("shift", "words"),
    [(-0.08, "touchdown came 70 ms late"), (0.07, "touchdown came 80 ms early"), (0.03, None)],
)
def test_a_touchdown_at_another_time(shift, words):
    """The rollout's own is 10 ms early."""
    rollout = ended(GOOD, touchdown_planned_s=GOOD.outcome.touchdown_planned_s + shift)
    events = diagnose(rollout)
    assert [event.words for event in events] == ([words] if words else [])


@pytest.mark.parametrize(
    ("height", "words"),
    [
        (0.05, "LF met ground 50 mm higher than planned, 10 ms early"),
        (-0.04, "LF met ground 40 mm lower than planned, 10 ms early"),
    ],
)
def test_ground_at_another_height(height, words):
    landed = GOOD.time >= TOUCHDOWN - 1e-9
    event = only(changed(foot_position=add((landed, slice(None), 2), height)))
    assert (event.what, event.words) == ("ground", words)


def saturated(start, end, joint, rollout=GOOD, limit=None):
    rows = (between(start, end), joint)
    at = rollout.torque_limit[rows] if limit is None else limit
    return changed(rollout, torque_limit=put(rows, at), torque=put(rows, -at))


SUNK = changed(com=add(between(0.4, LIFT_OFF), [0.0, 0.0, -0.1]))


def test_a_limit_that_something_gives_way_at_comes_first():
    first, then = diagnose(saturated(0.34, 0.46, 4, SUNK))
    assert (first.time, first.what) == (pytest.approx(0.34), "torque limit")
    name = GOOD.joint_names[4]
    assert first.words == f"{name} was at the torque limit for 120 ms"
    assert then.what == "sink"


@pytest.mark.parametrize(
    ("start", "end"),
    [(0.1, 0.3), (0.385, 0.46), (0.42, 0.48)],
    ids=["long before", "at once", "afterwards"],
)
def test_a_limit_that_is_no_cause(start, end):
    assert [event.what for event in diagnose(saturated(start, end, 4, SUNK))] == ["sink"]


def test_a_joint_too_fast_for_its_drive():
    first, _ = diagnose(saturated(0.34, 0.46, 4, SUNK, limit=0.2 * TORQUE_LIMIT))
    assert first.what == "speed limit"
    assert first.words == f"{GOOD.joint_names[4]} was at the speed limit for 120 ms"


def test_what_comes_after_the_fall_is_not_told():
    rollout = changed(SUNK, contact=put((between(1.2, 1.4), 0), 0))
    assert {event.what for event in diagnose(rollout)} == {"sink", "contact lost"}
    fell = ended(rollout, status="fell", fell_at_s=1.1)
    assert {event.what for event in diagnose(fell)} == {"sink"}
    early = ended(rollout, status="fell", fell_at_s=0.45)
    assert {event.what for event in diagnose(early)} == {"sink"}, "there is no touchdown by then"


def test_a_fall_in_words():
    fell = ended(SUNK, status="fell", fell_at_s=0.6, reason="the trunk touched the ground")
    assert fall_in_words(fell) == (
        "at 0.60 s: first the CoM sank 10 cm below the plan (0.40 s), "
        "then the trunk touched the ground"
    )
    sudden = ended(GOOD, status="fell", fell_at_s=0.6, reason="it toppled over")
    assert fall_in_words(sudden) == "at 0.60 s: it toppled over"
    assert fall_in_words(SUNK) == ""


def test_the_push_before_is_named():
    pushes = Push(0.1, (0, 3, 0)), Push(0.35, (0, 70, 0)), Push(0.5, (90, 0, 0))
    pushed = replace(SUNK, scenario=replace(SUNK.scenario, pushes=pushes))
    fell = ended(pushed, status="fell", fell_at_s=0.6, reason="the trunk touched the ground")
    assert "(0.40 s), 0.05 s after the push of 70 N s, then" in fall_in_words(fell)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), ticks=st.integers(1, len(GOOD.time)), fell=st.booleans())
def test_whatever_happened_events_are_in_order_and_before_the_fall(seed, ticks, fell):
    """However short the rollout, and however wild."""
    rng = np.random.default_rng(seed)
    wild = changed(
        com=lambda x: x.__iadd__(0.1 * rng.standard_normal(x.shape).cumsum(axis=0)),
        contact=lambda x: x.__imul__(rng.random(x.shape) < 0.9),
        torque=lambda x: x.__imul__(4.0),
    )
    columns = {
        name: value[:ticks]
        for name, value in vars(wild).items()
        if isinstance(value, np.ndarray) and len(value) == len(GOOD.time)
    }
    fell_at = float(rng.uniform(0, ticks / RATE)) if fell else None
    rollout = ended(replace(wild, **columns), fell_at_s=fell_at)
    times = [event.time for event in diagnose(rollout)]
    assert times == sorted(times)
    assert all(0 <= time <= (math.inf if fell_at is None else fell_at) for time in times)


HOP = 1.5  # s: the second of two jumps begins so much later


def hops():
    """Two such jumps in a row, put together from the ticks of one straight ahead."""
    plan = synthetic_plan(twist=0.0)
    one = followed(plan)
    first = between(0.0, HOP, one)
    ahead = one.foot_position[-1] - one.foot_position[0]
    moved = {"time": HOP, "phase": 2, "com": ahead[0], "foot_position": ahead}
    moved |= {f"reference_{name}": moved[name] for name in ("com", "foot_position")}
    columns = {
        field.name: np.concatenate([value[first], value + moved.get(field.name, 0)])
        for field in fields(one)
        if isinstance(value := getattr(one, field.name), np.ndarray)
    }
    outcome = one.outcome
    times = {
        name: getattr(outcome, name) + HOP
        for name in ("touchdown_planned_s", "touchdown_true_s", "touchdown_detected_s")
    }
    times["foot_touchdown_s"] = tuple(time + HOP for time in outcome.foot_touchdown_s)
    outcome = replace(outcome, **times)
    return replace(one, **columns, plan=in_a_row(plan, plan), outcome=outcome)


def test_what_is_large_in_takeoff_is_nothing_in_a_rebound():
    rollout = hops()
    sunk = between(1.2, 1.4, rollout)
    assert diagnose(changed(rollout, com=add(sunk, [0, 0, -0.2 * HEIGHT]))) == ()


def test_a_foot_that_stays_behind_in_the_second_hop():
    rollout = hops()
    staying = (between(HOP + 0.4, HOP + LIFT_OFF + 0.05, rollout), LEFT_HIND)
    place = rollout.foot_position[rollout.time < HOP + 0.4][-1, LEFT_HIND]
    event = only(changed(rollout, contact=put(staying, 1), foot_position=put(staying, place)))
    assert (event.time, event.what) == (pytest.approx(HOP + LIFT_OFF), "lift-off")


def test_a_base_that_turns_away_upside_down():
    """In the middle of a flip headings mean nothing; the turn between attitudes does."""
    pitch = np.pi * np.clip((GOOD.time - LIFT_OFF) / 0.2, 0, 1)
    flip = Rotation.from_euler("y", pitch[:, None])
    off = Rotation.from_euler("z", ramp(0.7, 2.0)[:, None])
    wanted = flip.as_quat(scalar_first=True)
    good = replace(GOOD, base_quat=wanted, reference_base_quat=wanted)
    assert diagnose(good) == ()
    turned = replace(good, base_quat=(off * flip).as_quat(scalar_first=True))
    event = only(ended(turned, status="fell", fell_at_s=0.98))
    assert event.what == "turn"
    assert event.time == pytest.approx(0.7 + 0.4 * math.radians(15.0), abs=1.5 / RATE)
