from __future__ import annotations

import re
from dataclasses import replace
from html import unescape

import pytest

from app.timeline import timeline
from llsrbm.jump import Jump
from tests.app.synthetic_plan import FLY, STAND, synthetic_plan
from tests.llsrbm.synthetic_rollout import FORCE_PHASE, STANDING, synthetic_rollout

END = 2 * STAND + FLY + STANDING
TOUCHDOWN, DETECTED = STAND + FLY - 0.01, STAND + FLY - 0.005


@pytest.fixture(scope="module")
def plan():
    return synthetic_plan(Jump(twist=1.0))


@pytest.fixture(scope="module")
def rollout(plan):
    return synthetic_rollout(plan)


def text(html):
    return unescape(re.sub(r"<[^>]*>", "", html))


def places(html, thing):
    """(left, width) of what has this title, shares of the strip."""
    found = re.findall(rf'title="{thing}[^"]*"[^>]*left:([\d.]+)%;width:([\d.]+)(?:%|px)', html)
    return [tuple(float(value) / 100 for value in pair) for pair in found]


@pytest.mark.parametrize(
    ("instant", "phase"),
    [(0.1, "take-off"), (0.6, "flight"), (0.896, "landing"), (1.2, "landing"), (1.9, "standing")],
)
def test_it_says_which_phase_it_is(plan, rollout, instant, phase):
    assert text(timeline(plan, instant, rollout)).startswith(f"{phase} {instant:.2f} s of 2.30 s")


def test_a_plan_alone_ends_with_its_landing(plan):
    told = text(timeline(plan, 1.3))
    assert told == "landing 1.30 s of 1.30 s · lift-off 0.40 s, touch-down 0.90 s"


def test_touchdown_detection_and_force_phase_are_marked_where_they_are(plan, rollout):
    html = timeline(plan, 0.0, rollout)
    ((touchdown, _),) = places(html, "touch-down")
    ((detected, _),) = places(html, "detected")
    ((begin, length),) = places(html, "force control")
    assert touchdown == pytest.approx(TOUCHDOWN / END, abs=1e-4)
    assert detected == pytest.approx(DETECTED / END, abs=1e-4)
    assert begin == pytest.approx(DETECTED / END, abs=1e-4)
    assert length == pytest.approx(FORCE_PHASE / END, abs=2e-3)
    assert "touch-down 0.900 s planned, 0.890 s simulated, detected +5.0 ms" in text(html)


def test_a_missed_touchdown_is_told(plan, rollout):
    blind = replace(rollout, outcome=replace(rollout.outcome, touchdown_detected_s=None))
    html = timeline(plan, 0.0, blind)
    assert "0.890 s simulated, not detected" in text(html)
    assert places(html, "detected") == []


def test_no_contact_at_all_is_told(plan, rollout):
    outcome = replace(rollout.outcome, touchdown_true_s=None, touchdown_detected_s=None)
    html = timeline(plan, 0.0, replace(rollout, outcome=outcome))
    assert "planned, none simulated, not detected" in text(html)


def test_a_fall_ends_its_strip_early(plan):
    html = timeline(plan, 0.0, synthetic_rollout(plan, fell_at=0.65))
    _, simulated = html.split("overflow:hidden")[1:3]
    widths = [float(w) for w in re.findall(r'<div style="width:([\d.]+)%', simulated)]
    assert sum(widths) == pytest.approx(100 * 0.65 / plan.duration, abs=0.5)
