"""Every format writes a motion of any schedule."""

import json

import mujoco
import numpy as np
import pandas as pd
import pytest

import llsrbm
from llsrbm.formats import FORMATS
from llsrbm.motion.trajectory import description
from llsrbm.motion.whole_body import whole_body_motion
from tests.llsrbm.formats.jumps import relabelled

# Films are of the same motion as other pictures, and one format is not for Go2.
QUICK = [name for name in FORMATS if name not in ("mp4", "gif", "odri-csv")]


@pytest.fixture(scope="module")
def plan():
    return relabelled("go2")


@pytest.mark.parametrize("name", QUICK)
def test_it_is_written(plan, tmp_path, name):
    path = tmp_path / f"motion{FORMATS[name].suffix}"
    llsrbm.export(plan, path, format=name)
    assert path.exists()


def test_a_table_names_the_phases_and_the_feet_that_stand(plan, tmp_path):
    llsrbm.export(plan, tmp_path / "x.csv", format="csv")
    table = pd.read_csv(tmp_path / "x.csv")
    named = "0 take-off, 1 flight, 2 first foot, 3 rebound, 4 flight, 5 landing"
    phase = table[f"phase [{named}]"]
    for number, leg in enumerate(plan.leg_names):
        contact = table[f"contact/{leg} [0 in the air, 1 touches]"]
        assert contact.tolist() == plan.schedule.stands[phase, number].tolist()


def test_contacts_are_a_foots_own(plan):
    motion = whole_body_motion(plan, 50, events=True)
    np.testing.assert_array_equal(motion.contact, plan.schedule.stands[motion.phase])
    first = motion.phase == 2
    assert motion.contact[first].tolist() == [[True, False, False, False]] * first.sum()


def test_the_description_says_which_feet_stand(plan):
    told = json.loads(json.dumps(description(plan)))["phases"]
    assert [phase["name"] for phase in told] == list(plan.schedule.names)
    assert told[2]["feet"] == [plan.leg_names[0]]
    assert [phase["start_s"] for phase in told] == pytest.approx(plan.phase_start[:-1])


def test_keyframes_of_each_flight(plan, tmp_path):
    llsrbm.export(plan, tmp_path / "folder", format="mujoco")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "folder" / "scene.xml"))
    assert [model.key(i).name for i in range(model.nkey)] == [
        "start", "lift-off", "touchdown", "lift-off-2", "touchdown-2", "end",
    ]  # fmt: skip
    edges = plan.phase_start
    assert model.key_time == pytest.approx(edges[[0, 1, 2, 4, 5, 6]])
