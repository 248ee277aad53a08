"""The menu of estimators: every one of the simulation's, each by a name of its own."""

import pytest

from app.panel.scenario_controls import DISTURBANCE, ESTIMATES
from llsrbm.request.scenario import Scenario
from llsrbm.simulation.sensors import ESTIMATORS

(FIELD,) = (field for field in DISTURBANCE if field.label == "Estimate")


def test_every_estimator_is_offered():
    assert list(ESTIMATES) == list(ESTIMATORS)
    assert len(set(FIELD.options)) == len(ESTIMATORS)


@pytest.mark.parametrize("name", ESTIMATORS)
def test_what_is_shown_is_what_is_asked_for(name):
    scenario = Scenario(seed=3, estimator=name)
    assert FIELD.there(scenario)
    assert FIELD.put(Scenario(seed=3), FIELD.shown(scenario)) == scenario


def test_a_files_unknown_estimator_is_not_read_from_the_menu():
    assert not FIELD.there(Scenario(estimator="nosuch"))
