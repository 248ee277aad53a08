"""`llsrbm repair`: lines, one JSON object, exit status, the plan's file."""

import json

import numpy as np
import pytest

import llsrbm
from llsrbm import cli
from llsrbm.certificate import stated
from llsrbm.motion.whole_body import whole_body_motion
from llsrbm.repairing.joining import Join
from llsrbm.repairing.phases import ContactPhase
from llsrbm.repairing.result import ClipRepair, Moved, Repair
from tests.llsrbm.player.stages import stored_plan

MOVED = Moved(0.0123, 0.004, 0.002, (0.01, -0.02, 0.03))
LEGS = ("FL", "FR", "RL", "RR")
PHASES = (
    ContactPhase("take-off", LEGS, 0.0, 0.7),
    ContactPhase("flight", (), 0.7, 1.05),
    ContactPhase("landing", LEGS, 1.05, 1.8),
)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "motion.npz"
    llsrbm.export(stored_plan(), path, format="motion-npz")
    return path


@pytest.fixture
def answered(monkeypatch):
    """`llsrbm.repair` that gives the repair put into the list, and remembers what it was asked."""
    answers, asked = [], []

    def repair(motion, *, jump, phases, progress):
        asked.append((motion, jump, phases))
        print("a banner of a solver")
        return answers[0]

    monkeypatch.setattr(llsrbm, "repair", repair)
    repair.answers, repair.asked = answers, asked
    return repair


def repaired():
    plan = stored_plan()
    held = stated(plan)
    return Repair("repaired", held, held, MOVED, PHASES, plan, why="It is played faster.")


def test_json_is_one_object(answered, file, capfd):
    answered.answers.append(repaired())
    assert cli.main(["repair", str(file), "--robot", "go2", "--json"]) == 0
    found = json.loads(capfd.readouterr().out)
    assert found["status"] == "repaired"
    assert found["file"] == str(file)
    assert found["moved"]["joint_rms_rad"] == 0.0123
    assert found["phases"][1] == {"name": "flight", "feet": [], "start_s": 0.7, "end_s": 1.05}
    assert found["before"]["slip"]["holds"] is True
    assert found["after"].keys() == found["before"].keys()
    ((motion, jump, phases),) = answered.asked
    assert (motion.robot.name, jump, phases) == ("go2", 1, None)


def test_lines_are_for_people(answered, file, capsys):
    answered.answers.append(repaired())
    assert cli.main(["repair", str(file), "--robot", "go2"]) == 0
    out = capsys.readouterr().out
    assert "Result    repaired\n" in out
    assert "flight    0.70 to 1.05 s: no foot\n" in out
    assert "Moved     joints 0.012 rad (rms), base 0.4 cm (rms), landing 0.2 cm\n" in out
    assert "Remark    It is played faster.\n" in out


def test_the_plan_is_written(answered, file, tmp_path):
    answered.answers.append(repaired())
    out = tmp_path / "plan.npz"
    assert cli.main(["repair", str(file), "--robot", "go2", "--out", str(out)]) == 0
    assert llsrbm.load(out).feedback_gain is not None


def test_what_cannot_be_repaired_has_exit_status_1_and_a_line(answered, file, capfd, tmp_path):
    held = stated(stored_plan())
    answered.answers.append(Repair("failed", held, phases=PHASES, why="No foot leaves the ground."))
    out = tmp_path / "plan.npz"
    words = ["repair", str(file), "--robot", "go2", "--out", str(out), "--json"]
    assert cli.main(words) == 1
    stdout, err = capfd.readouterr()
    found = json.loads(stdout)
    assert found["after"] is None
    assert found["moved"] is None
    assert found["why"] == "No foot leaves the ground."
    assert f"llsrbm: {file}: No foot leaves the ground.\n" in err
    assert not out.exists()


def test_phases_are_handed_on(answered, file, tmp_path):
    answered.answers.append(repaired())
    given = tmp_path / "phases.json"
    assert cli.main(["repair", str(file), "--robot", "go2", "--phases", str(given)]) == 0
    assert answered.asked[0][2] == given


