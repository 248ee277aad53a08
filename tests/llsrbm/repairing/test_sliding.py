"""Clips whose feet slide as they stand, made of a jump of feet that do not."""

import numpy as np
import pytest

import llsrbm
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.repairing.begun import begun
from llsrbm.repairing.request import request_of
from llsrbm.repairing.sliding import led_at
from tests.llsrbm.player.stages import stored_plan
from tests.llsrbm.repairing.foreign import GO2, jump, jumps, of_states


def sliding(speed=0.3):
    """The jump, all of which moves ahead as it stands, not in flight; and by how much (K,) m."""
    motion = jump()
    flight = jumps(motion)[0].edges[[1, -2]]
    time = np.minimum(motion.time, flight[0]) + np.maximum(motion.time - flight[1], 0.0)
    shift = speed * (time - np.interp(flight[0], motion.time, time))
    qpos = motion.qpos.copy()
    qpos[:, 0] += shift
    return of_states(motion.time, qpos), shift


def test_feet_that_do_not_slide_are_not_held():
    (part,) = jumps(jump())
    assert part.slides == (False, False)
    request = request_of(part, GO2)
    led = led_at(request, part.motion.time)
    np.testing.assert_allclose(led.own.middles, led.to.middles)
    np.testing.assert_allclose(led.turns, 0.0)


def test_feet_that_slide_are_held_where_they_leave_and_where_they_land():
    motion, shift = sliding()
    (part,) = jumps(motion)
    assert part.slides == (True, True)
    request, own = request_of(part, GO2), stored_plan().jump
    for name in ("twist", "forward", "lateral"):
        assert getattr(request.task.jump, name) == pytest.approx(getattr(own, name), abs=0.05)
    held = led_at(request, motion.time).points(motion.base_position)
    there = (motion.time >= part.edges[0]) & (motion.time <= part.edges[-1])
    np.testing.assert_allclose(
        held[there], (motion.base_position - np.outer(shift, [1, 0, 0]))[there], atol=0.02
    )


def test_such_a_clip_is_repaired():
    motion, _ = sliding()
    found = llsrbm.repair(motion)
    assert found.status == "repaired"
    assert found.plan.certified
    assert found.moved.joint_rms_rad < 0.15
    assert found.plan.jump.forward == pytest.approx(stored_plan().jump.forward, abs=0.03)


def test_a_share_of_it_begins_as_it_does():
    motion, _ = sliding()
    (part,) = jumps(motion)
    plans = []
    for share in (1.0, 0.5):
        request = request_of(part, GO2, share)
        grid = Grid.at(request.task.schedule, layout_of(request.task.jump, GO2).intervals)
        plans.append(begun(request, GO2, grid, "fatrop"))
    whole, some = plans
    np.testing.assert_allclose(some.base_position[0], whole.base_position[0], atol=1e-4)
    gone = [
        np.linalg.norm(plan.base_position[-1, :2] - plan.base_position[0, :2]) for plan in plans
    ]
    assert gone[1] == pytest.approx(0.5 * gone[0], abs=0.03)
