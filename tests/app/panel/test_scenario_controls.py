"""Controls of a scenario: the menu of estimators, and the box for ideal drives."""

import pytest

from app.panel.scenario_controls import DISTURBANCE
from llsrbm.request.scenario import Scenario
from llsrbm.simulation.sensors import ESTIMATORS

(IDEAL,) = (field for field in DISTURBANCE if field.label == "Ideal drives")
(FIELD,) = (field for field in DISTURBANCE if field.label == "Estimator")


def test_every_estimator_is_offered():
    assert FIELD.options == tuple(ESTIMATORS)
    assert all(f"{name}, {kind.summary}" in FIELD.hint for name, kind in ESTIMATORS.items())


@pytest.mark.parametrize("name", ESTIMATORS)
def test_what_is_shown_is_what_is_asked_for(name):
    scenario = Scenario(seed=3, estimator=name)
    assert FIELD.there(scenario)
    assert FIELD.put(Scenario(seed=3), FIELD.shown(scenario)) == scenario


def test_a_files_unknown_estimator_is_not_read_from_the_menu():
    assert not FIELD.there(Scenario(estimator="nosuch"))


@pytest.mark.parametrize(("on", "drives"), [(False, "true"), (True, "ideal")])
def test_the_box_for_ideal_drives(on, drives):
    scenario = IDEAL.put(Scenario(seed=3, drives="ideal"), on)
    assert scenario == Scenario(seed=3, drives=drives)
    assert IDEAL.shown(scenario) is on
    assert IDEAL.there(scenario)
    assert not IDEAL.there(Scenario(drives="nosuch"))
