"""The leg maps of a robot, fitted to postures of its URDF's legs (`llsrbm.robots.leg_maps`)."""

from __future__ import annotations

import json
import logging
from typing import Any

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.cache import cache_path, content_key, read_arrays, write_arrays
from llsrbm.errors import RobotFileError
from llsrbm.mechanics import turns_about_z
from llsrbm.robots.leg_maps import (
    LegFit,
    affine_features,
    affine_slopes,
    quadratic_features,
    quadratic_slopes,
)
from llsrbm.robots.legs import TURN_ARM, foot_task, solve_legs
from llsrbm.robots.robot import Robot

FIT_VERSION = "4"  # part of the cache key: raise it when a fit's numbers change
_NOT_OF_LEGS = {  # tables of a robot's file that no leg depends on
    *("title", "limits", "reserve", "drives", "timing", "task", "example"),
    *("control", "uncertainty", "turning", "planning", "link_pairs", "wire"),
}

_DERIVATIVE_WEIGHT = 0.1  # m: by how far a foot moves where its derivative counts as its value
_SINGULAR = 30.0  # condition of the foot's Jacobian beyond which a sample says little
# Plans keep the feet mostly about where they stand: sampling there more densely (a share of 0.85,
# `Reach.about_standing`, in a box of half the size) halves the error of planned jumps (Izz 2.6 ->
# 1.1 % at 0.3 m forward) and costs 0.1 % over the box as a whole. Samples beyond the box, on the
# other hand, made every figure worse.
_NEAR_SCALE = 0.5
_FEWEST_SAMPLES = 200

_log = logging.getLogger(__name__)


def fit_legs(robot: Robot, samples: int = 1600) -> LegFit:
    """Fit the leg maps to about `samples` postures of the robot's legs within its reach.

    `samples` foot positions are shared among the legs. Raises `RobotFileError`: too few places in
    the reach box can be reached by the legs.
    """
    x, com, com_slope, inertia, spin = _sample(robot, samples)
    one, two = affine_features(x), quadratic_features(x)
    com_affine = _fit_with_slopes(one, affine_slopes(x), com, com_slope)
    com_quadratic = _fit_with_slopes(two, quadratic_slopes(x), com, com_slope)
    # The inertia of a leg whose parts slide goes with the square of their distance: affine maps are
    # 10 % wrong, quadratic ones 1 %. Of legs that fold at a knee quadratic maps are no better.
    features = two if robot.chains.prismatic.any() else one
    inertia, spin = inertia.reshape(len(x), -1), spin.reshape(len(x), -1)
    inertia_map, spin_map = _least_squares(features, inertia), _least_squares(features, spin)
    mass, fraction = _proportional(robot)
    trunk = robot.trunk
    return LegFit(
        total_mass=robot.mass,
        leg_mass=float(robot.chains.mass.mean()),
        trunk_mass=float(trunk.mass),
        trunk_com=trunk.lever.copy(),
        trunk_inertia=trunk.inertia.copy(),
        hips=robot.hips,
        mirrors=robot.mirrors,
        com_affine=com_affine,
        com_quadratic=com_quadratic,
        inertia_map=inertia_map,
        spin_map=spin_map,
        proportional_mass=mass,
        proportional_fraction=fraction,
        residuals={
            "com_affine": _rms(com - one @ com_affine),
            "com_affine_slope": _slope_error(com_slope, affine_slopes(x), com_affine),
            "com_quadratic": _rms(com - two @ com_quadratic),
            "com_quadratic_slope": _slope_error(com_slope, quadratic_slopes(x), com_quadratic),
            "com_proportional": _rms(com - (1.0 - fraction) * x[:, :3]),
            "inertia": _rms(inertia - features @ inertia_map),
            "spin": _rms(spin - features @ spin_map),
        },
    )


def load_or_fit(robot: Robot) -> LegFit:
    """The robot's leg maps from the user's cache, or fitted and put there."""
    tables = robot.file.model_dump_json(exclude=_NOT_OF_LEGS)
    key = content_key("leg fit", FIT_VERSION, robot.urdf.content, tables)
    path = cache_path(f"leg-fits-{robot.name}", key, ".npz")
    stored = read_arrays(path)
    if stored is not None:
        return _decode(stored)
    _log.info("fitting the legs of %s", robot.name)
    fit = fit_legs(robot)
    write_arrays(path, _encode(fit))
    return fit


def _sample(robot: Robot, samples: int) -> tuple[Array, Array, Array, Array, Array]:
    """Foot places x (S, d), c (S, 3), dc/dx (S, 3, d), I_c (S, 3, 3), S (S, 3, d), all mirrored."""
    chains, mirrors, hips = robot.chains, robot.mirrors, robot.hips
    turned = robot.foot_coordinates == 4
    drawn = _drawn(robot, samples, seed=0)
    det = mirrors.prod(axis=1)
    place, rotation = _places(robot, drawn)
    q, error = solve_legs(chains, place, _standing_angles(robot), rotation)
    _, jacobian = foot_task(chains.motion(q, rotations=turned), place, rotation)
    masses = chains.masses(q)
    good = (error < 1e-7) & (np.linalg.cond(jacobian) < _SINGULAR)
    if good.sum() < min(samples, _FEWEST_SAMPLES) / 2:
        raise RobotFileError(
            f"{robot.path}: reach: the legs reach only {good.sum()} of {good.size} places drawn "
            "from the box; expected a box in the mirrored hip frame that the feet can reach"
        )
    # A leg's rates follow from its foot's velocity, least-norm for joints to spare: dq = J^-1 M dx,
    # where a sole stays level and turns about the vertical alone.
    rates = np.linalg.pinv(jacobian)[..., :3] * mirrors[:, None, :]
    if turned:
        turning = np.linalg.pinv(jacobian)[..., 5:] * TURN_ARM * det[:, None, None]
        rates = np.concatenate([rates, turning], axis=-1)
    flip = mirrors[:, :, None]
    det = det[:, None, None]
    return (
        drawn[good],
        (mirrors * (masses.com - hips))[good],
        (flip * (masses.com_jacobian @ rates))[good],
        (flip * masses.inertia * mirrors[:, None, :])[good],
        (det * flip * (masses.spin @ rates))[good],
    )


