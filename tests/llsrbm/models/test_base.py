"""What every model promises, on random feet."""

import json

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings

from llsrbm import models
from llsrbm.models.base import point_inertia
from tests.llsrbm.models.postures import LEGS, ROBOT, feet_in_reach, random_motions, rates, vectors

MODELS = {name: models.make_model(name, ROBOT) for name in models.names()}
every_model = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
quickly = settings(max_examples=40, deadline=None)


def column(matrix) -> np.ndarray:
    return np.array(ca.DM(matrix)).ravel()


def dm(feet) -> ca.DM:
    return ca.DM(feet.T)


def test_point_inertia_is_the_parallel_axis_theorem():
    d = np.array([0.3, -0.2, 0.5])
    cross = np.cross(np.eye(3), d)
    np.testing.assert_allclose(np.array(point_inertia(ca.DM(d))), cross @ cross.T, atol=1e-15)


@every_model
@quickly
@given(x=feet_in_reach())
def test_offset_from_feet_in_hip_and_from_com_are_one_map(model, x):
    offset = model.base_offset(dm(x))
    beta = [model.foot_from_com(i, dm(x)[:, i], offset) for i in range(LEGS)]
    np.testing.assert_allclose(
        column(model.base_offset_from_com(ca.horzcat(*beta))), column(offset), atol=1e-12
    )
    for i, b in enumerate(beta):
        np.testing.assert_allclose(column(model.foot_in_hip(i, b, offset)), x[i], atol=1e-12)


@every_model
@quickly
@given(xdot=rates())
def test_their_rates_too(model, xdot):
    rate = model.base_offset_rate(dm(xdot))
    beta_rate = ca.horzcat(*[rate + ca.DM(m) * ca.DM(v) for m, v in zip(model.mirrors, xdot)])
    from_com = model.base_offset_rate_from_com(beta_rate)
    np.testing.assert_allclose(column(from_com), column(rate), atol=1e-12)


@every_model
@quickly
@given(x=feet_in_reach(), xdot=rates())
def test_rate_is_the_slope_of_the_offset(model, x, xdot):
    step = 1e-3  # exact: the map is affine
    slope = (model.base_offset(dm(x + step * xdot)) - model.base_offset(dm(x))) / step
    np.testing.assert_allclose(column(model.base_offset_rate(dm(xdot))), column(slope), atol=1e-10)


@every_model
@quickly
@given(x=feet_in_reach(), xdot=rates())
def test_numpy_says_what_casadi_says(model, x, xdot):
    offset, rate = model.offsets(x[None], xdot[None])
    np.testing.assert_allclose(offset[0], column(model.base_offset(dm(x))), atol=1e-13)
    np.testing.assert_allclose(rate[0], column(model.base_offset_rate(dm(xdot))), atol=1e-13)
    beta = offset[:, None] + model.hips + model.mirrors * x
    beta_rate = rate[:, None] + model.mirrors * xdot
    np.testing.assert_allclose(model.stance_feet(beta)[0], x, atol=1e-12)
    np.testing.assert_allclose(model.stance_rate(beta_rate)[0], xdot, atol=1e-12)


@every_model
@quickly
@given(x=feet_in_reach(), xdot=rates(), w=vectors())
def test_momentum_is_inertia_times_rate_plus_the_legs(model, x, xdot, w):
    offset = model.base_offset(dm(x))
    direct = ca.mtimes(model.inertia(dm(x), offset), ca.DM(w)) + model.legs_momentum(
        dm(x), dm(xdot), offset
    )
    whole = model.angular_momentum(dm(x), dm(xdot), ca.DM(w), offset)
    np.testing.assert_allclose(column(whole), column(direct), atol=1e-12)
    np.testing.assert_allclose(
        model.evaluate_momentum(x[None], xdot[None], w[None])[0], column(direct), atol=1e-12
    )


@every_model
@quickly
@given(x=feet_in_reach(), one=rates(), two=rates(), a=vectors(2.0))
def test_the_legs_momentum_is_linear_in_their_speed(model, x, one, two, a):
    offset = model.base_offset(dm(x))

    def h(rate):
        return column(model.legs_momentum(dm(x), dm(rate), offset))

    np.testing.assert_allclose(
        h(a[0] * one + a[1] * two), a[0] * h(one) + a[1] * h(two), atol=1e-11
    )


