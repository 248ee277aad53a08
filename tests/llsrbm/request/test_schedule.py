"""Schedules: what they say of their feet, and one line for each that cannot be."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.errors import InputError
from llsrbm.request.schedule import TIMINGS, Phase, Schedule
from tests.llsrbm.schedules import schedules
from tests.llsrbm.synthetic import LEGS, TWO_HOPS

ALL, NONE = Phase("take-off", LEGS, "takeoff"), Phase("flight", (), "flight")
LANDING = Phase("landing", LEGS, "landing", place=1)


def schedule(*phases, legs=LEGS):
    return Schedule(legs, phases)


def test_what_it_says_of_its_feet():
    assert TWO_HOPS.flights == (2, 4)
    assert TWO_HOPS.places == 2
    assert len(TWO_HOPS) == 7
    told = [TWO_HOPS.standing_words(phase) for phase in range(7)]
    assert told == [
        "all feet", "LH, RH", "no foot", "all feet", "no foot", "LF, RF", "all feet",
    ]  # fmt: skip
    np.testing.assert_array_equal(TWO_HOPS.lifts(1), [True, True, False, False])
    np.testing.assert_array_equal(TWO_HOPS.lands(5), [True, True, False, False])
    assert not TWO_HOPS.lifts(0).any()
    assert not TWO_HOPS.lands(0).any()


@pytest.mark.parametrize(
    ("phases", "said"),
    [
        ((), "it has 0 phases; expected at least three"),
        ((NONE, ALL, NONE), 'it begins with "flight", in which LF, RF, LH, RH do not stand'),
        (
            (replace(ALL, feet=("LF", "LF", "RF", "LH")), NONE, LANDING),
            'phase 1, "take-off": foot LF is named twice; expected every foot once',
        ),
        (
            (replace(ALL, feet=(*LEGS, "tail")), NONE, LANDING),
            'phase 1, "take-off": unknown foot "tail"; the feet are LF, RF, LH, RH',
        ),
        ((ALL, NONE, replace(ALL, place=1), NONE), 'it ends with "flight", in which'),
        (
            (ALL, NONE, replace(LANDING, feet=LEGS[:3])),
            'it ends with "landing", in which RH does not stand; expected all feet to stand',
        ),
        ((ALL, NONE, replace(LANDING, place=0)), "it has no end; expected a landing in place 1"),
        (
            (ALL, Phase("rear", LEGS[2:], (0.1, 0.2)), replace(ALL, name="again")),
            "it has no flight; expected a phase in which no foot stands",
        ),
        ((ALL, NONE, NONE, LANDING), 'phases 2, "flight", and 3, "flight", have the same feet'),
        (
            (ALL, Phase("rear", LEGS[2:], (0.1, 0.2), place=1), NONE, LANDING),
            'between "take-off" and "rear" feet stand in place 0 and 1; expected a flight',
        ),
        ((replace(ALL, time="soon"), NONE, LANDING), 'time "soon"; expected takeoff, flight, land'),
        ((replace(ALL, time=(0.2, 0.1)), NONE, LANDING), "time 0.2 to 0.1 s; expected the shortes"),
        ((replace(ALL, share=9.0), NONE, LANDING), "share 9; expected 0.1 to 4"),
        ((replace(ALL, name=""), NONE, LANDING), "expected a name of 1 to 40 printable letters"),
    ],
)
def test_one_that_cannot_be_is_a_line(phases, said):
    with pytest.raises(InputError) as caught:
        schedule(*phases)
    assert said in str(caught.value)
    assert str(caught.value).isprintable()


feet = st.lists(st.sampled_from([*LEGS, "tail"]), max_size=5).map(tuple)
times = st.sampled_from([*TIMINGS, "soon"]) | st.tuples(st.floats(), st.floats())
phases = st.builds(
    Phase,
    name=st.text(max_size=3),
    feet=feet | st.just(LEGS) | st.just(()),
    time=times,
    place=st.integers(-1, 3),
    share=st.floats(),
)


@given(st.lists(phases, max_size=5))
def test_any_phases_are_a_schedule_or_one_line(rows):
    try:
        made = schedule(*rows)
    except InputError as error:
        assert str(error).isprintable()
    else:
        assert made.stands[0].all()
        assert made.stands[-1].all()


@given(schedules())
def test_there_and_back_through_json(made):
    assert Schedule.from_dict(json.loads(json.dumps(made.as_dict()))) == made


@pytest.mark.parametrize("table", [{}, {"legs": list(LEGS)}, [], None, 3])
def test_no_table_of_a_schedule(table):
    with pytest.raises(InputError, match="not one that this version wrote"):
        Schedule.from_dict(table)