def sampled_legs(robot: Robot, samples: int, seed: int) -> tuple[Array, Array]:
    """Foot places x (S, L, d) m, rad drawn from the reach, and the joint angles there (S, L, n).

    Only places that all legs reach.
    """
    drawn = _drawn(robot, samples * len(robot.legs), seed)
    place, rotation = _places(robot, drawn)
    q, error = solve_legs(robot.chains, place, _standing_angles(robot), rotation)
    good = (error < 1e-7).all(axis=1)
    return drawn[good], q[good]


def _standing_angles(robot: Robot) -> Array:
    return np.array([robot.file.posture[leg.name] for leg in robot.legs])


def _places(robot: Robot, drawn: Array) -> tuple[Array, Array | None]:
    """Places (S, L, 3) m and attitudes (S, L, 3, 3) of soles, base frame, of x (S, L, d)."""
    mirrors = robot.mirrors
    place = robot.hips + mirrors * drawn[..., :3]
    if robot.foot_coordinates == 3:
        return place, None
    return place, turns_about_z(mirrors.prod(axis=1) * drawn[..., 3])


def _drawn(robot: Robot, samples: int, seed: int) -> Array:
    """Random x (S, L, d) m, rad within the reach, denser about the standing feet."""
    reach, mirrors, hips = robot.file.reach, robot.mirrors, robot.hips
    lower, upper = list(reach.lower), list(reach.upper)
    frames = robot.feet + np.array([0.0, 0.0, robot.foot_lift])
    standing = (mirrors * (frames - robot.base_position - hips)).mean(axis=0)
    if robot.foot_coordinates == 4:
        lower.append(robot.file.foot.yaw[0])
        upper.append(robot.file.foot.yaw[1])
        standing = np.append(standing, (mirrors.prod(axis=1) * robot.foot_yaw).mean())
    rng = np.random.default_rng(seed)
    drawn = rng.uniform(lower, upper, size=(40 * samples, len(lower)))
    near = rng.random(len(drawn)) < reach.about_standing
    drawn[near] = standing + _NEAR_SCALE * (drawn[near] - standing)
    distance = np.linalg.norm(drawn[:, :3], axis=1)
    drawn = drawn[(distance >= reach.distance[0]) & (distance <= reach.distance[1])]
    per_leg = min(len(drawn), samples) // len(robot.legs)
    drawn = drawn[: per_leg * len(robot.legs)].reshape(per_leg, len(robot.legs), -1)
    return np.asarray(drawn, dtype=np.float64)


def _fit_with_slopes(features: Array, slopes: Array, value: Array, derivative: Array) -> Array:
    """Least squares of a vector's value (S, 3) and derivative (S, 3, d) together."""
    w, d = _DERIVATIVE_WEIGHT, slopes.shape[-1]
    rows = np.vstack([features, *(w * slopes[:, :, k] for k in range(d))])
    right = np.vstack([value, *(w * derivative[:, :, k] for k in range(d))])
    return _least_squares(rows, right)


def _least_squares(rows: Array, right: Array) -> Array:
    return np.asarray(np.linalg.lstsq(rows, right)[0], dtype=np.float64)


def _proportional(robot: Robot) -> tuple[float, float]:
    """The paper's rule: mass from the hip joint outwards, on the line from foot to hip."""
    model, data = robot.model, robot.model.createData()
    pin.ccrba(model, data, robot.posture, np.zeros(model.nv))
    masses, fractions = [], []
    for leg in robot.legs:
        hip = model.getJointId(robot.file.legs[leg.name].hip)
        foot = pin.updateFramePlacement(model, data, leg.foot_frame_id).translation
        body, up = data.oYcrb[hip], data.oMi[hip].translation - foot
        masses.append(body.mass)
        fractions.append((body.lever - foot) @ up / (up @ up))
    return float(np.mean(masses)), float(np.mean(fractions))


def _slope_error(derivative: Array, slopes: Array, weights: Array) -> float:
    return _rms(derivative - np.einsum("nfk,fc->nck", slopes, weights))


def _rms(error: Array) -> float:
    return float(np.sqrt(np.mean(np.sum(error.reshape(len(error), -1) ** 2, axis=1))))


def _encode(fit: LegFit) -> dict[str, Any]:
    return {**vars(fit), "residuals": np.array(json.dumps(fit.residuals))}


def _decode(stored: dict[str, Any]) -> LegFit:
    residuals = json.loads(str(stored.pop("residuals")))
    values: dict[str, Any] = {n: a if a.ndim else float(a) for n, a in stored.items()}
    return LegFit(**values, residuals=residuals)
