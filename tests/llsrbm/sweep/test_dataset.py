"""Data sets of strict jumps, opened by processes that do not know this project."""

import json
import shutil
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import llsrbm
from llsrbm.errors import InputError
from llsrbm.robots import load_robot
from llsrbm.robots.drives.stated import known_drives
from llsrbm.sweep import dataset, jump
from llsrbm.sweep.dataset import make_dataset
from tests.llsrbm.sweep.specs import filled

SPEC = """
title = "two jumps, two seeds"
draft = true
robots = ["anymal"]
axes = { twist = [0.0, 0.5], forward = [0.1] }
simulate = { seeds = [1, 2] }
"""


@pytest.fixture(scope="module")
def sweep(tmp_path_factory, computed_once):
    path = tmp_path_factory.mktemp("sweeps") / "sweep"
    filled(path, range(2), SPEC)
    assert pq.read_table(path / "jumps.parquet")["strict"].to_pylist() == [True] * 4
    return path


@pytest.fixture(scope="module", autouse=True)
def computed_once():
    """Plans and rollouts, which come out the same, are computed once for all of them."""
    plans, rollouts = {}, {}
    plan_of, rollout_of = dataset.plan_of, dataset.rollout_of

    def plan(spec, point):
        if point.jump not in plans:
            plans[point.jump] = plan_of(spec, point)
        return plans[point.jump]

    def rollout(spec, point, plan, seed):
        if (point.jump, seed) not in rollouts:
            rollouts[point.jump, seed] = rollout_of(spec, point, plan, seed)
        return rollouts[point.jump, seed]

    with pytest.MonkeyPatch.context() as patch:
        for module in (jump, dataset):
            patch.setattr(module, "plan_of", plan)
            patch.setattr(module, "rollout_of", rollout)
        yield


@pytest.fixture(scope="module")
def lerobot(sweep, tmp_path_factory):
    out = tmp_path_factory.mktemp("lerobot")
    made = make_dataset(sweep, out, "lerobot")
    assert (made.motions, made.computed, made.left_out) == (4, 4, ())
    return out


@pytest.fixture(scope="module")
def plans(sweep, tmp_path_factory):
    out = tmp_path_factory.mktemp("plans")
    made = make_dataset(sweep, out, "motion-npz", source="plan", fps=100)
    assert (made.motions, made.computed) == (2, 2)
    return out


def changed(sweep, path, **columns):
    """A copy of a sweep with other values in its table."""
    shutil.copytree(sweep, path)
    table = pq.read_table(path / "jumps.parquet")
    for name, values in columns.items():
        at = table.schema.get_field_index(name)
        table = table.set_column(at, table.field(at), [pa.array(values, table.field(at).type)])
    pq.write_table(table, next((path / "jumps.parquet").iterdir()))
    return path


