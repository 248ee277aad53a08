"""`Push`: what may be asked for, from Python, files and the command line."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.errors import InputError
from llsrbm.request.scenario import Push, parse_push


def refused(call, *given) -> str:
    with pytest.raises(InputError) as caught:
        call(*given)
    said = str(caught.value)
    assert said.isprintable()
    assert len(said) < 200
    return said


@given(
    st.floats(0, 100),
    st.lists(st.floats(-20, 20), min_size=3, max_size=3),
    st.lists(st.floats(-20, 20), min_size=3, max_size=3),
)
def test_a_line_of_text_means_its_numbers(time, impulse, moment):
    push = parse_push(",".join(map(repr, [time, *impulse, *moment])))
    assert push == Push(time, tuple(impulse), tuple(moment))
    without = parse_push(",".join(map(repr, [time, *impulse])))
    assert without == Push(time, tuple(impulse))
    assert without.moment == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    "text", ["", "1", "1,2,3", "1,2,3,4,5", "0.4,0,12,0,", "a,b,c,d", "0" * 999]
)
def test_what_is_no_push(text):
    assert refused(parse_push, text).startswith(
        "push: expected T,JX,JY,JZ[,MX,MY,MZ] in s, N s and N m s, got "
    )


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("nan,1,1,1", "push: time: expected a finite number, got nan"),
        ("-0.1,1,1,1", "push: time: expected at least 0 s, got -0.1"),
        ("0.4,nan,1,1", "push: impulse: expected three finite numbers, got [nan, 1.0, 1.0]"),
        ("0.4,1,1,1,1,inf,1", "push: moment: expected three finite numbers, got [1.0, inf, 1.0]"),
        ("0.4,1e6,0,0", "push: impulse: expected at most 200 N s, got 1e+06 N s"),
        ("0.4,0,0,0,30,40,1", "push: moment: expected at most 50 N m s, got 50.01 N m s"),
    ],
)
def test_numbers_that_make_no_sense(text, said):
    assert refused(parse_push, text) == said
