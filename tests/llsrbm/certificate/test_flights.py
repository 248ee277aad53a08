"""Motions without forces: whether they fall as they must while no foot touches the ground."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import llsrbm
from llsrbm.library import shipped
from llsrbm.robots import load_robot

FPS = 50.0
NAMES = ["go2-together-0001", "g1-pirouette-0001", "slider-hops-0001"]


@pytest.fixture(scope="module")
def clips(tmp_path_factory):
    """Name -> (robot, qpos) of motions at `FPS`."""
    found, library = {}, shipped()
    for name in NAMES:
        plan = library.open(name, check=False)
        path = tmp_path_factory.mktemp(name) / "clip.npz"
        llsrbm.export(plan, path, format="motion-npz", fps=FPS)
        found[name] = plan.jump.robot, llsrbm.load_motion(path, plan.jump.robot).qpos
    return found


@pytest.fixture
def dynamics(tmp_path):
    """What the check finds in a clip of a robot at so many frames/s."""

    def found(robot, qpos, fps=FPS):
        path = tmp_path / "clip.npz"
        joints = load_robot(robot).joint_names
        np.savez(path, qpos=qpos, fps=fps, joint_names=np.array(joints))
        return llsrbm.certify(llsrbm.load_motion(path, robot))["dynamics"]

    return found


@pytest.mark.parametrize("name", NAMES)
def test_what_falls_as_it_must_is_not_known_otherwise(clips, dynamics, name):
    assert dynamics(*clips[name]).holds is None


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("longer", [0.8, 1.3])
def test_a_flight_that_lasts_longer_or_less_breaks_it(clips, dynamics, name, longer):
    """It falls by g over the square of how much longer it lasts."""
    found = dynamics(*clips[name], FPS / longer)
    assert found.holds is False
    assert found.worst == pytest.approx(abs(1 - 1 / longer**2), abs=0.02)
    assert found.where == "force in flight"


def test_a_turn_that_nothing_makes_breaks_it(clips, dynamics):
    robot, qpos = clips["go2-together-0001"]
    time = np.arange(len(qpos)) / FPS
    turned = qpos.copy()
    begin = int(np.argmax(qpos[:, 2])) - 8  # about the apex
    late = np.maximum(time - time[begin], 0.0)
    own = Rotation.from_quat(qpos[:, 3:7], scalar_first=True)
    faster = Rotation.from_rotvec(np.outer(20.0 * late**2, [0.0, 0.0, 1.0])) * own
    turned[:, 3:7] = faster.as_quat(scalar_first=True)
    found = dynamics(robot, turned)
    assert found.holds is False
    assert found.where == "moment in flight"


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("name", NAMES)
def test_noise_does_not_break_it(clips, dynamics, name, seed):
    """As of a camera: 5 mrad a joint, 2 mm of the base, each frame anew."""
    rng = np.random.default_rng(seed)
    robot, qpos = clips[name]
    noisy = qpos.copy()
    noisy[:, 7:] += 5e-3 * rng.standard_normal(noisy[:, 7:].shape)
    noisy[:, :3] += 2e-3 * rng.standard_normal((len(qpos), 3))
    assert dynamics(robot, noisy).holds is None


def test_who_stands_still_has_no_flight(clips, dynamics):
    robot, qpos = clips["go2-together-0001"]
    assert dynamics(robot, np.repeat(qpos[:1], 60, axis=0)).holds is None
