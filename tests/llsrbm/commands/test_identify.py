"""`llsrbm identify` and `llsrbm deploy --excite`: what they print, write and refuse."""

import json
import re
import tomllib

import pytest

from llsrbm.cli import main
from llsrbm.request.tables import with_tuples
from llsrbm.robots.drives.table import JointDrives
from tests.llsrbm.identification.synthetic import ARMATURE, DELAY, GO2, as_csv, synthetic_log


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    """All joints but those of the last leg move."""
    folder = tmp_path_factory.mktemp("logs")
    return as_csv(synthetic_log(10.0, moving=slice(0, 9)), folder / "hung.csv")


def test_it_prints_and_writes_what_it_finds(log, tmp_path, capfd):
    out = tmp_path / "drives.toml"
    picture = tmp_path / "drives.png"
    options = ["--robot", "go2", "--out", str(out), "--plot", str(picture), "--json"]
    assert main(["identify", str(log), *options]) == 0
    result = json.loads(capfd.readouterr().out)
    assert result["delay_s"] == pytest.approx(DELAY, abs=5e-5)
    assert result["base"] == "held"
    assert set(result["undetermined"]) == set(GO2.joint_names[9:])
    calf = result["joints"]["FL_calf_joint"]
    place = GO2.joint_names.index("FL_calf_joint")
    assert calf["armature"] == pytest.approx(ARMATURE[place], rel=0.02)
    assert {"friction", "friction_error", "damping", "damping_error", "armature_error"} < set(calf)
    assert picture.stat().st_size > 10_000

    text = out.read_text()
    assert "from hung.csv, for a robot file" in text
    assert str(tmp_path) not in text
    assert "Not in the log: RR_calf_joint, it does not move." in text
    drives = JointDrives.model_validate(with_tuples(tomllib.loads(text)["drives"]))
    assert drives.delay == pytest.approx(result["delay_s"], abs=1e-6)
    assert drives.joints["FL_calf_joint"].armature == pytest.approx(calf["armature"], rel=1e-5)
    assert drives.known.armature == drives.known.delay == "measured"


def test_its_lines(log, capsys):
    assert main(["identify", str(log), "--robot", "go2"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].endswith("taken as held and level, as the log has no inertial unit")
    assert re.match(r"delay +2\.\d\d \+- 0\.0\d ms", lines[1])
    assert re.search(r"^FL_calf_joint +0\.00\d+ \+- ", "\n".join(lines), re.MULTILINE)
    assert lines[-1].startswith("RR_calf_joint")
    assert lines[-1].endswith("not told: it does not move")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--robot", "go2", "--out", "{log}"], r"--out .*: expected a name that ends in \.toml"),
        (["--robot", "go2", "--out", "{there}"], r"--out .*: there is such a file; expected a new"),
        (
            ["--robot", "go2", "--plot", "a.bmp"],
            r"a\.bmp: expected a name that ends in one of \.pn",
        ),
        (["--robot", "anymal"], r"column q:FL_hip_joint: anymal has no such joint"),
    ],
)
def test_mistakes_are_told_in_one_line(options, message, log, tmp_path, refused):
    there = tmp_path / "robot.toml"
    there.write_text("name = 'mine'\n")
    filled = [each.format(log=log, there=there) for each in options]
    line = refused("identify", str(log), *filled)
    assert re.search(message, line), line
    assert there.read_text() == "name = 'mine'\n"


def test_a_dry_run_of_an_excitation(capfd):
    options = ["--excite", "--robot", "go2", "--hung", "--seconds", "6"]
    assert main(["deploy", *options, "--dry-run", "--json"]) == 0
    result = json.loads(capfd.readouterr().out)
    assert result["tier"] == "excitation"
    assert {each["name"]: each["duration_s"] for each in result["states"]}["jump"] == 6
    assert not any(result["commands"][0]["kp"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "deploy: no plan; expected PLAN.npz, or --excite"),
        (["--excite", "--hung"], "--excite: plays no plan; expected --robot R"),
        (["a.npz", "--excite", "--hung", "--robot", "go2"], "--excite: plays no plan"),
        (["--excite", "--robot", "go2"], "expected --hung, which says that the robot hangs"),
        (["--excite", "--robot", "go2", "--hung", "--seconds", "1"], "expected 5 to 600 s"),
    ],
)
def test_an_excitation_is_asked_for_in_full(arguments, message, refused):
    assert message in refused("deploy", *arguments)
