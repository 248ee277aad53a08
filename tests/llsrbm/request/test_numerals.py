import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.request.messages import decimal, percent, power, short

NUMBERS = st.floats(-1e6, 1e6) | st.floats(-1e-3, 1e-3) | st.sampled_from((0.0, -0.0, -5e-324))
MINUS_ZERO = re.compile(r"-0*\.?0*(e[+-]\d+)?%?$")


@given(NUMBERS, st.integers(0, 6), st.booleans())
def test_no_zero_has_a_minus(value, places, signed):
    texts = (
        decimal(value, places, signed=signed),
        percent(value, places, signed=signed),
        power(value, places),
        short(value),
    )
    for text in texts:
        assert not MINUS_ZERO.match(text)


@given(NUMBERS, st.integers(0, 6), st.booleans())
def test_what_is_shown_is_the_number(value, places, signed):
    text = decimal(value, places, signed=signed)
    assert float(text) == pytest.approx(value, abs=0.5001 * 10**-places)
    assert len(text.partition(".")[2]) == places
    rounded = float(text)
    assert text.startswith("-") == (rounded < 0)
    assert text.startswith("+") == (signed and rounded >= 0)
