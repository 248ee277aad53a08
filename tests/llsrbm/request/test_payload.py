"""A payload as a jump, a file and the command line state it."""

import pytest

from llsrbm.errors import InputError
from llsrbm.request.design import Design, dump_design, load_design
from llsrbm.request.jump import Jump, parse_payload


@pytest.mark.parametrize(
    ("text", "payload"),
    [
        ("3", (3.0, 0.0, 0.0, 0.0)),
        ("2.5,0.1,-0.02,0.05", (2.5, 0.1, -0.02, 0.05)),
        ("0,0.1,0,0", ()),
    ],
)
def test_a_mass_alone_or_with_its_place(text, payload):
    jump = Jump(payload=parse_payload(text))
    assert jump.payload == payload
    assert Jump(**jump.as_dict()) == jump
    assert load_design(dump_design(Design(jump)).encode()).jump == jump


@pytest.mark.parametrize(
    ("payload", "reason"),
    [
        ((-1.0,), "no negative mass"),
        ((1.0, 2.0, 0.0, 0.0), "at most 1 m from the origin"),
        ((1.0, 0.1), "expected KG\\[,X,Y,Z\\] in kg and m"),
        ((float("nan"),), "expected KG"),
        ("3", "expected KG"),
        (3.0, "expected KG"),
    ],
)
def test_what_is_none(payload, reason):
    with pytest.raises(InputError, match=reason):
        Jump(payload=payload)


def test_a_line_that_is_none():
    with pytest.raises(InputError, match="payload: expected KG"):
        parse_payload("heavy")
