"""The words for a jump that differs from the one that was asked for."""

from math import radians

import pytest

from llsrbm.request.jump import Jump, changes


@pytest.mark.parametrize(
    ("asked", "found", "words"),
    [
        ({"twist": radians(170)}, {"twist": radians(136.04)}, "136° instead of 170°"),
        ({"twist": radians(-170)}, {"twist": radians(-135.5)}, "−135.5° instead of −170°"),
        ({"forward": 0.5}, {"forward": 0.42}, "forward 0.42 m instead of 0.5 m"),
        (
            {"twist": radians(170), "end_speed": 1.0},
            {"twist": radians(100), "end_speed": 0.5},
            "twist 100° instead of 170°, end speed 0.5 m/s instead of 1 m/s",
        ),
        ({"height": 0.1}, {"height": -0.0}, "height 0 m instead of 0.1 m"),
        ({"twist": 1.0, "forward": 0.1}, {"twist": 1.0 + 1e-4, "forward": 0.1 - 1e-5}, ""),
    ],
)
def test_what_differs_is_named_with_its_unit(asked, found, words):
    assert changes(Jump(**asked), Jump(**found)) == words
