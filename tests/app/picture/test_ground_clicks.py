"""Clicks on the ground: asked for, read and dropped."""

import asyncio
import math
from types import SimpleNamespace

import pytest

from app.picture.ground_clicks import GroundClicked, GroundClicks


class Scene:
    def __init__(self):
        self.asked_for = []

    def on_click(self):
        return self.asked_for.append

    def remove_click_callback(self, callback):
        self.asked_for.remove(callback)

    def click(self, origin, direction):
        for callback in self.asked_for:
            asyncio.run(callback(SimpleNamespace(ray_origin=origin, ray_direction=direction)))


def test_clicks_are_told_while_they_are_wanted():
    scene, told = Scene(), []
    clicks = GroundClicks(SimpleNamespace(scene=scene), told.append)
    for wanted in (False, True, True, False, True):
        clicks.draw(wanted=wanted)
        scene.click((0.0, 0.0, 1.0), (1.0, 0.5, -1.0))
    assert told == 3 * [GroundClicked((0.0, 0.0, 1.0), (1.0, 0.5, -1.0))]
    assert told[0].meets(0.0) == pytest.approx((1.0, 0.5))
    assert told[0].meets(0.5) == pytest.approx((0.5, 0.25))
    assert told[0].meets(2.0) is None


@pytest.mark.parametrize("nonsense", ["here", None, (1.0, 0.0), (math.nan, 0.0, 0.0), {}])
def test_what_is_no_ray_is_dropped(nonsense):
    scene, told = Scene(), []
    GroundClicks(SimpleNamespace(scene=scene), told.append).draw(wanted=True)
    scene.click(nonsense, (0.0, 0.0, -1.0))
    scene.click((0.0, 0.0, 1.0), nonsense)
    assert not told
