"""What every model promises, on random feet."""

import json

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import root

from llsrbm import models
from llsrbm.models.base import point_inertia
from tests.llsrbm.models.postures import (
    ROBOT,
    SLIDER,
    evaluate,
    feet_in_reach,
    feet_of,
    random_motions,
    rates,
)

MODELS = {
    (robot, name): models.make_model(name, robot)
    for robot in (ROBOT, SLIDER)
    for name in models.MODELS
}
every_model = pytest.mark.parametrize(
    ("robot", "model"),
    [pytest.param(robot, m, id=f"{robot.name}-{name}") for (robot, name), m in MODELS.items()],
)
quickly = settings(max_examples=10, deadline=None)


def column(matrix) -> np.ndarray:
    return np.array(ca.DM(matrix)).ravel()


def dm(feet) -> ca.DM:
    return ca.DM(feet.T)


def full_mirrors(model) -> np.ndarray:
    """(L, d): a yaw turns the other way in every mirror."""
    turn = model.mirrors.prod(axis=1, keepdims=True)
    return np.hstack([model.mirrors, turn])[:, : model.coordinates]


def padded(model, place) -> np.ndarray:
    """(..., d): a place with no yaw."""
    return place @ np.eye(3, model.coordinates)


def everyone(model) -> tuple[int, ...]:
    return tuple(range(model.legs))


def test_point_inertia_is_the_parallel_axis_theorem():
    d = np.array([0.3, -0.2, 0.5])
    cross = np.cross(np.eye(3), d)
    np.testing.assert_allclose(np.array(point_inertia(ca.DM(d))), cross @ cross.T, atol=1e-15)


@every_model
@quickly
@given(data=st.data())
def test_offset_from_feet_in_hip_and_from_com_are_one_map(robot, model, data):
    x = data.draw(feet_in_reach(robot))
    offset = model.base_offset(dm(x))
    places = [column(model.foot_from_com(i, dm(x)[:, i], offset)) for i in range(len(x))]
    yaws = full_mirrors(model)[:, 3:] * x[:, 3:]
    beta = dm(np.hstack([places, yaws]))
    from_com = model.offset_map(everyone(model))(dict(enumerate(ca.horzsplit(beta))))
    np.testing.assert_allclose(column(from_com), column(offset), atol=1e-12)
    for i in range(len(x)):
        seen = model.foot_in_hip(i, beta[:, i], offset)
        np.testing.assert_allclose(column(seen), x[i], atol=1e-12)


@every_model
@quickly
@given(data=st.data())
def test_where_some_feet_stand_the_coms_definition_gives_the_offset(robot, model, data):
    """Solved numerically for o; standing feet are known from the CoM, the others from the hip."""
    x = data.draw(feet_in_reach(robot))
    standing = np.array(data.draw(st.tuples(*[st.booleans()] * model.legs)))
    offset = column(model.base_offset(dm(x)))
    beta = padded(model, offset + model.hips) + full_mirrors(model) * x
    given_ = np.where(standing[:, None], beta, x)

    def definition(o):
        seen = full_mirrors(model) * (given_ - padded(model, o + model.hips))
        return o - column(model.base_offset(dm(np.where(standing[:, None], seen, x))))

    found = root(definition, np.zeros(3), tol=1e-13)
    assert np.abs(definition(found.x)).max() < 1e-12  # `success` asks for more than rounding allows
    some = model.offset_map(tuple(np.flatnonzero(standing)))
    np.testing.assert_allclose(
        column(some(dict(enumerate(map(ca.DM, given_))))), found.x, atol=1e-9
    )
    np.testing.assert_allclose(feet_of(model, given_[None], standing)[0], x, atol=1e-9)


@every_model
@quickly
@given(data=st.data())
def test_rate_is_the_slope_of_the_offset(robot, model, data):
    x = data.draw(feet_in_reach(robot))
    xdot = data.draw(rates(robot=robot))
    step = 1e-3  # exact: the map is affine
    slope = (model.base_offset(dm(x + step * xdot)) - model.base_offset(dm(x))) / step
    rate = model.offset_map(()).rate(dict(enumerate(ca.horzsplit(dm(xdot)))))
    np.testing.assert_allclose(column(rate), column(slope), atol=1e-10)


@every_model
@quickly
@given(data=st.data())
def test_a_body_whose_feet_rest_in_it_has_the_momentum_of_its_inertia(robot, model, data):
    """R^T L = I omega (eq. 4), however a model computes it."""
    x = dm(data.draw(feet_in_reach(robot)))
    omega = ca.DM(data.draw(st.tuples(*[st.floats(-10, 10)] * 3)))
    offset = model.base_offset(x)
    momentum = model.angular_momentum(x, 0 * x, omega, offset)
    expected = ca.mtimes(model.inertia(x, offset), omega)
    np.testing.assert_allclose(column(momentum), column(expected), atol=1e-9)


@every_model
def test_numbers_are_plain_data_that_tell_robots_apart(robot, model):
    text = json.dumps(model.numbers(), sort_keys=True)
    again = models.make_model(model.name, robot)
    assert json.dumps(again.numbers(), sort_keys=True) == text
    others = [json.dumps(m.numbers(), sort_keys=True) for m in MODELS.values() if m is not model]
    assert text not in others


@pytest.mark.parametrize(("robot", "bounds"), [(ROBOT, (0.01, 0.025)), (SLIDER, (0.005, 0.06))])
def test_offset_is_where_the_base_is(robot, bounds):
    """The affine maps put the base to within millimetres; the paper's rule to within 2 cm.

    On SLIDER to 5 cm: not the whole leg shortens with the distance of the foot.
    """
    motions = random_motions(100, seed=1, robot=robot)
    beta = np.array([m.beta for m in motions])
    true = np.array([m.offset for m in motions])
    worst = {}
    for name in models.MODELS:
        model = MODELS[robot, name]
        offset = evaluate(model, feet_of(model, beta))[0]
        worst[name] = np.linalg.norm(offset - true, axis=1).max()
    assert worst["llsrbm-plus"] < bounds[0]
    assert worst["llsrbm"] < bounds[1]
    assert worst["srbm"] < bounds[1]
    assert worst["llsrbm-plus"] < worst["llsrbm"]
