import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.number_text import decimal, degrees, percent, power, short

NUMBERS = st.floats(-1e6, 1e6) | st.floats(-1e-3, 1e-3) | st.sampled_from((0.0, -0.0, -5e-324))
SIGNED_ZERO = re.compile(r"[-−+]0*\.?0*(e[+−]\d+)?( %)?$")


@given(NUMBERS, st.integers(0, 6), st.booleans())
def test_no_zero_has_a_sign_and_every_minus_is_one(value, places, signed):
    texts = (
        decimal(value, places, signed=signed),
        percent(value, places, signed=signed),
        power(value, places),
        short(value),
    )
    for text in texts:
        assert not SIGNED_ZERO.match(text)
        assert "-" not in text


@given(NUMBERS, st.integers(0, 6), st.booleans())
def test_what_is_shown_is_the_number(value, places, signed):
    text = decimal(value, places, signed=signed)
    rounded = float(text.replace("−", "-"))
    assert rounded == pytest.approx(value, abs=0.5001 * 10**-places)
    assert len(text.partition(".")[2]) == places
    assert text.startswith("−") == (rounded < 0)
    assert text.startswith("+") == (signed and rounded > 0)


def test_an_angle_is_given_in_degrees():
    assert degrees(math.radians(-12.5)) == "−12.5°"
    assert degrees(math.radians(3), 0, signed=True) == "+3°"
