"""The sliders' tracks in a real browser."""

import pytest

from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from tests.app.chromium import tab
from tests.app.waits import wait_until
from tests.llsrbm.atlas.classifiers import learned_of

# Of the twist, the first slider: its sentence, what a screen reader says, and its track.
TRACK = """() => {
  const slider = document.querySelector(".mantine-Slider-root");
  const track = slider.querySelector(".mantine-Slider-track");
  const thumb = slider.querySelector("[role=slider]");
  return [llsrbm.tint.words(slider.id), thumb.getAttribute("aria-description"),
    getComputedStyle(track, "::before").backgroundImage];
}"""


def put(page, tuning, words):
    page.session._inbox.put(tuning)
    wait_until(lambda: page.evaluate(TRACK)[0].startswith(words), words)
    return page.evaluate(TRACK)


@pytest.fixture(autouse=True)
def known():
    """What can be planned, made up."""
    with learned_of(load_robot("anymal")):
        yield


def test_a_track_shows_and_says_what_can_be_planned(page):
    title, said, drawn = put(page, Tuning(), "Can be planned from")
    assert said == title
    assert "repeating-linear-gradient" in drawn
    tab(page, "Plots")  # viser makes the tab's elements anew, the sliders' stay
    # Answers that come in meanwhile move its ends.
    assert page.evaluate(TRACK)[0].startswith("Can be planned from")
    _, _, drawn = put(page, Tuning(limits={"reach_max": 0.5}), "Which values")
    assert drawn == "none"
    put(page, Tuning(), "Can be planned from")
