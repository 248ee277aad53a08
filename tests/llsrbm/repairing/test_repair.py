"""Repair against the motion that was made foreign, and against the outside checker; on Go2."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import llsrbm
from llsrbm.mechanics import quaternion_product, quaternions_about_z, turns_about_z
from llsrbm.motion.whole_body import whole_body_motion
from tests.llsrbm.player.stages import stored_plan
from tests.llsrbm.repairing.foreign import jump, of_states, stepping

STATES = (
    "base_position",
    "base_velocity",
    "angular_velocity",
    "joint_position",
    "joint_velocity",
    "contact",
)
SLOWER, SUNK, YAW, AWAY = 1.25, -0.03, 2.0, np.array([3.0, -1.0, 0.0])


@cache
def repaired():
    """The jump that comes with the project: played slowly, sunk, elsewhere, every frame off."""
    motion = jump()
    qpos = motion.qpos.copy()
    qpos[:, :3] = qpos[:, :3] @ turns_about_z(YAW).T + AWAY + [0.0, 0.0, SUNK]
    turn = np.broadcast_to(quaternions_about_z(YAW), (len(qpos), 4))
    qpos[:, 3:7] = quaternion_product(turn, qpos[:, 3:7])
    qpos[:, 7:] += np.random.default_rng(5).normal(scale=0.005, size=qpos[:, 7:].shape)
    return llsrbm.repair(of_states(SLOWER * motion.time, qpos))


def test_the_plan_has_a_certificate_that_holds_where_the_motion_had_none():
    found = repaired()
    assert found.status == "repaired"
    assert found.before.broken
    assert found.plan.certified
    assert found.after.holds
    assert llsrbm.certify(replace(found.plan, certificate=None)).holds


def test_it_stays_near_the_motion():
    found = repaired()
    assert found.moved.joint_rms_rad < 0.05
    assert found.moved.base_rms_m < 0.02
    assert found.moved.landing_m < 0.01


def test_flights_are_as_long_as_gravity_has_them():
    found, truth = repaired(), stored_plan()
    assert found.plan.airborne == pytest.approx(truth.airborne, abs=0.03)
    assert found.moved.durations_s[1] == pytest.approx((1 - SLOWER) * truth.airborne, abs=0.05)
    assert "1.25 times as long as gravity" in found.why


def test_it_asks_for_the_same_jump_in_the_projects_frame():
    found, truth = repaired(), stored_plan()
    for name in ("twist", "forward", "lateral", "height"):
        assert getattr(found.plan.jump, name) == pytest.approx(getattr(truth.jump, name), abs=0.02)
    assert found.frame_yaw == pytest.approx(YAW, abs=0.02)
    np.testing.assert_allclose(found.frame_origin, [*AWAY[:2], SUNK], atol=0.02)
    np.testing.assert_allclose(found.plan.com[0, :2], truth.com[0, :2], atol=0.02)


def test_the_phases_are_the_motions_in_its_own_time():
    found, truth = repaired(), stored_plan()
    assert [phase.name for phase in found.phases] == list(truth.schedule.names)
    edges = [found.phases[1].start_s, found.phases[1].end_s]
    np.testing.assert_allclose(edges, SLOWER * truth.phase_start[1:3], atol=0.04)


def test_the_plan_saves_and_exports(tmp_path):
    found = repaired()
    found.plan.save(tmp_path / "plan.npz")
    again = llsrbm.load(tmp_path / "plan.npz")
    assert again.certified
    np.testing.assert_allclose(again.joint_position, found.plan.joint_position)
    llsrbm.export(again, tmp_path / "motion.csv", format="unitree-csv")
    assert whole_body_motion(again, 100.0).fps == 100.0


def test_a_certified_plan_stays_as_it_is():
    plan = stored_plan()
    found = llsrbm.repair(plan)
    assert found.status == "unchanged"
    assert found.plan is plan
    assert found.moved.joint_rms_rad == 0.0
    assert [phase.feet for phase in found.phases] == [phase.feet for phase in plan.schedule]


def test_as_data_it_is_plain():
    found = repaired().as_dict()
    assert set(found) == {
        *("status", "before", "after", "moved", "phases", "frame", "why"),
    }
    assert found["after"]["friction"]["holds"] is True
    assert set(found["moved"]) == {"joint_rms_rad", "base_rms_m", "landing_m", "durations_s"}
    assert set(found["phases"][0]) == {"name", "feet", "start_s", "end_s"}


def _standing():
    motion = jump()
    return of_states(motion.time, np.repeat(motion.qpos[:1], len(motion.time), axis=0))


def _upside_down():
    """The base turns over in its flight, whatever the feet do."""
    found = stepping([0.7] * 4, [1.05] * 4)
    half = np.pi * np.clip((found.time - 0.7) / 0.35, 0.0, 1.0)
    turn = np.stack([np.cos(half), 0 * half, -np.sin(half), 0 * half], axis=-1)
    states = {name: np.repeat(getattr(jump(), name)[:1], len(turn), axis=0) for name in STATES}
    return replace(found, **states, base_quat=turn)


def _random():
    """Each frame is another pose, somewhere else."""
    motion = jump()
    off = np.random.default_rng(3).normal(size=motion.qpos.shape)
    off[:, 3:7] = 0.0
    return of_states(motion.time, motion.qpos + off)


def _airborne():
    """It begins in the air."""
    motion = jump()
    late = motion.time > 0.8
    return of_states(motion.time[late] - motion.time[late][0], motion.qpos[late])


@pytest.mark.parametrize(
    ("motion", "why"),
    [
        (_standing, "No foot leaves the ground for a flight of all feet."),
        (_random, "No foot stays in its place anywhere for as long as feet that stand do."),
        (_airborne, "No flight begins and ends with all feet on the ground."),
        (
            _upside_down,
            "The body turns over, and flips and rolls are planned, not repaired.",
        ),
    ],
)
def test_what_cannot_be_repaired_says_why(motion, why):
    found = llsrbm.repair(motion())
    assert found.status == "failed"
    assert found.plan is None
    assert found.why == why


def test_a_jump_that_there_is_not_is_refused():
    with pytest.raises(llsrbm.InputError, match="jump: expected 1 to 1, got 2"):
        llsrbm.repair(jump(), jump=2)
