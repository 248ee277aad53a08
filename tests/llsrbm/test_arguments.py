"""Arguments of other types to all that `llsrbm` offers: one line, which names what is expected."""

import json
from pathlib import Path

import numpy as np
import pytest

import llsrbm
from llsrbm.library import Filters
from tests.llsrbm.library.shipped_motions import library, plan

GO2 = llsrbm.Jump(robot="go2", twist=0.3)
NO_MOTIONS = [None, 3, b"go2", {}, np.zeros(3), GO2, llsrbm.Plan]


def refused(call, expected):
    with pytest.raises(llsrbm.InputError) as caught:
        call()
    assert "\n" not in str(caught.value)
    assert expected in str(caught.value)


@pytest.mark.parametrize("given", NO_MOTIONS, ids=repr)
@pytest.mark.parametrize(
    ("call", "expected"),
    [
        (llsrbm.simulate, "expected a plan to simulate"),
        (llsrbm.certify, "expected a Plan, a Rollout or a WholeBodyMotion"),
        (llsrbm.certified, "expected a Plan or a Rollout"),
        (llsrbm.with_feedback, "expected a Plan"),
        (llsrbm.sensitivity, "expected a Plan"),
        (lambda given: llsrbm.export(given, "jump.npz"), "expected a Plan, a Rollout"),
        (llsrbm.repair, "expected a Plan, a Rollout or a WholeBodyMotion"),
        (llsrbm.repair_clip, "expected a Plan, a Rollout or a WholeBodyMotion"),
        (llsrbm.dump_design, "expected a Design"),
        (llsrbm.load, "expected a path as text or a Path"),
        (llsrbm.load_motion, "expected a path as text or a Path"),
        (lambda given: plan().save(given), "expected a path as text or a Path"),
        (lambda given: llsrbm.export(plan(), given), "expected a path as text or a Path"),
    ],
)
def test_what_is_no_motion_and_no_path(call, expected, given):
    refused(lambda: call(given), expected)


@pytest.mark.parametrize("given", [None, "go2", Path("go2.npz"), [GO2], llsrbm.Jump], ids=repr)
def test_what_is_no_jump(given):
    refused(lambda: llsrbm.plan(given), "jump: expected a Jump")
    refused(lambda: llsrbm.largest(given, "forward"), "jump: expected a Jump")


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"solver": None}, "solver: expected a name as text"),
        ({"intervals": "30"}, "intervals: expected a whole number"),
        ({"intervals": None}, "intervals: expected a whole number"),
        ({"weights": "x"}, "weights: expected names with numbers"),
        ({"weights": [("time", 1.0)]}, "weights: expected names with numbers"),
        ({"weights": {"time": "a"}}, "weights: time: expected a number"),
        ({"limits": {"friction": None}}, "limits: friction: expected a number"),
        ({"near": "plan.npz"}, "near: expected a Plan"),
        ({"near": GO2}, "near: expected a Plan"),
        ({"cancelled": True}, "cancelled: expected a function"),
        ({"progress": 3}, "progress: expected a function"),
    ],
)
def test_arguments_of_plan(options, expected):
    refused(lambda: llsrbm.plan(GO2, draft=True, **options), expected)


@pytest.mark.parametrize("name", ["cancelled", "progress", "so_far"])
def test_functions_of_a_simulation(name):
    refused(lambda: llsrbm.simulate(plan(), **{name: True}), f"{name}: expected a function")


@pytest.mark.parametrize("component", [None, 3, ["forward"]])
def test_components_that_are_no_text(component):
    refused(lambda: llsrbm.largest(GO2, component), "component: expected a name as text")


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"format": None}, "format: expected a name or several"),
        ({"format": ["csv", 3]}, "format: expected a name as text"),
        ({"format": [{}]}, "format: expected a name as text"),
        ({"format": "csv", "fps": "50"}, "fps: expected a finite number"),
        ({"format": "csv", "fps": True}, "fps: expected a finite number"),
        ({"format": "motion-npz", "pad": None}, "pad: expected a finite number"),
        ({"format": "lowcmd", "packed": "no"}, "packed: expected true or false"),
    ],
)
def test_options_of_an_export(tmp_path, options, expected):
    refused(lambda: llsrbm.export(plan(), tmp_path / "jump", **options), expected)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("kind", [np.int32, np.int64, np.float32])
def test_rates_of_numpys_types(tmp_path, kind):
    path = tmp_path / "jump.csv"
    llsrbm.export(plan(), path, format="unitree-csv", fps=kind(50))
    beside = json.loads((tmp_path / "jump.csv.meta.json").read_text())
    assert beside["fps"] == 50
    plan().save(tmp_path / "plan.npz")
    motion = llsrbm.load_motion(tmp_path / "plan.npz", fps=kind(50))
    assert type(motion.fps) is float
    llsrbm.export(motion, path, format="unitree-csv")


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"robot": None}, "robot: expected a name or a path as text"),
        ({"robot": Path("go2")}, "robot: expected a name or a path as text"),
        ({"format": 3}, "format: expected a name as text"),
        ({"fps": "50"}, "frames per second: expected"),
        ({"fps": True}, "frames per second: expected"),
    ],
)
def test_arguments_of_load_motion(tmp_path, options, expected):
    plan().save(tmp_path / "plan.npz")
    refused(lambda: llsrbm.load_motion(tmp_path / "plan.npz", **options), expected)


def test_a_name_that_no_file_can_have():
    refused(lambda: llsrbm.load_motion("a\0b"), "cannot be read: embedded null")


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"phases": 3}, "phases: expected a list of phases"),
        ({"phases": [1]}, "phase 1: expected one of `Repair.phases`"),
        ({"cancelled": True}, "cancelled: expected a function"),
        ({"progress": 3}, "progress: expected a function"),
    ],
)
@pytest.mark.parametrize("repair", [llsrbm.repair, llsrbm.repair_clip])
def test_arguments_of_repairs(repair, options, expected):
    refused(lambda: repair(plan(), **options), expected)


def test_words_and_figures_of_the_library():
    cards = library().found("go2 hops")
    assert cards == library().found(["go2", "hops"])
    assert cards
    for words in (None, 3, [3]):
        refused(lambda words=words: library().found(words), "words: expected")
    refused(lambda: library().found([], "go2"), "filters: expected Filters")
    refused(lambda: library().open(None), "motion: expected a name as text")
    for value in ("1", True, np.nan):
        refused(lambda value=value: Filters(min_turn=value), "min_turn: expected a finite number")


@pytest.mark.parametrize(
    "given", [np.array(3.0), np.zeros((2, 2)), {"kg": 3}, {}, "3", None, (1.0, 0.0)], ids=repr
)
def test_payloads_that_are_none(given):
    refused(lambda: llsrbm.Jump(payload=given), "payload: expected KG")


def test_payloads_of_numpy():
    assert llsrbm.Jump(payload=np.array([])).payload == ()
    assert llsrbm.Jump(payload=np.array([3.0, 0, 0.1, 0])).payload == (3.0, 0.0, 0.1, 0.0)
