"""Motions by words and figures."""

import math
from dataclasses import replace

import pytest

from llsrbm.errors import InputError
from llsrbm.library import Filters
from llsrbm.library.search import found
from tests.llsrbm.library.shipped_motions import card


def motion(name, kind="together", robot="go2", **figures):
    own = replace(card().figures, **figures)
    return card().model_copy(update={"name": name, "kind": kind, "robot": robot, "figures": own})


MOTIONS = [
    motion("go2-together-0002", forward_m=0.5, lateral_m=0.0, turn=-2.0, flight_s=0.4),
    motion("go2-back-flip-0001", "back-flip", forward_m=0.0, lateral_m=0.0, turn=0.0),
    motion("anymal-together-0001", robot="anymal", forward_m=0.3, lateral_m=0.4, height_m=0.2),
]


@pytest.mark.parametrize(
    ("words", "names"),
    [
        ([], ["anymal-together-0001", "go2-back-flip-0001", "go2-together-0002"]),
        (["flip"], ["go2-back-flip-0001"]),
        (["Back Flip", "GO2"], ["go2-back-flip-0001"]),
        (["anymal", "flip"], []),
        (["0002"], ["go2-together-0002"]),
    ],
)
def test_all_words_are_found(words, names):
    assert [each.name for each in found(MOTIONS, words)] == names


@pytest.mark.parametrize(
    ("filters", "count"),
    [
        (Filters(min_distance=0.5), 2),
        (Filters(min_distance=0.51, max_distance=0.52), 0),
        (Filters(min_turn=math.radians(100)), 1),
        (Filters(min_height=0.1), 1),
        (Filters(min_flight=0.39), 1),
        (Filters(robot="anymal"), 1),
        (Filters(kind="back-flip"), 1),
        (Filters(max_power=1.0), 0),
    ],
)
def test_figures(filters, count):
    assert len(found(MOTIONS, (), filters)) == count


@pytest.mark.parametrize(
    ("filters", "message"),
    [
        ({"robot": "Go2"}, 'no robot "Go2"; did you mean "go2"'),
        ({"kind": "backflip"}, 'no kind "backflip"; did you mean "back-flip"'),
        ({"min_distance": 0.5, "max_distance": 0.2}, "min_distance 0.5 is beyond max_distance 0.2"),
    ],
)
def test_filters_that_nothing_could_fit_are_refused(filters, message):
    with pytest.raises(InputError, match=message):
        found(MOTIONS, (), Filters(**filters))


def test_a_robot_or_a_kind_without_motions_is_no_mistake():
    assert found(MOTIONS, (), Filters(robot="solo12")) == []
    assert found(MOTIONS, (), Filters(kind="barrel-roll")) == []


def test_no_number_is_no_filter():
    with pytest.raises(InputError, match="min_turn: expected a finite number"):
        Filters(min_turn=math.nan)