def elsewhere(script, *arguments):
    """What a script prints in a process that must not load this project."""
    guarded = f"{script}\nimport sys\nassert not [m for m in sys.modules if 'llsrbm' in m]\n"
    done = subprocess.run(
        [sys.executable, "-I", "-c", guarded, *map(str, arguments)],
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


def test_pandas_opens_the_index(plans):
    script = """
import sys, json, pandas
parquet = pandas.read_parquet(sys.argv[1] + "/index.parquet")
csv = pandas.read_csv(sys.argv[1] + "/index.csv")
assert list(parquet.columns) == list(csv.columns)
names = ("file", "jump", "twist", "robot", "licence", "version")
print(json.dumps({name: csv[name].tolist() for name in names}))
"""
    index = elsewhere(script, plans)
    assert index["twist"] == [0.0, 0.5]
    assert index["jump"] == [0, 1]
    assert index["robot"] == ["anymal"] * 2
    assert all((plans / file).is_file() for file in index["file"])
    assert all(text.startswith("BSD-3-Clause") for text in index["licence"])


def test_lerobot_by_pandas(lerobot, sweep):
    script = """
import sys, json, glob, pandas
root = sys.argv[1]
info = json.load(open(f"{root}/meta/info.json"))
stats = json.load(open(f"{root}/meta/stats.json"))
tasks = pandas.read_parquet(f"{root}/meta/tasks.parquet")
episodes = pandas.read_parquet(glob.glob(f"{root}/meta/episodes/*/*.parquet")[0])
data = pandas.read_parquet(f"{root}/" + info["data_path"].format(chunk_index=0, file_index=0))
for name, feature in info["features"].items():
    shapes = {len(v) for v in data[name]} if feature["shape"] != [1] else {1}
    assert shapes == set(feature["shape"]), (name, shapes)
    assert feature["names"] is None or len(feature["names"]) == feature["shape"][0]
    assert len(stats[name]["mean"]) == feature["shape"][0]
    assert stats[name]["count"] == [len(data)]
for row in episodes.itertuples():
    own = data[row.dataset_from_index:row.dataset_to_index]
    assert (own["episode_index"] == row.episode_index).all()
    assert list(own["frame_index"]) == list(range(row.length))
    assert (tasks.iloc[own["task_index"]].index == row.tasks[0]).all()
assert (data["index"] == range(len(data))).all()
states = [list(map(float, v)) for v in data["observation.state"]]
mean = [sum(column) / len(states) for column in zip(*states)]
assert max(abs(a - b) for a, b in zip(mean, stats["observation.state"]["mean"])) < 1e-5
first = data[data["episode_index"] == 0]
print(json.dumps({
    "info": info, "tasks": list(tasks.index), "task_index": tasks["task_index"].tolist(),
    "lengths": episodes["length"].tolist(),
    "state": [list(map(float, v)) for v in first["observation.state"]],
    "action": [list(map(float, v)) for v in first["action"]],
    "timestamp": first["timestamp"].astype(float).tolist(),
}))
"""
    told = elsewhere(script, lerobot)
    info = told["info"]
    assert info["codebase_version"] == "v3.0"
    assert info["robot_type"] == "anymal"
    assert (info["fps"], info["total_episodes"]) == (50, 4)
    assert info["total_frames"] == sum(told["lengths"])
    assert info["total_tasks"] == 2
    assert told["tasks"][1].startswith("jump: twist 29 deg, forward 0.10 m")
    assert told["task_index"] == [0, 1]

    seed = pq.read_table(sweep / "jumps.parquet")["seed"][0].as_py()
    plan = llsrbm.plan(llsrbm.Jump(robot="anymal", forward=0.1), draft=True)
    rollout = llsrbm.simulate(plan, seed=seed)
    state = np.array(told["state"])
    time = np.array(told["timestamp"])
    np.testing.assert_allclose(np.diff(time), 0.02, atol=1e-6)
    frame = 20
    qpos = rollout.qpos[np.searchsorted(rollout.time, time[frame])]
    # Another start of the solver ends a little elsewhere.
    np.testing.assert_allclose(state[frame, :3], qpos[:3], atol=0.01)
    joints = len(rollout.joint_names)
    assert info["features"]["action"]["names"][0] == f"{rollout.joint_names[0]}.pos"
    action = np.array(told["action"])
    np.testing.assert_array_equal(action[:-1], state[1:, 7 : 7 + joints])


def test_it_says_with_which_drives_its_robots_moved(plans):
    robot = load_robot("anymal")
    drives = json.loads((plans / "dataset.json").read_text())["drives"]["anymal"]
    assert drives["joints"] == list(robot.joint_names)
    assert drives["armature"] == robot.armature.tolist()
    assert drives["delay"] == robot.drive_delay
    assert drives["known"] == known_drives(robot.file)


def test_goes_on_where_it_was(sweep, tmp_path, monkeypatch):
    whole = tmp_path / "whole"
    make_dataset(sweep, whole, "unitree-csv", source="plan")
    calls = []
    plan_of = dataset.plan_of

    def cut_off(spec, point):
        calls.append(point.number)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return plan_of(spec, point)

    monkeypatch.setattr(dataset, "plan_of", cut_off)
    out = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt):
        make_dataset(sweep, out, "unitree-csv", source="plan")
    assert not (out / "index.parquet").exists()
    made = make_dataset(sweep, out, "unitree-csv", source="plan")
    assert (made.motions, made.computed) == (2, 1)
    assert make_dataset(sweep, out, "unitree-csv", source="plan").computed == 0
    names = sorted(path.relative_to(whole) for path in whole.rglob("*.csv"))
    assert names == sorted(path.relative_to(out) for path in out.rglob("*.csv"))
    for name in names:
        assert (whole / name).read_bytes() == (out / name).read_bytes()


