"""What is drawn of a push and of plans made anew: arrows, words, paths, footholds, regions."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from app.motion.baked import ARROW_PER_SPEED, trunk_com
from app.picture.scene import Scene
from llsrbm.motion.replan import followed
from llsrbm.request.scenario import Push
from llsrbm.robots import load_robot
from tests.app.picture.overlays.drawn import DrawnOverlay
from tests.app.picture.pictures import picture, planned, simulated
from tests.app.picture.recorded import RecordedClient, names_in, track_of
from tests.app.synthetic_plan import FLY, STAND
from tests.app.synthetic_replans import with_replans
from tests.llsrbm.synthetic_rollout import synthetic_rollout

ROBOT = load_robot("anymal")
TOO_HIGH = 0.1  # m that the made-up rollout's CoM is above where legs reach the ground
PUSH = Push(STAND + 0.1, (3.0, 12.0, 0.0))


@cache
def rollout():
    plan = planned().plan
    return with_replans(synthetic_rollout(plan), plan)


def pushed(layers, pushes=(PUSH,), **changes):
    return replace(
        picture(layers=layers, simulation=True),
        **{"rollout": rollout(), "pushes": pushes, **changes},
    )


def test_an_arrow_from_the_trunk_along_the_push_while_it_acts():
    drawn = DrawnOverlay(pushed({"pushes"}), "/push/past/arrow")
    (node,) = drawn.nodes
    frames, size = simulated(), drawn.size(node)
    seen = size[:, 2] > 0
    assert frames.time[seen][0] == pytest.approx(PUSH.time, abs=1 / 60)
    assert 0.05 < np.ptp(frames.time[seen]) < 0.15
    at = int(np.flatnonzero(seen)[2])
    points = drawn.vertices(node, at) - trunk_com(ROBOT, frames)[at]
    along = np.array(PUSH.impulse) / np.linalg.norm(PUSH.impulse)
    expected = ARROW_PER_SPEED * np.linalg.norm(PUSH.impulse) / ROBOT.mass
    assert (points @ along).max() == pytest.approx(expected, rel=1e-3)
    assert (points @ along).min() == pytest.approx(0.0, abs=1e-3)


def test_its_words_stand_at_its_tip_and_nowhere_to_be_seen_at_other_times():
    drawn = DrawnOverlay(pushed({"pushes"}), "/push/past/words")
    (node,) = drawn.nodes
    assert drawn.client.scene.nodes[node].text == "12.4 N s"
    _, track = track_of(drawn.clip, node)
    height = track.position[:, 2]
    there = height < 5
    assert (height[~there] >= 1000).all()
    assert (there == (drawn.size("/push/past/arrow/0")[:, 2] > 0)).all()


def test_pushes_that_are_gone_leave_nothing():
    client = RecordedClient()
    scene = Scene(client)
    scene.draw(pushed({"pushes"}, (PUSH, Push(0.2, (0.0, 5.0, 0.0)))))
    clip = scene.draw(pushed({"pushes"}, ()))
    assert not [name for name in names_in(clip) if name.startswith("/push")]
    assert not [name for name in client.scene.seen() if name.startswith("/push/past/")]


def test_the_path_and_the_footholds_are_those_of_the_plan_that_is_followed():
    drawn = DrawnOverlay(pushed({"new-plans"}), "/anew")
    replans = rollout().replans
    taken = [replan for replan in replans if np.isfinite(replan.applied)]
    assert 2 < len(taken) < len(replans)
    holds = [node for node in drawn.nodes if "foothold" in node]
    assert len(holds) == len(ROBOT.legs)
    for time in (taken[0].applied + 0.01, taken[3].applied + 0.01, planned().plan.duration):
        newest = followed(replans, time)
        for leg, node in enumerate(holds):
            times, track = track_of(drawn.clip, node)
            frame = int(np.searchsorted(times, time, side="right")) - 1
            assert track.position[frame, :2] == pytest.approx(newest.foot_position[-1, leg, :2])
        times, track = track_of(drawn.clip, "/anew/path/0")
        frame = int(np.searchsorted(times, time, side="right")) - 1
        assert track.position[frame] == pytest.approx(newest.com[0])
    times, track = track_of(drawn.clip, "/anew/path/0")
    assert (np.diff(times) > 0).all()
    assert track.scale[0].max() == 0  # before the first one


def test_the_region_is_there_in_flight_and_shrinks():
    lower = replace(rollout(), com=rollout().com - [0.0, 0.0, TOO_HIGH])
    drawn = DrawnOverlay(pushed({"landing-region"}, rollout=lower), "/within")
    times, _ = track_of(drawn.clip, drawn.nodes[0])
    assert times[0] >= STAND - 1e-3
    assert times[-1] <= STAND + FLY + 0.05
    round_of = np.sum([drawn.size(node)[:, 0] for node in drawn.nodes], axis=0)
    assert round_of[0] == round_of[-1] == 0
    flying = round_of[round_of > 0]
    assert flying[-1] < 0.8 * flying.max()


@pytest.mark.parametrize("missing", ["push and replanning", "a complete simulation"])
def test_no_region_without(missing):
    if missing == "a complete simulation":
        shown = pushed({"landing-region"}, rollout=None)
    else:
        scenario = replace(rollout().scenario, replan=False)
        shown = pushed({"landing-region"}, (), rollout=replace(rollout(), scenario=scenario))
    assert DrawnOverlay(shown, "/within").nodes == []