def test_wrong_phases_are_bad_input(refused, file, tmp_path):
    given = tmp_path / "phases.json"
    given.write_text('[{"name": "", "feet": ["LF"], "start_s": 0.0, "end_s": 0.7}]', "utf-8")
    line = refused("repair", str(file), "--robot", "go2", "--phases", str(given))
    assert f'{given}: phase 1: no foot "LF"; expected FL, FR, RL, RR, or none in a flight' in line


@pytest.fixture
def clipped(monkeypatch):
    """`llsrbm.repair_clip` that gives the repair put into the list."""
    answers = []

    def repair_clip(motion, *, phases, progress):
        print("a banner of a solver")
        return answers[0]

    monkeypatch.setattr(llsrbm, "repair_clip", repair_clip)
    return answers


def whole(status="repaired", why=""):
    held = stated(stored_plan())
    motion = whole_body_motion(stored_plan(), 50.0)
    joins = (Join(0.1, 0.4, 0.0012), Join(2.0, 2.3, 0.0034))
    jumps = (repaired(), Repair("failed", held, phases=PHASES, why="No way was found."))
    return ClipRepair(status, held, held, motion, jumps, ((0.4, 2.0),), joins, PHASES, why)


def test_a_whole_clip_is_written(clipped, file, tmp_path, capfd):
    clipped.append(whole())
    out = tmp_path / "clip.csv"
    words = ["repair", str(file), "--robot", "go2", "--clip", str(out), "--format", "unitree-csv"]
    assert cli.main([*words, "--json"]) == 0
    found = json.loads(capfd.readouterr().out)
    assert [jump["status"] for jump in found["jumps"]] == ["repaired", "failed"]
    assert found["plans"] == [{"start_s": 0.4, "end_s": 2.0}]
    assert found["joins"][1] == {"start_s": 2.0, "end_s": 2.3, "feet_m": 0.0034}
    assert found["after"].keys() == found["before"].keys()
    again = llsrbm.load_motion(out, robot="go2")
    np.testing.assert_allclose(again.qpos, whole().motion.qpos, atol=1e-8)


def test_a_clip_has_lines_for_people(clipped, file, tmp_path, capsys):
    clipped.append(whole())
    assert cli.main(["repair", str(file), "--robot", "go2", "--clip", str(tmp_path / "c.npz")]) == 0
    out = capsys.readouterr().out
    assert "Jump 1  0.00 to 1.80 s: repaired, joints 0.012 rad (rms), base 0.4 cm (rms)" in out
    assert "Jump 2  0.00 to 1.80 s: failed\n" in out
    assert "Joins   2, in which standing feet move 3.4 mm at most\n" in out


def test_a_clip_with_a_jump_that_stays_is_written_with_exit_status_1(
    clipped, file, tmp_path, capsys
):
    clipped.append(whole("failed", "The jump from 0.00 to 1.80 s stays as it is: no way."))
    out = tmp_path / "c.npz"
    assert cli.main(["repair", str(file), "--robot", "go2", "--clip", str(out)]) == 1
    assert f"llsrbm: {file}: The jump from 0.00 to 1.80 s stays" in capsys.readouterr().err
    assert out.exists()


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["--clip", "c.npz", "--jump", "2"], "--clip and --jump: expected one of them"),
        (["--clip", "c.npz", "--out", "p.npz"], "--clip and --out: expected one of them"),
        (["--format", "gmr-pkl"], "--format: is that of a whole clip; expected --clip OUT"),
        (["--clip", "c.npz", "--format", "npz"], 'format "npz" is of plans and simulations'),
        (["--clip", "c.npz", "--format", "nzp"], "nzp"),
    ],
)
def test_options_that_do_not_go_together_are_bad_input(refused, file, words, line):
    assert line in refused("repair", str(file), "--robot", "go2", *words)


def test_a_file_that_is_none_is_bad_input(refused, tmp_path):
    path = tmp_path / "text.csv"
    path.write_text("time,x\n0,1\n", encoding="utf-8")
    assert "begins with a header" in refused("repair", str(path), "--robot", "go2")


def test_a_pickle_of_no_motion_is_bad_input(refused, tmp_path):
    path = tmp_path / "motion.pkl"
    path.write_bytes(b"\x80\x04N.")
    assert "expected a dictionary with" in refused("repair", str(path), "--robot", "go2")


def test_another_robot_is_bad_input(refused, file):
    assert "expected the robot that moves in the file" in refused(
        "repair", str(file), "--robot", "anymal"
    )