def test_what_is_not_strict_any_more_is_left_out(sweep, tmp_path, monkeypatch):
    rollout_of = dataset.rollout_of

    def other(spec, point, plan, seed):
        found = rollout_of(spec, point, plan, seed)
        strict = found.outcome.strict and point.number != 0
        return replace(found, outcome=replace(found.outcome, strict=strict))

    monkeypatch.setattr(dataset, "rollout_of", other)
    made = make_dataset(sweep, tmp_path / "out", "npz", limit=3)
    assert (made.motions, made.left_out) == (1, (0, 1))
    assert llsrbm.load(next((tmp_path / "out" / "motions").glob("*.npz"))).outcome.strict


def test_plans_are_of_jumps_that_are_strict_with_every_seed(sweep, tmp_path):
    path = changed(sweep, tmp_path / "sweep", strict=[True, False, True, True])
    made = make_dataset(path, tmp_path / "out", "design", source="plan")
    assert made.motions == 1
    assert pq.read_table(made.index)["twist"].to_pylist() == [0.5]


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"format_name": "bvh"}, 'no format of data sets "bvh"; valid: npz'),
        ({"robot": "go2"}, "nothing of robot go2 is in it; expected anymal"),
        ({"source": "both"}, 'source: expected rollout or plan, got "both"'),
        ({"limit": 0}, "limit: expected 1 or more motions, got 0"),
        ({"fps": -1.0}, "frames per second: expected 0 < fps"),
        ({"format_name": "npz", "fps": 50.0}, 'fps: format "npz" has no rate; expected no --fps'),
        ({"fps": 29.97}, "fps: LeRobot takes whole rates, got 29.97"),
    ],
)
def test_bad_requests(sweep, tmp_path, asked, message):
    asked = {"format_name": "lerobot", **asked}
    with pytest.raises(InputError) as error:
        make_dataset(sweep, tmp_path / "out", **asked)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_sweep_under_way(sweep, tmp_path):
    shutil.copytree(sweep, tmp_path / "sweep")
    (part,) = (tmp_path / "sweep" / "jumps.parquet").iterdir()
    pq.write_table(pq.read_table(part).slice(0, 2), part)
    with pytest.raises(InputError, match=r"the sweep is not done: 2 of 4 rows"):
        make_dataset(tmp_path / "sweep", tmp_path / "out", "npz")


def test_another_version(sweep, tmp_path):
    path = changed(sweep, tmp_path / "sweep")
    stated = json.loads((path / "sweep.json").read_text())
    stated["origin"]["llsrbm"] = "0.0.1"
    (path / "sweep.json").write_text(json.dumps(stated))
    with pytest.raises(InputError, match=r"the sweep is of llsrbm 0\.0\.1, here is"):
        make_dataset(path, tmp_path / "out", "npz")


def test_a_folder_of_something_else(sweep, plans, tmp_path):
    (tmp_path / "mine").write_text("")
    with pytest.raises(InputError, match="holds mine, and no data set"):
        make_dataset(sweep, tmp_path, "npz")
    with pytest.raises(InputError, match="holds another data set"):
        make_dataset(sweep, plans, "npz")
