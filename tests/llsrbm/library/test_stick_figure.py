"""Stick figures: where MuJoCo has the robot, seen from one place; feet that stand do not move."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from llsrbm.errors import FileFormatError
from llsrbm.library import Library, file
from llsrbm.library.library import PARTS
from llsrbm.library.mirror import mirrored
from llsrbm.library.stick_figure import (
    INSTANTS,
    LARGEST,
    Role,
    StickFigure,
    positions,
    projected,
    skeleton,
)
from llsrbm.library.stored import reopened
from llsrbm.motion.robot import robot_of
from llsrbm.motion.whole_body import motion_at
from llsrbm.robots.urdf import BASE_JOINT
from tests.llsrbm.formats.jumps import mujoco_model
from tests.llsrbm.library.shipped_motions import card, first_of_each_robot, library, plan

MIRROR = np.array([1.0, -1.0, 1.0])
NAMES = first_of_each_robot()
SLIPS = 0.008  # m, the most that certificates allow


def times_of(of):
    return np.linspace(of.time[0], of.time[-1], INSTANTS)


def feet_of(of):
    return [k for k, bone in enumerate(skeleton(robot_of(of))) if bone.role is Role.FOOT]


@pytest.mark.parametrize("name", NAMES)
def test_points_are_where_mujoco_has_them(name):
    of = plan(name)
    robot, model = robot_of(of), mujoco_model(robot_of(of).name)
    data, motion, found = mujoco.MjData(model), motion_at(of, times_of(of)), positions(of)
    bodies = {
        BASE_JOINT: int(model.jnt_bodyid[0]),
        **{
            robot.model.getJointId(joint): int(model.joint(joint).bodyid[0])
            for joint in robot.joint_names
        },
    }
    for k in range(0, INSTANTS, 5):
        data.qpos[:7] = motion.qpos[k, :7]
        for joint, angle in zip(robot.joint_names, motion.qpos[k, 7:], strict=True):
            data.joint(joint).qpos[0] = angle
        mujoco.mj_kinematics(model, data)
        for bone, place in zip(skeleton(robot), found[k], strict=True):
            body = bodies[bone.joint]
            expected = data.xpos[body] + data.xmat[body].reshape(3, 3) @ bone.place
            np.testing.assert_allclose(place, expected, atol=1e-5)


@pytest.mark.parametrize("name", NAMES)
def test_feet_stand_where_the_plan_has_them(name):
    of = plan(name)
    feet = positions(of)[:, feet_of(of)].reshape(INSTANTS, len(of.leg_names), -1, 3).mean(axis=2)
    planned = of.foot_position[[0, -1]]
    assert np.abs(feet[[0, -1]] - planned).max() < 0.03  # a ball's middle, the middle of a sole
    first = of.time[(~of.contact.all(axis=1)).argmax()]
    standing = times_of(of) < first - 1e-6
    assert standing.sum() > 1
    # A ball rolls as its leg turns by less than a radian.
    assert np.ptp(feet[standing], axis=0).max() < SLIPS + robot_of(of).foot_lift


@pytest.mark.parametrize("name", NAMES)
def test_limbs_are_chains_from_trunk_to_feet(name):
    of = plan(name)
    robot, bones = robot_of(of), skeleton(robot_of(of))
    assert sum(bone.role is Role.TRUNK for bone in bones) == 8
    roots = [k for k, bone in enumerate(bones) if bone.role is Role.LIMB and bone.link == k]
    assert len(roots) == len(robot.legs) + len(robot.arms)
    lengths = []
    for k, bone in enumerate(bones):
        assert bone.link <= k
        if bone.link != k:
            lengths.append(
                np.linalg.norm(positions(of)[:, k] - positions(of)[:, bone.link], axis=1)
            )
    if not robot.sliding_joints:
        # A joint that was left out has a line pass it, which is a little shorter when it bends.
        assert max(np.ptp(each) for each in lengths) < 0.1
    assert len(feet_of(of)) == len(robot.legs) * (1 if robot.file.foot.is_point else 2)


def test_one_scale_for_both_axes_and_the_whole_motion():
    of = plan()
    found, seen = StickFigure.of(of), projected(positions(of))
    size = np.ptp(seen, axis=(0, 1)).max()
    assert np.abs(found.points).max() == LARGEST
    middle = (seen.max(axis=(0, 1)) + seen.min(axis=(0, 1))) / 2
    np.testing.assert_allclose(found.points * size / (2 * LARGEST) + middle, seen, atol=size / 500)


def test_it_is_seen_from_the_right_a_little_ahead_and_above():
    ahead, left, up = projected(np.eye(3))
    assert ahead[0] > 0.9
    assert ahead[1] < 0  # towards who looks
    assert left[0] > 0
    assert left[1] > 0  # away
    assert up[0] == 0
    assert up[1] > 0.9
    seen = np.array([ahead, left, up])
    np.testing.assert_allclose(seen.T @ seen, np.eye(2), atol=1e-12)  # parallel, not stretched


@pytest.mark.parametrize("name", ["go2-pirouette-0001", "go2-hops-0001"])
def test_the_image_in_a_mirror_has_the_image_of_its_points(name):
    once, robot = plan(name), robot_of(plan(name))
    image = mirrored(card(name), once, robot)
    other = positions(reopened(image.card, image.numbers, robot, name))
    expected = MIRROR * positions(once)
    apart = np.linalg.norm(other[:, :, None] - expected[:, None], axis=-1)
    assert apart.min(axis=1).max() < 2e-3
    assert apart.min(axis=2).max() < 2e-3


# ---- in a library


def test_every_motion_that_ships_has_its_own():
    found = library().stick_figures()
    assert sorted(found) == [each.name for each in library().cards]
    for name in NAMES:
        own, stored = StickFigure.of(plan(name)), found[name]
        assert np.array_equal(own.links, stored.links)
        assert np.array_equal(own.roles, stored.roles)
        # A rounding may fall to the other side on another machine.
        assert np.abs(own.points.astype(int) - stored.points).max() <= 1
    assert all(each.array.size < 2000 for each in found.values())


def test_motions_of_an_older_file_get_theirs_when_files_are_joined(tmp_path):
    own, kept = Library(tmp_path), library().stored(card().name)
    own.put(replace(kept, figure=None))
    assert Library(tmp_path).stick_figures() == {}
    assert own.stored(card().name).figure is None
    own.packed()
    again = Library(tmp_path)
    assert list(again.stick_figures()) == [card().name]
    assert np.array_equal(again.stored(card().name).numbers, kept.numbers)
    assert again.card(card().name) == kept.card


def test_a_motion_that_cannot_be_opened_any_more_stays_without(tmp_path):
    own, kept = Library(tmp_path), library().stored(card().name)
    own.put(replace(kept, figure=None, numbers=kept.numbers[:-1]))
    own.packed()
    assert own.stick_figures() == {}
    assert len(own.cards) == 1


def test_a_motion_that_is_added_has_one(tmp_path):
    own = Library(tmp_path)
    name = own.add(plan()).name
    assert list(own.stick_figures()) == [name]


def wrong_link(array):
    array[0, 3, 0] = array.shape[1]
    return array


@pytest.mark.parametrize(
    "change",
    [
        wrong_link,
        lambda array: array[:1],
        lambda array: array[..., :1],
        lambda array: array.astype(np.int16),
        lambda array: np.tile(array, (1, 5, 1)),
    ],
)
def test_what_is_damaged_is_named(tmp_path, change):
    own, kept = Library(tmp_path), library().stored(card().name)
    own.put(kept)
    (path,) = (tmp_path / PARTS).iterdir()
    with np.load(path) as archive:
        arrays = dict(archive)
    key = f"{card().name}.stick"
    np.savez(path, **arrays | {key: change(arrays[key])})
    with pytest.raises(FileFormatError, match=f'key "{key}": expected'):
        file.read_stick_figures(path)
    assert Library(tmp_path).open(card().name, check=False).jump == card().request
