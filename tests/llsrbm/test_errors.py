"""Errors as values: what a process pool or a person's session sees of them."""

import pickle

import llsrbm
from llsrbm.errors import NotConverged, Stop, printable
from tests.llsrbm.sameness import assert_same
from tests.llsrbm.synthetic import synthetic_plan


def test_a_plan_that_failed_comes_back_from_another_process():
    stop = Stop("friction", "take-off", 0.2, 0.05, "1", limit="friction", needed=0.6)
    error = NotConverged("no plan found", synthetic_plan(), (stop,))
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.stops) == ("no plan found", (stop,))
    assert_same(again.plan, error.plan)


def test_text_of_strangers_is_one_short_line():
    assert printable("a\nb\x1b") == "a?b?"
    assert printable("x" * 99, 10) == "xxxxxxx..."


def test_names_are_completed():
    listed = dir(llsrbm)
    assert set(llsrbm.__all__) <= set(listed)
    assert not {"Any", "TYPE_CHECKING", "annotations", "import_module"} & set(listed)
    assert all(hasattr(llsrbm, name) for name in listed)
