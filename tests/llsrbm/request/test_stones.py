"""Landing places of single feet as a jump, a file and the command line state them."""

import json

import pytest

from llsrbm.commands.options import in_words
from llsrbm.errors import InputError
from llsrbm.request.design import Design, dump_design, load_design
from llsrbm.request.jump import Jump
from llsrbm.request.stones import Stone, parse_stone

STONES = (Stone("LF", 0.04, 0.02), Stone("RH", -0.03, 0.0, 0.02))


@pytest.mark.parametrize(
    "given",
    [
        STONES,
        [["RH", -0.03, 0, 0.02], ["LF", 0.04, 0.02]],
        {"LF": (0.04, 0.02), "RH": [-0.03, 0.0, 0.02]},
        (*STONES, ("RF", 0.0, 0.0, 0.0)),
        tuple(map(parse_stone, ("LF,0.04,0.02", " RH,-0.03,0,0.02"))),
    ],
)
def test_stones_are_the_same_however_they_are_given(given):
    jump = Jump(stones=given)
    assert jump.stones == STONES
    assert hash(jump) == hash(Jump(stones=STONES))
    assert Jump(**jump.as_dict()) == jump
    assert jump.as_dict()["stones"] == {"LF": [0.04, 0.02, 0.0], "RH": [-0.03, 0.0, 0.02]}


def test_a_design_has_them_and_without_them_says_nothing():
    jump = Jump(twist=0.3, stones=STONES)
    text = dump_design(Design(jump))
    assert json.loads(text)["jump"]["stones"] == jump.as_dict()["stones"]
    assert load_design(text.encode()).jump == jump
    assert "stones" not in dump_design(Design(Jump(twist=0.3)))
    assert "stones" not in Jump().as_dict()


@pytest.mark.parametrize(
    ("stones", "reason"),
    [
        ({"LF": (0.1,)}, "stones: expected LEG,DX,DY"),
        ({"LF": 0.1}, "expected LEG,DX,DY"),
        ({"LF": "0.1"}, "expected LEG,DX,DY"),
        ({"LF": (0.1, float("nan"))}, "expected LEG,DX,DY"),
        ({"LF": (0.1, True)}, "expected LEG,DX,DY"),
        ({3: (0.1, 0.1)}, "expected LEG,DX,DY"),
        ("LF,0.1,0.1", "expected LEG,DX,DY"),
        (3.0, "expected LEG,DX,DY"),
        ([3.0], "expected LEG,DX,DY"),
        ({"LF": (1.1, 0.0)}, "stones: LF: expected at most 1 m"),
        ({"LF": (0.0, 0.0, -0.01)}, "none below the surface"),
        ([("LF", 0.1, 0.0), ("LF", 0.0, 0.1)], "LF is named twice"),
        ([(f"leg {k}", 0.1, 0.0) for k in range(101)], "at most 100"),
    ],
)
def test_what_is_none(stones, reason):
    with pytest.raises(InputError, match=reason):
        Jump(stones=stones)


@pytest.mark.parametrize("text", ["LF", "LF,a,0", "0.1,0.1", "LF,0.1,0.1,0.1,0.1", ""])
def test_a_line_that_is_none(text):
    with pytest.raises(InputError, match="stone: expected LEG,DX,DY"):
        parse_stone(text)


def test_in_words():
    assert in_words(Jump(stones=STONES[:1])).endswith("LF 0.040, 0.020, 0.000 m aside")
