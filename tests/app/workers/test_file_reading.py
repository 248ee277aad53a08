"""What a file holds, or one line that says why it cannot be opened."""

import json
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest

from app.workers import file_reading
from app.workers.file_reading import LARGEST_UNPACKED, MOST_GROWTH, differing, open_file
from app.workers.opened_file import States
from llsrbm.errors import Error
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot, names
from tests.app.damaged import Damaged
from tests.app.planners import turning_states
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout

DAMAGED = Damaged()
ROBOTS = ", ".join(names())
PLAN = synthetic_plan(Jump(twist=1.0))


def content(trajectory, tmp_path):
    trajectory.save(tmp_path / "file.npz")
    return (tmp_path / "file.npz").read_bytes()


def refusal(name, data):
    with pytest.raises(Error) as refused:
        open_file(name, data, "anymal")
    line = str(refused.value)
    assert "\n" not in line
    assert "/tmp" not in line
    assert len(line) < 1000
    return line


def changed(tmp_path, **changes):
    """A plan's file with other arrays; `meta` as a function of what was there."""
    with np.load(tmp_path / "file.npz") as archive:
        arrays = {key: archive[key] for key in archive.files}
    meta = changes.pop("meta", None)
    if meta is not None:
        table = json.loads(str(arrays["meta"]))
        meta(table)
        arrays["meta"] = np.array(json.dumps(table))
    np.savez_compressed(tmp_path / "changed.npz", **arrays | changes)
    return (tmp_path / "changed.npz").read_bytes()


@pytest.mark.parametrize(
    ("number", "kind"), [(0, Plan), (1, Rollout), (2, Design)], ids=["plan", "rollout", "design"]
)
def test_what_is_good_is_opened(number, kind):
    name, data = DAMAGED.good[number]
    opened = open_file(name, data, "go2")
    assert isinstance(opened.holds, kind)
    assert (opened.name, opened.robot, opened.remarks) == (name, "anymal", ())


@pytest.mark.parametrize("seed", range(250))
def test_whatever_is_damaged_is_opened_or_refused_in_a_line(seed):
    name, data = DAMAGED.damaged(seed)
    try:
        open_file(name, data, "anymal", 30.0)
    except Error as error:
        line = str(error)
        assert "\n" not in line
        assert "/tmp" not in line
        assert len(line) < 1000


def test_a_path_in_place_of_a_robot_is_never_looked_for(tmp_path, monkeypatch):
    looked = []
    for module in ("llsrbm.robots", "llsrbm.motion.robot"):
        monkeypatch.setattr(f"{module}.load_robot", lambda name: looked.append(name))
    content(PLAN, tmp_path)

    def ask(meta):
        meta["request"]["robot"] = "/dev/zero"

    line = refusal("a.npz", changed(tmp_path, meta=ask))
    assert line.startswith(f"a.npz: request.robot: expected one of {ROBOTS}, got '/dev/z")

    def name_it(meta):
        meta["robot_parameters"]["name"] = "/dev/zero"

    line = refusal("a.npz", changed(tmp_path, meta=name_it))
    assert line.startswith("a.npz: robot_parameters.name: expected anymal, got '/dev/zero'")
    assert looked == []


def test_a_model_is_one_of_the_pages(tmp_path):
    content(PLAN, tmp_path)
    line = refusal("a.npz", changed(tmp_path, meta=lambda m: m["request"].update(model="../x")))
    assert line.startswith("a.npz: request.model: expected one of srbm, llsrbm, llsrbm-plus, got")


def test_joints_have_to_be_the_robots(tmp_path):
    wrong = replace(PLAN, joint_names=("a", *PLAN.joint_names[1:]))
    line = refusal("a.npz", content(wrong, tmp_path))
    assert "expected its 12 joints and 4 feet" in line


def test_a_motion_is_short_enough_to_be_drawn(tmp_path):
    long = replace(PLAN, time=PLAN.time * 60)
    line = refusal("a.npz", content(long, tmp_path))
    assert line == "a.npz: 49 instants in 78 s; at most 20000 in 60 s can be shown"


