"""A repaired clip against the clip that it was made of, and against the plans in it; on Go2."""

from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

import llsrbm
from llsrbm.motion.whole_body import whole_body_motion
from llsrbm.repairing import clip as clip_module
from llsrbm.repairing.joining import joined
from llsrbm.repairing.repair import repaired_part
from llsrbm.repairing.request import request_of
from llsrbm.repairing.result import Repair
from tests.llsrbm.player.stages import stored_plan
from tests.llsrbm.repairing.foreign import GO2, clip, jump, jumps, of_states

FPS = 50.0
SLID = 0.004  # m


@cache
def repaired():
    return llsrbm.repair_clip(clip())


def frames(start, end):
    """From one instant's frame to another's, that included."""
    return slice(round(start * FPS), round(end * FPS) + 1)


def attitudes(motion, own):
    return Rotation.from_quat(motion.base_quat[own], scalar_first=True)


def assert_moved_in_the_plane(own, other):
    """Poses (position, attitude) of a base are others', turned about the vertical and shifted."""
    turns = (own[1] * other[1].inv()).as_rotvec()
    np.testing.assert_allclose(turns, np.broadcast_to(turns[0], turns.shape), atol=1e-6)
    np.testing.assert_allclose(turns[0, :2], 0.0, atol=1e-6)
    shift = own[0] - Rotation.from_rotvec(turns[0]).apply(other[0])
    np.testing.assert_allclose(shift, np.broadcast_to(shift[0], shift.shape), atol=1e-6)
    return turns[0, 2], shift[0]


def test_each_jump_is_repaired_and_no_check_of_the_clip_is_broken():
    found = repaired()
    assert found.status == "repaired"
    assert [each.status for each in found.jumps] == ["repaired", "repaired"]
    assert [each.plan.certified for each in found.jumps] == [True, True]
    assert [check.name for check in found.before.broken] == ["clearance"]
    assert found.after.broken == ()
    assert llsrbm.certify(found.motion).as_dict() == found.after.as_dict()


def test_a_repaired_stretch_is_the_plan_itself():
    found = repaired()
    for (start, end), each in zip(found.plans, found.jumps, strict=True):
        own, plan = frames(start, end), whole_body_motion(each.plan, FPS)
        np.testing.assert_allclose(found.motion.joint_position[own], plan.joint_position)
        np.testing.assert_allclose(found.motion.joint_velocity[own], plan.joint_velocity)
        assert_moved_in_the_plane(
            (found.motion.base_position[own], attitudes(found.motion, own)),
            (plan.base_position, attitudes(plan, slice(None))),
        )


def test_the_first_plan_is_where_its_frame_is():
    found = repaired()
    first, (start, end) = found.jumps[0], found.plans[0]
    plan = whole_body_motion(first.plan, FPS)
    turn = Rotation.from_rotvec([0.0, 0.0, first.frame_yaw])
    np.testing.assert_allclose(
        found.motion.base_position[frames(start, end)],
        turn.apply(plan.base_position) + first.frame_origin,
        atol=1e-9,
    )


def test_what_is_beside_jumps_is_moved_in_the_plane_and_in_time():
    given, found = clip(), repaired()
    made = found.motion
    joins = [(each.start_s, each.end_s) for each in found.joins]
    before = frames(0.0, joins[0][0])
    np.testing.assert_array_equal(made.qpos[before], given.qpos[before])
    np.testing.assert_allclose(made.qvel[before], given.qvel[before], atol=1e-9)
    late = round((found.plans[0][1] - found.jumps[0].phases[-1].end_s) * FPS)
    for start, end in ((joins[1][1], joins[2][0]), (joins[3][1], made.time[-1])):
        own = frames(start, end)
        other = slice(own.start - late, own.stop - late)
        np.testing.assert_allclose(made.joint_position[own], given.joint_position[other])
        np.testing.assert_allclose(made.joint_velocity[own], given.joint_velocity[other])
        turn, shift = assert_moved_in_the_plane(
            (made.base_position[own], attitudes(made, own)),
            (given.base_position[other], attitudes(given, other)),
        )
        assert abs(turn) < 0.01
        assert abs(shift[2]) < 0.005
        late = len(made.time) - len(given.time)
    assert made.fps == given.fps
    np.testing.assert_allclose(made.time, np.arange(len(made.time)) / FPS)


def test_nothing_jumps_at_joins():
    found = repaired()
    made, limit = found.motion, GO2.model.velocityLimit[6:]
    turned = (attitudes(made, slice(1, None)) * attitudes(made, slice(-1)).inv()).magnitude()
    for start, end in ((each.start_s, each.end_s) for each in found.joins):
        own = frames(start - 0.1, end + 0.1)
        steps = np.abs(np.diff(made.joint_position[own], axis=0))
        assert (steps < 0.2 * limit / FPS).all()
        assert turned[own].max() * FPS < 1.0
        speeds = np.diff(made.base_position[own], axis=0) * FPS
        np.testing.assert_allclose(speeds[1:-1], made.base_velocity[own][1:-2], atol=0.1)
    for edges in found.plans:
        for at in edges:  # plans are at rest there
            beside = made.joint_velocity[frames(at - 1.5 / FPS, at + 1.5 / FPS)]
            assert np.abs(beside).max() < 0.5
            np.testing.assert_allclose(made.joint_velocity[round(at * FPS)], 0.0, atol=0.02)


