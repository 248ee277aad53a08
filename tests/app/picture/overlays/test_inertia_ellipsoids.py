from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from app.picture.scene import Scene
from llsrbm.robots import load_robot
from tests.app.picture.pictures import picture
from tests.app.picture.recorded import RecordedClient, track_of


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
    assert track.nodes == ("/ellipsoid/planned/wires", "/ellipsoid/planned/surface")
    motion = shown.planned.motion
    for frame in (0, 30, 60):
        expected = motion.inertia[frame]
        assert inertia(robot.mass, track, frame) == pytest.approx(expected, rel=1e-6, abs=1e-6)
        assert track.position[frame] == pytest.approx(motion.com[frame])
    _, rigid = track_of(clip, "/ellipsoid/srbm/wires")
    assert inertia(robot.mass, rigid, 0) == pytest.approx(robot.inertia, rel=1e-6, abs=1e-6)


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
