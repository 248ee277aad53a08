"""Every format that is registered keeps its promises, whatever it is."""

import json
import math
import re
import zipfile
from dataclasses import replace

import pytest

from llsrbm.errors import InputError
from llsrbm.formats import (
    FORMATS,
    Options,
    Purpose,
    availability,
    by_purpose,
    export,
    file_name,
    find,
)
from llsrbm.formats.pictures import video
from llsrbm.motion.sampling import resample
from llsrbm.motion.trajectory import load
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from llsrbm.robots.schema import robot_files
from tests.llsrbm.synthetic import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout

# What keeps formats that take long short, given to those that take it.
QUICK = {"fps": 10.0, "size": (64, 48)}
PICTURES = ("mp4", "gif", "html")
# Films take a process each that draws; `pictures/test_video.py` writes both.
without_films = pytest.mark.parametrize(
    "format_", [name for name in FORMATS if name not in ("mp4", "gif")], indirect=True
)


OF_OTHERS = {"odri-csv": "solo12"}  # formats that are not for Go2


def made_by_hand(name):
    """A real robot's joints with a motion made by hand, which no formula of a format minds."""
    robot = load_robot(name)
    made = synthetic_plan(intervals=4)
    legs = tuple(robot.file.legs)
    return replace(
        made,
        jump=replace(made.jump, robot=name),
        robot_parameters=robot.parameters(),
        joint_names=tuple(n for leg in legs for n in robot.joint_names if n.startswith(leg)),
    )


def simulated(plan):
    made = synthetic_rollout(plan)
    return resample(made, made.time[::20])


@pytest.fixture(scope="module")
def solo12(tmp_path_factory):
    """Its file, with legs that are called as their joints."""
    path = tmp_path_factory.mktemp("robots") / "solo12.toml"
    text = robot_files()["solo12"].read_text()
    path.write_text(text.replace("RL = ", "HL = ").replace("RR = ", "HR = "))
    return str(path)


@pytest.fixture(scope="module")
def go2s_rollout():
    return simulated(made_by_hand("go2"))


@pytest.fixture
def plan(format_, solo12):
    return made_by_hand(solo12 if format_.name in OF_OTHERS else "go2")


@pytest.fixture(params=FORMATS)
def format_(request):
    found = find(request.param)
    if found.extra is not None and found.extra.missing:
        pytest.skip(f"llsrbm[{found.extra.name}] is not installed")
    return found


def quick(*formats):
    return {name: value for name, value in QUICK.items() if any(name in f.options for f in formats)}


def test_its_description(format_):
    assert FORMATS[format_.name] is format_
    assert format_.title
    assert "\n" not in format_.title
    assert format_.conventions.strip()
    assert format_ in by_purpose()[format_.purpose]
    assert format_.suffix == "" or format_.suffix.startswith(".")
    assert set(format_.options) <= set(Options.__dataclass_fields__)


@without_films
def test_it_writes_what_it_holds_and_nothing_else(format_, plan, tmp_path):
    trajectory = simulated(plan)
    path = tmp_path / f"x{format_.suffix}"
    export(trajectory, path, format=format_.name, **quick(format_))
    assert path.is_dir() if format_.suffix == "" else path.is_file()
    left = [each for each in tmp_path.iterdir() if each != path]
    assert all(each.name.startswith(path.name) for each in left)
    for each in [*left, *tmp_path.rglob("*.json")]:
        if each.name.endswith("meta.json"):
            said = json.loads(each.read_text(), parse_constant=pytest.fail)
            assert said["request"] == trajectory.jump.as_dict()
    if format_.name not in PICTURES:  # once more, over what is there
        export(trajectory, path, format=format_.name, **quick(format_))
        assert sorted(tmp_path.iterdir()) == sorted([path, *left])


@without_films
def test_any_name_will_do(format_, plan, tmp_path):
    """Formats must not depend on what the file is called."""
    name = f"é {format_.name}"
    try:
        export(plan, tmp_path / name, format=format_.name, **quick(format_))
    except InputError as error:  # of a library that goes by the suffix
        assert "\n" not in str(error)
        assert format_.suffix in str(error)
        assert not list(tmp_path.iterdir())
    else:
        assert (tmp_path / name).exists()