def test_feet_that_stand_at_joins_stay_where_they_are():
    found = repaired()
    model, data = GO2.model, GO2.model.createData()
    for each in found.joins:
        places = []
        for qpos in found.motion.qpos[frames(each.start_s, each.end_s)]:
            pin.framesForwardKinematics(model, data, qpos[[0, 1, 2, 4, 5, 6, 3, *range(7, 19)]])
            places.append([data.oMf[leg.foot_frame_id].translation for leg in GO2.legs])
        assert np.ptp(places, axis=0).max() < SLID
        assert each.feet_m < SLID


def test_what_is_too_short_for_a_join_is_one_move():
    one = jump().qpos.copy()
    one[:, 7:] += np.random.default_rng(3).normal(scale=0.01, size=(len(one), 12))
    qpos = np.concatenate([one, np.repeat(one[-1:], 7, axis=0)])
    given = replace(of_states(np.arange(len(qpos)) / FPS, qpos), fps=FPS)
    found = llsrbm.repair_clip(given)
    ((start, end),), (join,) = found.plans, found.joins
    assert start == 0.0
    assert (join.start_s, join.end_s) == (end, found.motion.time[-1])
    assert join.end_s - join.start_s == pytest.approx(0.3)
    np.testing.assert_allclose(found.motion.qpos[-1, 7:], qpos[-1, 7:], atol=0.01)
    steps = np.diff(found.motion.joint_position[frames(join.start_s, join.end_s)], axis=0)
    assert np.abs(steps).max() < 0.01


def test_plans_with_hardly_anything_in_between_are_joined_by_one_move():
    first, second = jumps(clip())
    *others, last = first.phases
    first = replace(first, phases=(*others, replace(last, end_s=second.edges[0] - 0.1)))
    plans = [each.plan for each in repaired().jumps]
    requests = [request_of(part, GO2) for part in (first, second)]
    found = joined(clip(), list(zip(requests, plans, strict=True)))
    assert len(found.joins) == 3
    assert found.joins[1][:2] == pytest.approx((found.plans[0][1], found.plans[1][0]))
    assert found.joins[1].end_s - found.joins[1].start_s == pytest.approx(0.3, abs=1.5 / FPS)
    assert found.joins[1].feet_m < SLID
    own = frames(*found.joins[1][:2])
    assert np.abs(np.diff(found.motion.joint_position[own], axis=0)).max() < 0.02


def test_a_jump_that_cannot_be_repaired_stays(monkeypatch):
    known = repaired()

    def second_fails(part, before, watch):
        if part.edges[0] > 5.0:
            return Repair("failed", before, phases=part.phases, why="No way was found."), None
        return repaired_part(part, before, watch)

    monkeypatch.setattr(clip_module, "repaired_part", second_fails)
    found, given = llsrbm.repair_clip(clip()), clip()
    assert found.status == "failed"
    assert [each.status for each in found.jumps] == ["repaired", "failed"]
    assert found.why == "The jump from 7.86 to 9.68 s stays as it is: no way was found."
    assert found.plans == known.plans[:1]
    after = round(found.joins[1].end_s * FPS)
    rest = len(found.motion.time) - after
    np.testing.assert_allclose(found.motion.joint_position[-rest:], given.joint_position[-rest:])


def test_without_a_jump_there_is_no_clip():
    standing = np.repeat(jump().qpos[:1], 100, axis=0)
    found = llsrbm.repair_clip(replace(of_states(np.arange(100) / FPS, standing), fps=FPS))
    assert (found.status, found.motion, found.jumps) == ("failed", None, ())
    assert found.why == "No foot leaves the ground for a flight of all feet."


def test_a_certified_plan_is_a_clip_that_stays():
    found = llsrbm.repair_clip(stored_plan(), fps=FPS)
    assert found.status == "unchanged"
    assert found.motion.fps == FPS
    assert found.after is found.before


def test_frames_that_are_not_even_are_refused():
    with pytest.raises(llsrbm.InputError, match="not evenly spaced; expected one rate"):
        llsrbm.repair_clip(replace(clip(), fps=None))


def test_as_data_it_is_plain():
    found = repaired().as_dict()
    assert set(found) == {
        *("status", "before", "after", "jumps", "plans", "joins", "phases", "why"),
    }
    assert set(found["jumps"][0]) == {"status", "after", "moved", "phases", "frame", "why"}
    assert set(found["joins"][0]) == {"start_s", "end_s", "feet_m"}
    assert [phase["feet"] for phase in found["phases"]] == [
        list(GO2.leg_names) if k % 2 == 0 else [] for k in range(5)
    ]
