import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.errors import InputError
from llsrbm.request.tuning import Tuning

values = st.dictionaries(st.text(max_size=5), st.floats(allow_nan=False, allow_infinity=False))


@given(weights=values, limits=values)
def test_a_value_like_any_other(weights, limits):
    tuning = Tuning(weights=weights, limits=limits)
    same = pickle.loads(pickle.dumps(tuning))
    assert same == tuning
    assert hash(same) == hash(tuning)
    assert (tuning.weights, tuning.limits) == (weights, limits)
    assert bool(tuning) == bool(weights or limits)


def test_kept_apart_from_what_it_was_made_of():
    limits = {"friction": 0.4}
    tuning = Tuning(limits=limits)
    limits["friction"] = 0.9
    assert tuning.limits["friction"] == 0.4


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"weights": 3}, "Tuning.weights: expected names with numbers, got int"),
        ({"limits": {3: 1.0}}, "Tuning.limits: expected names as text, got 3"),
        ({"limits": {"friction": "0.4"}}, "Tuning.limits.friction: expected a finite number"),
        ({"limits": {"friction": float("nan")}}, "expected a finite number, got nan"),
        ({"weights": {"time": True}}, "Tuning.weights.time: expected a finite number, got True"),
    ],
)
def test_what_is_none(given, message):
    with pytest.raises(InputError) as caught:
        Tuning(**given)
    assert message in str(caught.value)
