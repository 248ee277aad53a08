"""Axes of links, angular momentum and inertia: what moves with the body."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from app.picture.overlays.forces import METRES_PER_UNIT, AngularMomentum
from app.picture.scene import Scene
from llsrbm.look.shown_motion import shown_motion
from llsrbm.robots import load_robot
from tests.app.picture.overlays.drawn import DrawnOverlay
from tests.app.picture.pictures import picture, planned
from tests.app.picture.recorded import RecordedClient, track_of


@pytest.mark.parametrize("robot", ["anymal", "slider"])
def test_every_link_has_its_axes(robot):
    shown = picture(robot, {"frames"})
    drawn, motion, frame = DrawnOverlay(shown, "/axes"), shown.planned.motion, 40
    model = motion.robot.model
    data = model.createData()
    qpos = motion.qpos[frame]
    q = np.concatenate([qpos[:3], qpos[[4, 5, 6, 3]], qpos[7:]])
    pin.forwardKinematics(model, data, q)
    assert len(drawn.nodes) == model.njoints - 1
    by_number = sorted(drawn.nodes, key=lambda node: int(node.rsplit("/", 1)[1]))
    colours = drawn.mesh(by_number[0]).visual.vertex_colors[:, :3].astype(int)
    for joint, node in enumerate(by_number, start=1):
        points = drawn.vertices(node, frame)
        for axis in range(3):
            of_axis = points[colours.argmax(axis=1) == axis]
            tip = of_axis[
                ((of_axis - data.oMi[joint].translation) @ data.oMi[joint].rotation)[:, axis] > 0.09
            ]
            along = tip.mean(axis=0) - data.oMi[joint].translation
            assert along == pytest.approx(0.1 * data.oMi[joint].rotation[:, axis], abs=1e-3)


@pytest.mark.parametrize("robot", ["anymal", "slider"])
@pytest.mark.parametrize("twist", [0.7, -0.7])
def test_it_points_along_the_plans_from_the_com(robot, twist):
    shown = picture(robot, {"spin"}, twist=twist)
    drawn = DrawnOverlay(shown, "/momentum")
    plan = planned(robot, twist).plan
    frames = shown.solid
    frame = int(np.abs(frames.time - 0.65).argmin())
    knot = int(np.abs(plan.time - frames.time[frame]).argmin())
    (node,) = drawn.nodes
    vertices = drawn.vertices(node, frame)
    tip = vertices[np.linalg.norm(vertices - frames.com[frame], axis=1).argmax()]
    arrow, expected = tip - frames.com[frame], plan.angular_momentum[knot]
    assert np.linalg.norm(np.cross(arrow, expected)) < 1e-3 * np.linalg.norm(expected)
    assert arrow @ expected > 0
    length = np.linalg.norm(expected) * METRES_PER_UNIT
    assert np.linalg.norm(arrow) == pytest.approx(length, rel=1e-3)
    assert f"{METRES_PER_UNIT:g} m" in AngularMomentum.hint


def test_what_does_not_turn_has_no_arrow():
    drawn = DrawnOverlay(picture("anymal", {"spin"}), "/momentum")
    assert drawn.size(drawn.nodes[0])[0].tolist() == [0, 0, 0]


def inertia(mass, track, frame):
    """Of a uniform solid ellipsoid with the drawn semi-axes, world frame."""
    squares = track.scale[frame] ** 2
    own = np.diag(mass / 5 * (squares.sum() - squares))
    turn = Rotation.from_quat(track.wxyz[frame], scalar_first=True).as_matrix()
    return turn @ own @ turn.T


@pytest.mark.parametrize("name", ["anymal", "slider"])
def test_a_solid_of_the_robots_mass_has_the_planned_inertia(name):
    client, robot = RecordedClient(), load_robot(name)
    shown = picture(name, {"ellipsoids"})
    clip = Scene(client).draw(shown)
    _, track = track_of(clip, "/ellipsoid/planned/wires")
    assert track.nodes == ("/ellipsoid/planned/wires",)
    motion = shown.planned.motion
    for frame in (0, 30, 60):
        expected = motion.inertia[frame]
        assert inertia(robot.mass, track, frame) == pytest.approx(expected, rel=1e-6, abs=1e-6)
        assert track.position[frame] == pytest.approx(motion.com[frame])
    _, rigid = track_of(clip, "/ellipsoid/srbm/wires")
    assert inertia(robot.mass, rigid, 0) == pytest.approx(robot.inertia, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("simulation", [False, True])
def test_with_arms_it_is_compared_with_the_same_postures_whose_arms_are_held(simulation):
    client, robot = RecordedClient(), load_robot("g1")
    shown = picture("g1", {"ellipsoids"}, simulation=simulation)
    clip = Scene(client).draw(shown)
    assert "/ellipsoid/srbm" not in client.scene.seen()
    time, held = track_of(clip, "/ellipsoid/held_arms/wires")
    assert time is shown.solid.time
    # Legs and arms of a made-up plan are stiff.
    base = Rotation.from_quat(shown.planned.motion.base_quat[0], scalar_first=True).as_matrix()
    expected = base @ robot.inertia @ base.T
    assert inertia(robot.mass, held, 0) == pytest.approx(expected, rel=1e-4, abs=1e-4)


def test_raised_arms_are_as_they_hang_in_the_ellipsoid_of_held_ones():
    robot, motion = load_robot("g1"), planned("g1").motion
    joints = motion.joint_position.copy()
    joints[:, robot.arm_joint_index] += 0.5
    raised = shown_motion(replace(motion, joint_position=joints))
    for one, other in zip(raised.held_arms, planned("g1").frames.held_arms, strict=True):
        assert one == pytest.approx(other)
    assert planned("anymal").frames.held_arms is None


def test_beside_a_simulation_the_whole_bodys_takes_the_place_of_srbms():
    client = RecordedClient()
    scene = Scene(client)
    scene.draw(picture("anymal", {"ellipsoids"}))
    assert {"/ellipsoid/planned", "/ellipsoid/srbm"} < client.scene.seen()
    clip = scene.draw(picture("anymal", {"ellipsoids"}, simulation=True))
    assert "/ellipsoid/srbm" not in client.scene.seen()
    time, _ = track_of(clip, "/ellipsoid/whole/wires")
    assert time is picture("anymal", simulation=True).simulated.time
    scene.draw(picture("anymal", (), simulation=True))
    assert not [name for name in client.scene.seen() if name.startswith("/ellipsoid")]