@every_model
@quickly
@given(x=feet_in_reach())
def test_inertia_is_a_bodys(model, x):
    """Symmetric, positive, and no axis heavier than the two others together."""
    inertia = np.array(ca.DM(model.inertia(dm(x), model.base_offset(dm(x)))))
    np.testing.assert_allclose(inertia, inertia.T, atol=1e-12)
    moments = np.linalg.eigvalsh(inertia)
    assert moments[0] > 0
    assert moments[0] + moments[1] >= moments[2]


@every_model
def test_many_configurations_at_once_as_symbols_one_by_one(model):
    rng = np.random.default_rng(3)
    reach = ROBOT.file.reach
    x = rng.uniform(reach.lower, reach.upper, size=(7, LEGS, 3))
    symbol = ca.SX.sym("x", 3, LEGS)
    o = model.base_offset(symbol)
    legs = [model.foot_from_com(i, model.leg_com(i, symbol[:, i]), o) for i in range(LEGS)]
    one = ca.Function("one", [symbol], [o, model.inertia(symbol, o), ca.horzcat(*legs)])
    offset, inertia, leg_com = model.evaluate(x)
    for k, feet in enumerate(x):
        expected = [np.array(out) for out in one(feet.T)]
        np.testing.assert_allclose(offset[k], expected[0].ravel(), atol=1e-13)
        np.testing.assert_allclose(inertia[k], expected[1], atol=1e-13)
        np.testing.assert_allclose(leg_com[k], expected[2].T, atol=1e-13)


@every_model
def test_mirror_images_mirror(model):
    """Left and right exchanged: inertia and momentum are those of the robot in the mirror."""
    rng = np.random.default_rng(4)
    reach = ROBOT.file.reach
    x = rng.uniform(reach.lower, reach.upper, size=(20, LEGS, 3))
    xdot, w = rng.normal(size=(20, LEGS, 3)), rng.normal(size=(20, 3))
    swap, flip = [1, 0, 3, 2], np.diag([1.0, -1.0, 1.0])
    offset, inertia, leg_com = model.evaluate(x)
    swapped = model.evaluate(x[:, swap])
    # The URDF itself is symmetric only to within a few grams and millimetres.
    np.testing.assert_allclose(swapped[0], offset @ flip, atol=3e-3)
    np.testing.assert_allclose(swapped[1], flip @ inertia @ flip, atol=0.03)
    np.testing.assert_allclose(swapped[2], (leg_com @ flip)[:, swap], atol=3e-3)
    momentum = model.evaluate_momentum(x, xdot, w)
    # Angular velocity and momentum are pseudovectors.
    there = model.evaluate_momentum(x[:, swap], xdot[:, swap], -w @ flip)
    np.testing.assert_allclose(there, -momentum @ flip, atol=0.1)


@every_model
def test_numbers_are_plain_data_that_tell_robots_apart(model):
    text = json.dumps(model.numbers(), sort_keys=True)
    again = models.make_model(model.name, ROBOT)
    assert json.dumps(again.numbers(), sort_keys=True) == text
    model.evaluate(np.zeros((1, LEGS, 3)))
    assert json.dumps(model.numbers(), sort_keys=True) == text
    others = [json.dumps(m.numbers(), sort_keys=True) for m in MODELS.values() if m is not model]
    assert text not in others


def test_offset_is_where_the_base_is():
    """The affine maps put the base to within millimetres; the paper's rule to within 2 cm."""
    motions = random_motions(100, seed=1)
    beta = np.array([m.beta for m in motions])
    true = np.array([m.offset for m in motions])
    worst = {}
    for name, model in MODELS.items():
        offset = model.evaluate(model.stance_feet(beta))[0]
        worst[name] = np.linalg.norm(offset - true, axis=1).max()
    assert worst["llsrbm-plus"] < 0.01
    assert worst["llsrbm"] < 0.025
    assert worst["srbm"] < 0.025
    assert worst["llsrbm-plus"] < worst["llsrbm"]
