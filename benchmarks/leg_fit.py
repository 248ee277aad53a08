"""How true the fitted leg maps are: a robot a line, against Pinocchio.

    python benchmarks/leg_fit.py

Random feet anywhere in the reach box (soles at any yaw), every leg for itself, moving at random
while the base turns; the centroidal inertia and angular momentum of LL-SRBM+ against
those of the whole robot in the same posture with the same joint speeds. A plan's motions are tamer.
"""

import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

from llsrbm.mechanics import skew, turns_about_z
from llsrbm.robots import Robot, load_robot, names
from llsrbm.robots.leg_fit import fit_legs
from llsrbm.robots.leg_maps import LegFit, affine_features, quadratic_features, quadratic_slopes
from llsrbm.robots.legs import TURN_ARM, foot_task, solve_legs

ROBOTS = (*names(), *sorted(map(str, (Path(__file__).parent / "robots").glob("*.toml"))))
RATES = (1.0, 1.0, 3.0)  # rad/s of the base about its axes, largest
FOOT_TURN = 5.0  # rad/s of a sole against the base, largest
FOOT_SPEED = 1.0  # m/s relative to the hip, largest on each axis


@dataclass(frozen=True)
class Truth:
    """Errors over random motions: of inertia and momentum about z, and where the base is.

    Attributes:
        inertia: (3,) RMS error of Ixx, Iyy and Izz relative to the true value.
        momentum: (3,) RMS error relative to the largest momentum; momentum_worst: largest error.
        base_offset: RMS error of the base's place relative to the CoM, m.
    """

    inertia: np.ndarray
    momentum: np.ndarray
    momentum_worst: np.ndarray
    base_offset: float


def parallel_axis(d):
    """Inertia of a unit mass at d."""
    return skew(d) @ skew(d).T


def plus_inertia_and_momentum(fit: LegFit, beta, beta_rate):
    """LL-SRBM+ in NumPy, as `models/` has it in CasADi: I, h and o of one posture, base frame.

    Args:
        fit: the leg maps.
        beta, beta_rate: (L, d) m, m/s: feet from the CoM, and their velocity in the base frame; the
            fourth column their yaw, rad, and its rate.
    """
    mirror = [np.diag(np.append(m, np.prod(m))[: beta.shape[1]]) for m in fit.mirrors]
    w1 = fit.com_affine[1:].T
    mapped = [m[:3, :3] @ w1 @ m for m in mirror]
    a = -fit.total_mass * np.eye(3) + fit.leg_mass * sum(w[:, :3] for w in mapped)
    k = fit.trunk_mass * fit.trunk_com + fit.leg_mass * sum(
        h + m * fit.com_affine[0] - w[:, :3] @ h
        for h, m, w in zip(fit.hips, fit.mirrors, mapped, strict=True)
    )
    o = np.linalg.solve(a, k + fit.leg_mass * sum(map(np.matmul, mapped, beta)))
    o_rate = np.linalg.solve(a, fit.leg_mass * sum(map(np.matmul, mapped, beta_rate)))
    inertia = fit.trunk_inertia + fit.trunk_mass * parallel_axis(fit.trunk_com + o)
    h = np.zeros(3)
    padding = np.eye(beta.shape[1], 3)
    for hip, mirrored, b, b_rate in zip(fit.hips, mirror, beta, beta_rate, strict=True):
        x, x_rate = mirrored @ (b - padding @ (o + hip)), mirrored @ (b_rate - padding @ o_rate)
        m = mirrored[:3, :3]
        arm = hip + m @ (quadratic_features(x) @ fit.com_quadratic) + o
        slope = fit.com_quadratic.T @ quadratic_slopes(x)
        affine = len(fit.inertia_map) == 1 + len(x)
        features = affine_features(x) if affine else quadratic_features(x)
        own = (features @ fit.inertia_map).reshape(3, 3)
        spin = (features @ fit.spin_map).reshape(3, -1)
        inertia = inertia + fit.leg_mass * parallel_axis(arm) + m @ own @ m
        h = h + fit.leg_mass * np.cross(arm, m @ slope @ x_rate)
        h = h + np.linalg.det(m) * m @ spin @ x_rate
    return inertia, h, o


