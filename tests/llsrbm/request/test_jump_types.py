"""Jump types: the presets on every robot, files of one's own, and what is said of wrong ones."""

import math
import os

import pytest

from llsrbm.errors import InputError
from llsrbm.request import jump_types
from llsrbm.request.jump import PLAIN, Jump
from llsrbm.request.jump_types import load_type, schedule_of, with_defaults
from llsrbm.request.schedule import together
from llsrbm.robots import load_robot
from llsrbm.robots import names as robot_names

FLIP = """
title = "Mine"
summary = "a flip of my own"
asks = ["pitch", "roll"]

[defaults]
pitch = -6.283185307179586

[limits]
flight_max = 0.9

[[phase]]
name = "take-off"
feet = "all"
time = "takeoff"

[[phase]]
name = "flight"
feet = "none"
time = "flight"

[[phase]]
name = "landing"
feet = "all"
time = "landing"
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(FLIP)
    return path


def refusal(path):
    with pytest.raises(InputError) as caught:
        load_type(str(path))
    text = str(caught.value)
    assert text.isprintable()
    assert text.startswith(f"{path}: ")
    return text.removeprefix(f"{path}: ")


def test_the_presets():
    found = jump_types.names()
    assert next(iter(found)) == PLAIN == Jump().type
    assert {"together", "rear-last", "flip", "run-up", "hops"} <= set(found)
    assert len({kind.title for kind in found.values()}) == len(found)


@pytest.mark.parametrize(("turns", "pivot", "lead"), [(-1, "R", "F"), (1, "F", "R")])
def test_a_flip_is_caught_by_the_feet_that_left_first(turns, pivot, lead):
    robot = load_robot("go2")
    schedule = schedule_of(Jump("go2", type="caught-flip", pitch=turns * math.tau), robot)
    feet = [{name[0] for name in phase.feet} for phase in schedule]
    assert feet == [{"F", "R"}, {pivot}, set(), {lead}, {"F", "R"}]
    assert schedule.is_caught
    assert not schedule_of(Jump("go2", type="flip", pitch=math.tau), robot).is_caught


def test_what_does_not_turn_over_has_no_pivot():
    with pytest.raises(InputError, match='"pivot" are feet of a body that turns over; expected a'):
        schedule_of(Jump("go2", type="caught-flip"), load_robot("go2"))


@pytest.mark.parametrize("robot", robot_names())
def test_together_is_the_schedule_of_files_without_one(robot):
    loaded = load_robot(robot)
    made = schedule_of(Jump(robot), loaded)
    assert made == together(tuple(leg.name for leg in loaded.legs))


@pytest.mark.parametrize("name", jump_types.names())
def test_every_preset_has_a_schedule_on_the_quadrupeds(name):
    for robot in ("anymal", "go2"):
        jump = with_defaults(Jump(robot, type=name))
        made = schedule_of(jump, load_robot(robot))
        jumps = 2 if jump_types.names()[name].passes else jump.hops
        assert len(made.flights) == jumps
        assert made.places == jumps


def test_front_and_hind_feet():
    made = schedule_of(Jump(type="rear-last"), load_robot("anymal"))
    assert [made.standing_words(k) for k in range(4)] == [
        "all feet", "LH, RH", "no foot", "all feet",
    ]  # fmt: skip


def test_a_biped_has_no_hind_feet():
    with pytest.raises(InputError, match=r'phase "rear push": .* has no .hind. feet; expected one'):
        schedule_of(Jump("slider", type="rear-last"), load_robot("slider"))


@pytest.mark.parametrize("hops", [1, 2, 5])
def test_hops_repeat_what_is_between_them(hops):
    made = schedule_of(Jump(type="hops", hops=hops), load_robot("go2"))
    assert made.names == ("take-off", *("flight", "rebound") * (hops - 1), "flight", "landing")
    assert [phase.place for phase in made if phase.feet] == list(range(hops + 1))


def test_a_file_is_read_again_when_it_has_changed(file):
    assert load_type(str(file)).title == "Mine"
    file.write_text(FLIP.replace("Mine", "Ours"))
    os.utime(file, ns=(1, 1))
    assert load_type(str(file)).title == "Ours"


def test_names_of_legs(file):
    file.write_text(
        FLIP.replace('feet = "none"', "feet = []", 1).replace(
            '[[phase]]\nname = "flight"',
            '[[phase]]\nname = "push"\nfeet = ["RL"]\ntime = [0.1, 0.3]\n'
            '[[phase]]\nname = "flight"',
        )
    )
    made = load_type(str(file)).schedule(load_robot("go2"))
    assert made[1].feet == ("RL",)
    with pytest.raises(InputError, match='unknown foot "RL"; the feet are LF, RF, LH, RH'):
        load_type(str(file)).schedule(load_robot("anymal"))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "title",
            "titel",
            'unknown key "titel"; did you mean "title"? valid: title, summary, asks',
        ),
        ('title = "Mine"', "", 'missing key "title"; expected: title, summary, asks, defaults'),
        ('feet = "none"', 'feets = "none"', 'unknown key "phase.2.feets"; did you mean "feet"?'),
        ('feet = "none"', "", 'missing key "phase.2.feet"; expected: name, feet, time, share'),
        ('feet = "none"', "feet = 3", "phase.2.feet: expected all, none, front, hind, left, right"),
        ('"Mine"', '"a\\u001bb"', "title: expected one line of printable text, got"),
        ('["pitch", "roll"]', '["twist"]', "asks: expected some of roll, pitch, speed, end_speed"),
        ("pitch = -", "speed = -", "defaults.speed: the type asks for pitch, roll; expected one"),
        ("-6.283", "-1.283", "pitch: -73.5211 deg; expected whole turns: -360, 0 or 360 deg"),
        ("-6.283185307179586", '"x"', 'defaults.pitch: input should be a valid number, got "x"'),
        ("[limits]", "[limits", "not a TOML file: Expected ']' at the end of a table declaration"),
        ("[limits]", "x = " + "[" * 5000, "not a TOML file: nested too deeply"),
        ("[limits]", "#" * 1_000_000, "too large for a jump type; expected at most 1000000 bytes"),
    ],
)
def test_a_wrong_file_is_one_line(file, old, new, said):
    file.write_text(FLIP.replace(old, new, 1))
    assert refusal(file).startswith(said)


HURDLE = FLIP.replace("[limits]", "[obstacle]\nfrom = 0.1\nto = 0.2\nheight = 0.12\n\n[limits]")


def test_an_obstacle(file):
    file.write_text(HURDLE)
    kind = load_type(str(file))
    assert (kind.obstacle.near, kind.obstacle.far, kind.obstacle.height) == (0.1, 0.2, 0.12)
    assert kind.clears


def test_the_ground_alone_can_be_cleared(file):
    file.write_text(FLIP.replace("asks", "clears_ground = true\nasks"))
    assert load_type(str(file)).clears


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("from", "form", 'unknown key "obstacle.form"; did you mean "from"? valid: from, to, hei'),
        ("to = 0.2\n", "", 'obstacle.to: expected it, or "gap" in "asks", and not both'),
        ("to = 0.2", "to = 0.05", "obstacle: it goes from 0.1 to 0.05 m; expected an end that is"),
        ("height = 0.12", "height = 0", "obstacle: height 0 m; expected a hurdle of 0.01 to 1 m"),
        ("height = 0.12", "height = -3", "obstacle: height -3 m; expected a hurdle of 0.01 to 1"),
        ("height = 0.12", "height = nan", "obstacle.height: input should be a finite number, got"),
        ("from = 0.1", 'from = "x"', 'obstacle.from: input should be a valid number, got "x"'),
    ],
)
def test_a_wrong_obstacle_is_one_line(file, old, new, said):
    file.write_text(HURDLE.replace(old, new, 1))
    assert refusal(file).startswith(said)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        (
            "flipp",
            'unknown jump type "flipp"; did you mean "flip"? valid: barrel-roll, caught-flip, ',
        ),
        ("../flip", 'unknown jump type "../flip"; '),
        ("none/such.toml", "none/such.toml: no such file; expected a jump type"),
        ("a\0b.toml", "a?b.toml: no such file"),
        ("/dev/zero", 'unknown jump type "/dev/zero"; '),
    ],
)
def test_no_such_type(name, said):
    with pytest.raises(InputError) as caught:
        load_type(name)
    assert said in str(caught.value)


class TestDefaults:
    def test_of_a_silent_request(self):
        assert with_defaults(Jump(type="flip")).pitch == -math.tau
        assert with_defaults(Jump(type="hops")).hops == 2
        assert with_defaults(Jump(twist=1.0)) == Jump(twist=1.0)

    def test_what_was_asked_for_stays(self):
        asked = Jump(type="hops", hops=3, forward=0.2)
        assert with_defaults(asked, ["hops"]) == asked
        run_up = with_defaults(Jump(type="run-up", end_speed=0.3), ["end_speed"])
        assert (run_up.speed, run_up.end_speed) == (0.5, 0.3)

    def test_a_roll_is_no_back_flip_as_well(self):
        rolled = with_defaults(Jump(type="flip", roll=math.tau), ["roll"])
        assert (rolled.roll, rolled.pitch) == (math.tau, 0.0)

    def test_what_another_type_asked_for_is_gone(self):
        flip = with_defaults(Jump(type="flip", height=0.1))
        hops = with_defaults(Jump(**flip.as_dict() | {"type": "hops"}))
        assert hops == Jump(type="hops", hops=2, height=0.1)