def test_what_unpacks_to_too_much_is_not_unpacked(tmp_path):
    content(PLAN, tmp_path)
    data = changed(tmp_path, bomb=np.zeros(LARGEST_UNPACKED, dtype=np.uint8))
    assert len(data) < 200_000
    assert "bytes of arrays" in refusal("a.npz", data)


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("com", 2e3, "com: expected numbers up to 1000, got 2000"),
        ("joint_position", 1e8, "joint_position: expected numbers up to 1e+07, got 1e+08"),
        ("inertia", -1.0, "inertia: expected positive moments, got -"),
    ],
)
def test_numbers_that_nothing_could_draw_are_refused(tmp_path, key, value, told):
    values = np.full_like(getattr(PLAN, key), value)
    assert refusal("a.npz", content(replace(PLAN, **{key: values}), tmp_path)).startswith(
        f"a.npz: {told}"
    )


def test_a_simulation_and_its_plan_are_of_one_robot(tmp_path):
    rollout = replace(synthetic_rollout(PLAN), plan=synthetic_plan(Jump(robot="go2")))
    line = refusal("a.npz", content(rollout, tmp_path))
    assert "is of another jump or robot than the rollout itself" in line


@pytest.fixture
def foreign(monkeypatch):
    """Files that were read as another tool's: ending, content, robot, rate."""
    asked = []

    def load_motion(path, robot, fps):
        asked.append((path.suffix, path.read_bytes(), robot, fps))
        return turning_states(robot).motion()

    monkeypatch.setattr("app.workers.file_reading.load_motion", load_motion)
    return asked


def test_another_tools_file_is_read_as_such(foreign):
    opened = open_file("Dance 1.CSV", b"1,2", "slider", 50.0)
    assert foreign == [(".csv", b"1,2", "slider", 50.0)]
    assert (opened.name, opened.robot) == ("Dance 1.CSV", "slider")
    again = pickle.loads(pickle.dumps(opened.holds)).motion()
    assert again.robot is load_robot("slider")
    assert again.com.tolist() == turning_states("slider").motion().com.tolist()


def test_another_tools_npz_is_told_from_ours(foreign, tmp_path):
    np.savez(tmp_path / "other.npz", qpos=np.zeros((3, 19)))
    data = (tmp_path / "other.npz").read_bytes()
    assert isinstance(open_file("other.npz", data, "anymal").holds, States)
    assert [suffix for suffix, *_ in foreign] == [".npz"]


def test_a_foreign_motion_is_checked_too(monkeypatch):
    motion = turning_states("anymal").motion()
    far = replace(motion, base_position=motion.base_position + 1e5)
    monkeypatch.setattr("app.workers.file_reading.load_motion", lambda *_, **__: far)
    assert refusal("far.csv", b"1").startswith("far.csv: base_position: expected numbers up to")


def test_what_nothing_foresaw_is_a_line_too(monkeypatch):
    def fail(*_, **__):
        raise ZeroDivisionError("of\nsomething")

    monkeypatch.setattr(file_reading, "_show", fail)
    line = refusal(*DAMAGED.good[0])
    assert line == "plan.npz: cannot be opened (ZeroDivisionError: of something)"


def test_a_file_that_grows_when_it_is_read_is_given_up(monkeypatch):
    """Whatever its format; what the process does next has its memory again."""

    def read(path, robot, fps):
        return np.ones(2 * MOST_GROWTH // 8)

    monkeypatch.setattr(file_reading, "load_motion", read)
    line = refusal("motion.csv", b"1,2\n")
    assert line == "motion.csv: reading it takes more than 400 MB of memory"
    assert len(np.ones(2 * MOST_GROWTH // 8)) > 0


def test_a_name_is_one_printable_line():
    line = refusal("\n\x00" + "x" * 500 + ".npz", b"PK")
    assert line.startswith("??xxx")
    assert len(line) < 300


def test_numbers_of_two_robots_are_compared_within_rounding():
    now = load_robot("anymal").parameters()
    near = now | {"mass": now["mass"] * (1 + 1e-9)}
    assert differing(near, json.loads(json.dumps(now))) == []
    limits = now["limits"] | {"clearance": 0.0, "nosuch": 1}
    other = now | {"limits": limits, "mass": math.inf, "com": "far"}
    assert differing(other, now) == ["com", "limits.clearance", "limits.nosuch", "mass"]