def test_a_place_that_is_none(format_, plan, tmp_path):
    with pytest.raises(InputError) as caught:
        export(plan, tmp_path / "none" / "x", format=format_.name, **quick(format_))
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_a_rate_that_makes_no_sense(format_, plan, tmp_path):
    if "fps" not in format_.options:
        pytest.skip("has no rate")
    for fps in (0.0, -1.0, float("nan"), float("inf"), 1e9):
        with pytest.raises(InputError) as caught:
            export(plan, tmp_path / "x", format=format_.name, **(quick(format_) | {"fps": fps}))
        assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_options_that_it_does_not_take(format_, plan, tmp_path):
    given = {"fps": 10.0, "pad": 0.5, "order": "breadth-first", "size": (64, 48), "packed": True}
    for name, value in given.items():
        if name not in format_.options:
            with pytest.raises(InputError, match=f"{name}: is not for format"):
                export(plan, tmp_path / "x", format=format_.name, **{name: value})
    assert not list(tmp_path.iterdir())


def test_robots_that_are_gone(format_, plan, tmp_path):
    """Formats that need the robot say so; others do without."""
    parameters = {**plan.robot_parameters, "name": "a robot that there was"}
    jump = replace(plan.jump, robot="a robot that there was")
    gone = replace(plan, jump=jump, robot_parameters=parameters)
    try:
        export(gone, tmp_path / f"x{format_.suffix}", format=format_.name, **quick(format_))
    except InputError as error:
        assert 'no robot "a robot that there was"' in str(error)
        assert not list(tmp_path.iterdir())


def test_all_at_once_in_a_zip(go2s_rollout, tmp_path):
    rollout = go2s_rollout
    there = [each for each in FORMATS.values() if each.extra is None or not each.extra.missing]
    left = ("mp4", "gif", *OF_OTHERS)  # films are slow, and like html
    formats = [each for each in there if each.name not in left]
    names = [each.name for each in formats]
    path = tmp_path / file_name(rollout, names)
    export(rollout, path, format=names, **quick(*formats))
    assert [each.name for each in tmp_path.iterdir()] == [path.name]
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
        inside = archive.namelist()
        native = next(name for name in inside if name == f"{path.stem}.npz")
        (tmp_path / "x.npz").write_bytes(archive.read(native))
    assert load(tmp_path / "x.npz").jump == rollout.jump
    for each in formats:
        start = file_name(rollout, [each.name]).removesuffix("" if each.suffix else ".zip")
        assert any(name == start or name.startswith(f"{start}/") for name in inside), each.name


def test_a_files_name_says_what_it_is(go2s_rollout):
    plan = replace(go2s_rollout.plan, jump=Jump("go2", twist=math.pi / 2, forward=0.3))
    names = {name: file_name(plan, [name]) for name in FORMATS}
    assert names["npz"] == "go2_twist90_forward30cm.npz"
    assert names["csv"] == "go2_twist90_forward30cm.csv"
    assert names["unitree-csv"] == "go2_twist90_forward30cm_unitree.csv"
    assert names["mujoco"] == "go2_twist90_forward30cm_mujoco.zip"
    assert names["design"] == "go2_twist90_forward30cm.jump.json"
    assert len(set(names.values())) == len(names)
    assert not {file_name(go2s_rollout, [name]) for name in FORMATS} & set(names.values())
    assert file_name(plan, ["csv", "npz"]) == "go2_twist90_forward30cm.zip"
    assert file_name(plan, ["unitree-csv"], zipped=True) == "go2_twist90_forward30cm_unitree.zip"


def test_they_are_listed_by_what_they_are_for():
    assert [each.name for formats in by_purpose().values() for each in formats] == list(FORMATS)
    assert all(by_purpose().values())
    assert list(by_purpose()) == list(Purpose)


@pytest.mark.parametrize("robot", ["go2", "solo12", "slider", "anymal"])
@pytest.mark.parametrize("name", ["lowcmd", "odri-csv", "quad-sdk-csv", "csv"])
def test_what_is_not_available_is_refused_and_nothing_else(name, robot, tmp_path):
    reason = availability(find(name), load_robot(robot))
    own = {"lowcmd": ["go2"], "odri-csv": ["solo12"], "quad-sdk-csv": ["go2", "solo12"]}
    assert (not reason) == (robot in own.get(name, [robot]))
    if reason:
        with pytest.raises(InputError, match=re.escape(reason)):
            export(made_by_hand(robot), tmp_path / "x", format=name)
        assert not list(tmp_path.iterdir())


def test_a_machine_that_cannot_draw(monkeypatch):
    monkeypatch.setattr(video, "find_library", lambda _: None)
    video._check_machine.cache_clear()
    monkeypatch.setattr(video.sys, "platform", "linux")
    assert availability(find("gif")) == "no OpenGL without a screen"
    video._check_machine.cache_clear()
