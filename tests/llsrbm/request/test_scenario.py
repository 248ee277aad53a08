"""`Scenario`: what may be asked of a simulation, and how it is said when it may not."""

import json
import pickle
from dataclasses import asdict, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import llsrbm
from llsrbm.errors import InputError
from llsrbm.request.messages import Number, field_specs
from llsrbm.request.scenario import MOST_NOISE, Push, Scenario
from tests.llsrbm.processes import assert_spares
from tests.llsrbm.request.scenarios import scenarios

PUSH = {"time": 0.4, "impulse": (0.0, 12.0, 0.0)}
NAMES = st.sampled_from(["residual", "norm", "auto", "mine"])
NUMBERS = {
    name: meaning for name, meaning in field_specs(Scenario).items() if isinstance(meaning, Number)
}


def refused(**given):
    with pytest.raises(InputError) as caught:
        Scenario(**given)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 200
    return str(caught.value)


def test_what_is_not_said_is_nominal():
    assert asdict(Scenario()) == {
        "board": 0.0, "half_board": False, "seed": None, "noise": None, "detector": "residual",
        "landing": "auto", "solver": "quadprog", "trunk_mass": None, "pushes": (),
        "random_push": None, "estimator": "truth", "replan": False, "replan_latency": "fixed",
        "drives": "true",
    }  # fmt: skip
    assert llsrbm.Scenario is Scenario


@given(st.integers(0, 2**70), st.floats(0, MOST_NOISE))
def test_seed_and_noise_go_together(seed, noise):
    assert (Scenario(seed=seed).seed, Scenario(seed=seed).noise) == (seed, 1.0)
    assert (Scenario(noise=noise).seed, Scenario(noise=noise).noise) == (0, noise)
    both = Scenario(seed=seed, noise=noise)
    assert (both.seed, both.noise) == (seed, noise)
    assert replace(both, seed=None, noise=None) == Scenario()


@pytest.mark.parametrize("name", NUMBERS)
@given(data=st.data())
def test_a_number_is_accepted_within_its_range_alone(name, data):
    low, high = NUMBERS[name].low, NUMBERS[name].high
    inside = data.draw(st.floats(low, high))
    kept = getattr(Scenario(**{name: inside}), name)
    assert kept == inside
    assert type(kept) is float
    outside = data.draw(
        st.floats(max_value=low, exclude_max=True, allow_infinity=False)
        | st.floats(min_value=high, exclude_min=True, allow_infinity=False)
    )
    said = refused(**{name: outside})
    assert said == (f"{name.replace('_', ' ')}: expected {NUMBERS[name].accepted}, got {outside:g}")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"board": -0.01}, "board: expected 0 to 1 m, got -0.01"),
        ({"board": np.nan}, "board: expected a finite number, got nan"),
        ({"half_board": True}, "half board: expected the board's thickness beside it, got none"),
        ({"half_board": 1, "board": 0.1}, "half board: expected true or false, got 1"),
        ({"seed": -1}, "seed: expected a whole number from 0 on, got -1"),
        ({"seed": True}, "seed: expected a whole number from 0 on, got True"),
        ({"noise": 3.1}, "noise: expected 0 to 3, got 3.1"),
        ({"trunk_mass": -0.51}, "trunk mass: expected -0.5 to 0.5 of it, got -0.51"),
        ({"random_push": 201}, "random push: expected 0 to 200 N s, got 201"),
        ({"pushes": 3}, "pushes: expected a list of pushes, got 3"),
        ({"pushes": Push(0.1, (1, 2, 3))}, "pushes: expected a list of pushes, got Push"),
        ({"pushes": [{"time": 0.1}]}, "pushes: expected pushes of time, impulse, moment, got "),
        ({"pushes": [{"time": 0.1, "impulse": 7}]}, "push: impulse: expected three finite"),
        ({"pushes": [PUSH] * 101}, "pushes: expected at most 100, got 101"),
        ({"detector": ""}, "detector: expected a name, got ''"),
        ({"solver": "two\nlines"}, "solver: expected a name, got 'two\\nlines'"),
        ({"solver": "x" * 101}, "solver: expected a name of at most 100 characters, got 'xxx"),
    ],
)
def test_what_makes_no_sense(given, said):
    assert refused(**given).startswith(said)


def test_scalars_of_numpy_become_pythons_own():
    scenario = Scenario(
        board=np.float32(0.5), half_board=np.True_, seed=np.int64(7), noise=np.float64(0.5)
    )
    assert scenario == Scenario(0.5, True, 7, 0.5)
    assert [type(value) for value in asdict(scenario).values()][:4] == [float, bool, int, float]


def test_pushes_of_a_file_are_pushes():
    """Lists and mappings, as JSON has them."""
    table = {"time": 0.4, "impulse": [0, 12, 0], "moment": [0, 0, 1]}
    push = Push(0.4, (0.0, 12.0, 0.0), (0.0, 0.0, 1.0))
    scenario = Scenario(pushes=[table, push])
    assert scenario.pushes == (push, push)
    assert hash(scenario) == hash(Scenario(pushes=(push, push)))
    stated = scenario.stated()
    assert json.loads(json.dumps(stated))["pushes"] == [table, table]


@given(scenarios(NAMES, 2**70))
def test_what_is_stated_asks_for_it(scenario):
    stated = scenario.stated()
    assert Scenario(**stated) == Scenario().but(**stated) == scenario
    for name in stated:
        fewer = {key: value for key, value in stated.items() if key not in (name, "half_board")}
        assert name == "seed" or Scenario(**fewer) != scenario  # a noise implies the seed 0
    assert pickle.loads(pickle.dumps(scenario)) == scenario


def test_another_scenario_by_fields():
    board = Scenario(board=0.02, half_board=True, seed=7, noise=0.5)
    assert board.but(seed=8) == Scenario(0.02, True, 8, 0.5)
    assert board.but() == board
    with pytest.raises(InputError, match=r"half board: expected the board's thickness"):
        board.but(board=0)
    for name, said in (
        (
            "sead",
            'unknown field "sead"; did you mean "seed"? valid: board, half_board, seed, noise',
        ),
        ("two\nlines", r'unknown field "two\nlines"; valid: board'),
    ):
        with pytest.raises(InputError) as caught:
            board.but(**{name: 1})
        assert str(caught.value).startswith(said)


def test_it_imports_nothing_heavy():
    program = "import llsrbm; llsrbm.Scenario(seed=3)"
    assert_spares(program, "casadi", "pinocchio", "mujoco", "numpy", "pydantic")
