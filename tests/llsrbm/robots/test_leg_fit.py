import logging
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.leg_fit import truth
from llsrbm.cache import ENVIRONMENT_VARIABLE
from llsrbm.errors import RobotFileError
from llsrbm.robots import build_robot, load_robot
from llsrbm.robots.leg_fit import fit_legs, load_or_fit
from llsrbm.robots.leg_maps import (
    affine_features,
    affine_slopes,
    quadratic_features,
    quadratic_slopes,
)
from tests.llsrbm.robots.test_robot import ANYMAL


@pytest.mark.parametrize("name", ["anymal", "go2"])
def test_maps_are_true_of_every_quadruped(name):
    """Against Pinocchio, feet anywhere in the reach box and moving at random."""
    robot = load_robot(name)
    found = truth(robot, fit_legs(robot), count=150)
    assert found.inertia[2] < 0.02
    assert found.momentum[2] < 0.03
    assert found.base_offset < 0.015 * np.linalg.norm(robot.feet - robot.com, axis=1).mean()


def test_maps_are_true_of_sliding_legs_with_soles():
    """About every axis, soles turning at random: the legs are five times the pelvis in pitch."""
    robot = load_robot("slider")
    found = truth(robot, fit_legs(robot), count=150)
    assert (found.inertia < 0.02).all()
    assert (found.momentum < 0.03).all()
    assert found.base_offset < 0.008


def test_anymals_maps_beat_the_papers_rule():
    fit = fit_legs(load_robot("anymal"))
    error = fit.residuals
    assert error["com_quadratic"] < 0.6 * error["com_affine"] < 0.2 * error["com_proportional"]
    assert error["com_quadratic_slope"] < error["com_affine_slope"]
    # The paper's point mass, as the prototypes measured it: 1.98 kg at 62 % of the way up.
    assert fit.proportional_mass == pytest.approx(1.983, abs=1e-3)
    assert fit.proportional_fraction == pytest.approx(0.6225, abs=1e-3)


@pytest.mark.parametrize("name", ["anymal", "slider"])
def test_masses_add_up(name):
    robot = load_robot(name)
    fit = fit_legs(robot, samples=400)
    assert fit.trunk_mass + len(robot.legs) * fit.leg_mass == pytest.approx(robot.mass)
    assert np.linalg.eigvalsh(fit.trunk_inertia).min() > 0
    for row in fit.inertia_map:
        np.testing.assert_allclose(row.reshape(3, 3), row.reshape(3, 3).T, atol=1e-9)
    # In mirrored axes all legs stand alike: the map's inertia there is a body's.
    seen = robot.mirrors * (robot.feet - robot.base_position - robot.hips)
    x = np.append(seen[0], np.zeros(robot.foot_coordinates - 3))
    features = affine_features(x) if len(fit.inertia_map) == 1 + len(x) else quadratic_features(x)
    standing = (features @ fit.inertia_map).reshape(3, 3)
    assert np.linalg.eigvalsh(standing).min() > 0


@pytest.mark.parametrize("coordinates", [3, 4])
def test_slopes_are_the_features_derivatives(coordinates):
    rng = np.random.default_rng(0)
    x, step = rng.uniform(-0.5, 0.5, size=(20, coordinates)), 1e-6
    for k in range(coordinates):
        d = step * np.eye(coordinates)[k]
        slope = (quadratic_features(x + d) - quadratic_features(x - d)) / (2 * step)
        np.testing.assert_allclose(quadratic_slopes(x)[:, :, k], slope, atol=1e-8)
    np.testing.assert_array_equal(affine_slopes(x)[3, 1:], np.eye(coordinates))


def test_a_reach_box_the_legs_cannot_reach_is_refused(tmp_path):
    path = tmp_path / "giant.toml"
    text = ANYMAL.replace("distance = [0.26, 0.52]", "distance = [1.0, 1.2]")
    text = text.replace("lower = [-0.22, -0.20, -0.56]", "lower = [-0.22, -0.20, -1.2]")
    path.write_text(text)
    with pytest.raises(RobotFileError, match=r"giant\.toml: reach: .* reach only 0 of"):
        fit_legs(build_robot(path))


def test_a_fit_is_cached_and_a_damaged_one_made_anew(tmp_path, monkeypatch, caplog):
    monkeypatch.setenv(ENVIRONMENT_VARIABLE, str(tmp_path))
    robot = load_robot("anymal")
    fitted = load_or_fit(robot)
    (entry,) = (tmp_path / "leg-fits-anymal").iterdir()
    control = robot.file.control.model_copy(update={"gains": None, "rate": 1.0})
    edited = replace(robot, file=robot.file.model_copy(update={"control": control}))
    with monkeypatch.context() as patch:
        patch.setattr("llsrbm.robots.leg_fit.fit_legs", None)
        stored = load_or_fit(robot)
        load_or_fit(edited)  # a gain is of no leg
    for name, value in vars(fitted).items():
        np.testing.assert_equal(getattr(stored, name), value)
        assert type(getattr(stored, name)) is type(value)
    content = entry.read_bytes()
    entry.write_bytes(content[: len(content) // 2])
    with caplog.at_level(logging.WARNING):
        np.testing.assert_array_equal(load_or_fit(robot).spin_map, fitted.spin_map)
    assert "damaged" in caplog.text
    assert entry.read_bytes() == content