def random_feet(robot: Robot, count: int, rng: np.random.Generator):
    """(count, L, d): feet in the mirrored hip frame, within the robot file's reach and yaw."""
    reach, (out, back) = robot.file.reach, robot.file.foot.yaw
    d = robot.foot_coordinates
    lower, upper = [*reach.lower, out][:d], [*reach.upper, back][:d]
    drawn = rng.uniform(lower, upper, size=(60 * count, d))
    distance = np.linalg.norm(drawn[:, :3], axis=1)
    drawn = drawn[(distance >= reach.distance[0]) & (distance <= reach.distance[1])]
    return drawn[: count * len(robot.legs)].reshape(count, len(robot.legs), d)


def truth(robot: Robot, fit: LegFit, count: int = 300, seed: int = 1) -> Truth:
    """Compare the maps with Pinocchio on random postures and velocities."""
    rng = np.random.default_rng(seed)
    x = random_feet(robot, count, rng)
    feet = robot.hips + robot.mirrors * x[..., :3]
    yaw = robot.mirrors.prod(axis=1)[:, None] * x[..., 3:]  # no columns of point feet
    soles = turns_about_z(yaw[..., 0]) if yaw.size else None
    angles = np.array([robot.file.posture[leg.name] for leg in robot.legs])
    q_legs, error = solve_legs(robot.chains, feet, angles, soles)
    _, jacobian = foot_task(robot.chains.motion(q_legs, rotations=soles is not None), feet, soles)
    usable = (error < 1e-7).all(axis=1) & (np.linalg.cond(jacobian) < 30).all(axis=1)
    data = robot.model.createData()
    rows = []
    for q_leg, jac, foot_yaw in zip(q_legs[usable], jacobian[usable], yaw[usable], strict=True):
        speeds = rng.uniform(-FOOT_SPEED, FOOT_SPEED, size=(len(robot.legs), 3))
        turns = rng.uniform(-FOOT_TURN, FOOT_TURN, size=foot_yaw.shape)
        level = np.zeros((len(turns), 2 * turns.shape[1]))
        wanted = np.hstack([speeds, level, TURN_ARM * turns])
        q, v = pin.neutral(robot.model), np.zeros(robot.model.nv)
        omega = rng.uniform(-1, 1, size=3) * RATES
        v[3:6] = omega
        for i, leg in enumerate(robot.legs):
            q[leg.q_index] = q_leg[i]
            v[leg.v_index] = np.linalg.solve(jac[i], wanted[i])
        pin.ccrba(robot.model, data, q, v)
        pin.updateFramePlacements(robot.model, data)
        com, com_rate = data.com[0].copy(), data.hg.linear / robot.mass
        foot = np.array([data.oMf[leg.foot_frame_id].translation for leg in robot.legs])
        beta = np.hstack([foot - com, foot_yaw])
        # Relative to the base, the CoM moves by what the legs alone do.
        beta_rate = np.hstack([speeds - (com_rate - np.cross(omega, com)), turns])
        inertia, h, o = plus_inertia_and_momentum(fit, beta, beta_rate)
        true = np.diag(data.Ig.inertia)
        momentum_error = inertia @ omega + h - data.hg.angular
        rows.append([np.diag(inertia) / true - 1, data.hg.angular.copy(), momentum_error, o + com])
    relative, momentum, momentum_error, offset = np.array(rows).transpose(1, 0, 2)
    peak = np.abs(momentum).max(axis=0)
    return Truth(
        inertia=_rms(relative),
        momentum=_rms(momentum_error) / peak,
        momentum_worst=np.abs(momentum_error).max(axis=0) / peak,
        base_offset=float(np.linalg.norm(_rms(offset))),
    )


def _rms(rows):
    return np.sqrt(np.mean(rows**2, axis=0))


def _percent(values) -> str:
    return " ".join(f"{100 * value:5.2f}" for value in values)


def main() -> None:
    print(
        "robot       fit    c quadratic  affine   I_c      S        base    "
        "Ixx, Iyy, Izz RMS      Lx, Ly, Lz RMS / max of peak"
    )
    for name in sys.argv[1:] or ROBOTS:
        robot = load_robot(name)
        start = time.perf_counter()
        fit = fit_legs(robot)
        seconds = time.perf_counter() - start
        t, r = truth(robot, fit), fit.residuals
        print(
            f"{robot.name:10s} {seconds:5.2f} s {1e3 * r['com_quadratic']:8.1f} mm "
            f"{1e3 * r['com_affine']:7.1f} mm {r['inertia']:8.5f} {r['spin']:8.5f} "
            f"{1e3 * t.base_offset:6.1f} mm {_percent(t.inertia)} %   "
            f"{_percent(t.momentum)} / {_percent(t.momentum_worst)} %"
        )


if __name__ == "__main__":
    main()
