"""Parts of motions and what they ask for, against the jump that the motion was made of."""

from dataclasses import replace

import numpy as np
import pytest

from llsrbm.mechanics import turns_about_z
from llsrbm.repairing import part as part_module
from llsrbm.repairing import request as request_module
from llsrbm.repairing.part import NoJump
from llsrbm.repairing.request import request_of
from llsrbm.request.jump_types import load_type
from tests.llsrbm.player.stages import stored_plan
from tests.llsrbm.repairing.foreign import GO2, jump, jumps, of_states, stepping, twice


def test_a_jump_alone_is_one_part_from_its_start_to_its_end():
    motion = jump()
    (part,) = jumps(motion)
    assert part.flights == 1
    np.testing.assert_allclose(part.edges[[0, -1]], motion.time[[0, -1]], atol=0.15)
    assert part.slower == pytest.approx(1.0, abs=0.03)


def test_it_asks_for_the_jump_that_it_was_made_of():
    request, own = request_of(jumps(jump())[0], GO2), stored_plan().jump
    wanted = request.task.jump
    assert (wanted.robot, wanted.type, wanted.stones) == ("go2", "together", ())
    assert wanted.twist == pytest.approx(own.twist, abs=0.02)
    for name in ("forward", "lateral", "height"):
        assert getattr(wanted, name) == pytest.approx(getattr(own, name), abs=0.01)
    np.testing.assert_allclose(request.task.places[0].feet, GO2.feet, atol=0.01)
    assert [phase.name for phase in request.phases] == ["take-off", "flight", "landing"]


def test_jumps_that_follow_at_once_are_hops(monkeypatch):
    monkeypatch.setattr(part_module, "REBOUND", 2.0)  # the landing and the take-off are long
    (part,) = jumps(twice(still=0.1))
    wanted, own = request_of(part, GO2).task.jump, stored_plan().jump
    assert (wanted.type, part.flights) == ("hops", 2)
    for landing in wanted.route:
        assert landing.twist == pytest.approx(own.twist, abs=0.03)
        assert landing.forward == pytest.approx(own.forward, abs=0.02)


def test_jumps_that_are_apart_are_parts_of_their_own():
    first, second = jumps(twice(still=2.0))
    assert first.edges[-1] < second.edges[0]
    assert first.flights == second.flights == 1


def test_what_is_played_slowly_is_seen_by_its_fall():
    motion = jump()
    for slower in (0.8, 1.3):
        (part,) = jumps(of_states(slower * motion.time, motion.qpos))
        assert part.slower == pytest.approx(slower, rel=0.04)


def test_feet_that_leave_in_turn_are_a_type_of_their_own():
    # A crawl onto three feet and two before a flight.
    lift = np.array([0.5, 0.9, 1.3, 1.3])
    (part,) = jumps(stepping(lift, [1.7] * 4, until=3.0))
    own, kind = request_module._of_a_type(part, GO2)
    assert kind == "all - FR+RL+RR - RL+RR - none - all"
    assert tuple(phase.feet for phase in load_type(kind).schedule(GO2)) == own.feet


def test_several_flights_that_some_feet_begin_are_no_jump(monkeypatch):
    monkeypatch.setattr(part_module, "REBOUND", 2.0)
    (part,) = jumps(twice(still=0.1))
    first, *others = part.phases
    middle = (first.start_s + first.end_s) / 2
    some = replace(first, feet=GO2.leg_names[:2], start_s=middle)
    limps = replace(part, phases=(replace(first, end_s=middle), some, *others))
    with pytest.raises(NoJump, match="no jump type with 2 flights"):
        request_of(limps, GO2)


def test_a_share_of_the_way_is_asked_for_from_the_same_start():
    (part,) = jumps(jump())
    whole, some = (request_of(part, GO2, share) for share in (1.0, 0.6))
    own, wanted = whole.task.jump, some.task.jump
    for name in ("twist", "forward", "lateral"):
        assert getattr(wanted, name) == pytest.approx(0.6 * getattr(own, name), abs=2e-3)
    assert (some.frame.yaw, *some.frame.origin) == (whole.frame.yaw, *whole.frame.origin)
    np.testing.assert_allclose(some.task.places[0].feet, whole.task.places[0].feet)
    # Feet stand about the middle of their place as they did.
    about = [
        (place.feet[:, :2] - place.feet[:, :2].mean(axis=0)) @ turns_about_z(place.heading)[:2, :2]
        for place in (whole.task.places[-1], some.task.places[-1])
    ]
    np.testing.assert_allclose(about[1], about[0], atol=1e-3)
