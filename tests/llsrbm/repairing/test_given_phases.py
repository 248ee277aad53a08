"""Contact phases that are given: taken as they are, or refused in a line that says why."""

import json
from dataclasses import replace

import numpy as np
import pytest

import llsrbm
from llsrbm.repairing.given_phases import given_phases
from llsrbm.repairing.phases import ContactPhase, contact_phases
from tests.llsrbm.player.stages import stored_plan
from tests.llsrbm.repairing.foreign import GO2, jump

ALL = list(GO2.leg_names)
PHASES = [(ALL, 0.0, 0.7), ([], 0.7, 1.05), (ALL, 1.05, 1.8)]


def rows(phases=PHASES):
    return [{"name": "any", "feet": f, "start_s": a, "end_s": b} for f, a, b in phases]


def given(tmp_path, content):
    path = tmp_path / "phases.json"
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


def test_they_are_as_the_file_has_them(tmp_path):
    found = given_phases(given(tmp_path, rows()), jump())
    assert [(list(each.feet), each.start_s, each.end_s) for each in found] == PHASES
    assert [each.name for each in found] == ["all feet stand", "flight", "all feet stand"]


def test_all_that_json_prints_may_be_given_back(tmp_path):
    found = llsrbm.repair(stored_plan())
    own = given_phases(given(tmp_path, found.as_dict()), jump())
    assert [each.feet for each in own] == [each.feet for each in found.phases]
    edges = [each.end_s for each in own]
    np.testing.assert_allclose(edges, [each.end_s for each in found.phases], atol=1e-9)


def test_rounded_times_meet(tmp_path):
    late = [(ALL, -0.0004, 0.7), ([], 0.7004, 1.05), (ALL, 1.0496, jump().time[-1] + 0.0004)]
    found = given_phases(given(tmp_path, rows(late)), jump())
    assert found[0].start_s == 0.0
    assert [each.start_s for each in found[1:]] == [each.end_s for each in found[:-1]]
    assert found[-1].end_s == jump().time[-1]


@pytest.mark.parametrize(
    ("content", "line"),
    [
        ({"status": "failed"}, "expected a list of phases, as `llsrbm repair --json` prints it"),
        ([3], "phase 1: expected name, feet, start_s and end_s, got int"),
        ([{"feet": [], "from": 0}], "phase 1: expected name, feet, start_s and end_s, got feet, f"),
        (rows([("FL", 0, 1)]), "phase 1: feet: expected a list of names, [] in a flight, got 'FL'"),
        (rows([(ALL, "0", 1)]), "phase 1: start_s: expected a number, s, got '0'"),
        (rows([(ALL, 0, True)]), "phase 1: end_s: expected a number, s, got True"),
        (rows([(["LF"], 0, 1)]), 'phase 1: no foot "LF"; expected FL, FR, RL, RR, or none'),
        (rows([(ALL, 0, 9)]), "phase 1: end_s 9: expected 0 to 1.860 s, the motion's own time"),
        (rows([(ALL, -1, 1)]), "phase 1: start_s -1: expected 0 to 1.860 s"),
        (rows([(ALL, 0.7, 0.6)]), "phase 1: end_s 0.6: expected 0.02 s or more after start_s, 0.7"),
        (
            rows([*PHASES[:2], (ALL, 1.2, 1.8)]),
            "phase 3: start_s 1.2: expected 1.05 s, where the phase before it ends",
        ),
        (
            rows([(ALL, 0, 0.5), (ALL, 0.5, 1)]),
            "phase 2: has the feet of the phase before it; expected others, or one phase",
        ),
        (rows([(ALL, 0, 1)]), "no phase is a flight; expected at least one with feet []"),
        (rows([([], 0, 1), (ALL, 1, 1.8)]), "no flight is between two phases on all feet"),
    ],
)
def test_wrong_ones_are_refused(tmp_path, content, line):
    path = given(tmp_path, content)
    with pytest.raises(llsrbm.InputError) as error:
        given_phases(path, jump())
    assert str(error.value).startswith(f"{path}: {line}")
    assert "\n" not in str(error.value)


def test_a_file_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(llsrbm.InputError, match="a list of phases"):
        given_phases(tmp_path / "none.json", jump())


def test_what_is_given_counts_and_not_what_is_found():
    # Two feet are said to leave late, which nothing in the motion shows.
    motion = jump()
    assert [each.feet for each in contact_phases(motion)] == [GO2.leg_names, (), GO2.leg_names]
    wanted = [
        ContactPhase("", GO2.leg_names, 0.0, 0.3),
        ContactPhase("", ("RL", "FL"), 0.3, 0.6),
        ContactPhase("", (), 0.6, 1.0),
        ContactPhase("", GO2.leg_names, 1.0, 1.5),
    ]
    found = llsrbm.repair(motion, phases=wanted)
    assert found.status == "repaired"
    assert found.plan.jump.type == "all - FL+RL - none - all"
    own = [set(phase.feet) for phase in found.plan.schedule]
    assert own == [set(each.feet) for each in wanted]


def test_a_jump_is_repaired_with_the_edges_that_are_given():
    motion = jump()
    first, flight, last = contact_phases(motion)
    early = flight.start_s - 0.03
    own = [replace(first, end_s=early), replace(flight, start_s=early), last]
    found = llsrbm.repair(motion, phases=own)
    assert found.status != "failed"
    assert found.phases[1].start_s == pytest.approx(early)
    assert found.phases[0].end_s == pytest.approx(early)
    whole = llsrbm.repair_clip(replace(motion, fps=50.0), phases=own)
    assert whole.phases == tuple(own)
