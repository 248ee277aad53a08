"""Parts of motions and what they ask for, against the jump that the motion was made of."""

import numpy as np
import pytest

from llsrbm.repairing import part as part_module
from llsrbm.repairing.part import NoJump
from llsrbm.repairing.request import request_of
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


def test_feet_that_leave_in_turn_have_no_jump_type():
    # A crawl onto three feet and two before a flight.
    lift = np.array([0.5, 0.9, 1.3, 1.3])
    motion = stepping(lift, [1.7] * 4, until=3.0)
    with pytest.raises(NoJump, match="no jump type"):
        request_of(jumps(motion)[0], GO2)
