"""How true the fitted leg maps are: a robot a line, against Pinocchio.

    python benchmarks/leg_fit.py

Random feet anywhere in the reach box, every leg for itself, moving at random while the base turns;
the centroidal inertia and angular momentum by the formulas of LL-SRBM+ against those of the whole
robot in the same posture with the same joint speeds. A plan's motions are tamer than these.
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

from llsrbm.robots import Robot, load_robot
from llsrbm.robots.leg_fit import (
    LegFit,
    affine_features,
    fit_legs,
    quadratic_features,
    quadratic_slopes,
)
from llsrbm.robots.legs import parallel_axis, solve_legs

ROBOTS = ("anymal", "go2", *sorted(map(str, (Path(__file__).parent / "robots").glob("*.toml"))))
YAW_RATE = 3.0  # rad/s, largest
FOOT_SPEED = 1.0  # m/s relative to the hip, largest on each axis


@dataclass(frozen=True)
class Truth:
    """Errors over random motions: of inertia and momentum about z, and where the base is.

    Attributes:
        inertia_zz: RMS error relative to the true value.
        momentum_z: RMS error relative to the largest momentum; momentum_z_worst: largest error.
        base_offset: RMS error of the base's place relative to the CoM, m.
    """

    inertia_zz: float
    momentum_z: float
    momentum_z_worst: float
    base_offset: float


def plus_inertia_and_momentum(fit: LegFit, beta, beta_rate):
    """LL-SRBM+ in NumPy, as `models/` has it in CasADi: I, h and o of one posture, base frame.

    Args:
        fit: the leg maps.
        beta, beta_rate: (L, 3) m, m/s: feet from the CoM, and their velocity in the base frame.
    """
    mirror = [np.diag(m) for m in fit.mirrors]
    w1 = fit.com_affine[1:].T
    mapped = [m @ w1 @ m for m in mirror]
    a = -fit.total_mass * np.eye(3) + fit.leg_mass * sum(mapped)
    k = fit.trunk_mass * fit.trunk_com + fit.leg_mass * sum(
        h + m @ fit.com_affine[0] - w @ h for h, m, w in zip(fit.hips, mirror, mapped, strict=True)
    )
    o = np.linalg.solve(a, k + fit.leg_mass * sum(map(np.matmul, mapped, beta)))
    o_rate = np.linalg.solve(a, fit.leg_mass * sum(map(np.matmul, mapped, beta_rate)))
    inertia = fit.trunk_inertia + fit.trunk_mass * parallel_axis(fit.trunk_com + o)
    h = np.zeros(3)
    for hip, m, b, b_rate in zip(fit.hips, mirror, beta, beta_rate, strict=True):
        x, x_rate = m @ (b - o - hip), m @ (b_rate - o_rate)
        arm = hip + m @ (quadratic_features(x) @ fit.com_quadratic) + o
        slope = fit.com_quadratic.T @ quadratic_slopes(x)
        own = (affine_features(x) @ fit.inertia_map).reshape(3, 3)
        spin = (affine_features(x) @ fit.spin_map).reshape(3, 3)
        inertia = inertia + fit.leg_mass * parallel_axis(arm) + m @ own @ m
        h = h + fit.leg_mass * np.cross(arm, m @ slope @ x_rate)
        h = h + np.linalg.det(m) * m @ spin @ x_rate
    return inertia, h, o


def random_feet(robot: Robot, count: int, rng: np.random.Generator):
    """(count, L, 3) m: feet in the mirrored hip frame, within the robot file's reach."""
    reach = robot.file.reach
    drawn = rng.uniform(reach.lower, reach.upper, size=(60 * count, 3))
    distance = np.linalg.norm(drawn, axis=1)
    drawn = drawn[(distance >= reach.distance[0]) & (distance <= reach.distance[1])]
    return drawn[: count * len(robot.legs)].reshape(count, len(robot.legs), 3)


def truth(robot: Robot, fit: LegFit, count: int = 300, seed: int = 1) -> Truth:
    """Compare the maps with Pinocchio on random postures and velocities."""
    rng = np.random.default_rng(seed)
    feet = robot.hips + robot.mirrors * random_feet(robot, count, rng)
    angles = np.array([robot.file.posture[leg.name] for leg in robot.legs])
    q_legs, error = solve_legs(robot.chains, feet, angles)
    jacobian = robot.chains.motion(q_legs).foot_jacobian
    usable = (error < 1e-7).all(axis=1) & (np.linalg.cond(jacobian) < 30).all(axis=1)
    data = robot.model.createData()
    rows = []
    for q_leg, jac in zip(q_legs[usable], jacobian[usable], strict=True):
        speeds = rng.uniform(-FOOT_SPEED, FOOT_SPEED, size=(len(robot.legs), 3))
        q, v = pin.neutral(robot.model), np.zeros(robot.model.nv)
        omega = np.array([0.0, 0.0, rng.uniform(-YAW_RATE, YAW_RATE)])
        v[3:6] = omega
        for i, leg in enumerate(robot.legs):
            q[leg.q_index] = q_leg[i]
            v[leg.v_index] = np.linalg.solve(jac[i], speeds[i])
        pin.ccrba(robot.model, data, q, v)
        pin.updateFramePlacements(robot.model, data)
        com, com_rate = data.com[0].copy(), data.hg.linear / robot.mass
        foot = np.array([data.oMf[leg.foot_frame_id].translation for leg in robot.legs])
        beta = foot - com
        # Relative to the base, the CoM moves by what the legs alone do.
        beta_rate = speeds - (com_rate - np.cross(omega, com))
        inertia, h, o = plus_inertia_and_momentum(fit, beta, beta_rate)
        rows.append(
            [
                data.Ig.inertia[2, 2],
                inertia[2, 2] / data.Ig.inertia[2, 2] - 1,
                data.hg.angular[2],
                (inertia @ omega + h - data.hg.angular)[2],
                np.linalg.norm(o + com),
            ]
        )
    _, relative, momentum, momentum_error, offset = np.array(rows).T
    peak = np.abs(momentum).max()
    return Truth(
        inertia_zz=float(np.sqrt(np.mean(relative**2))),
        momentum_z=float(np.sqrt(np.mean(momentum_error**2)) / peak),
        momentum_z_worst=float(np.abs(momentum_error).max() / peak),
        base_offset=float(np.sqrt(np.mean(offset**2))),
    )


def main() -> None:
    print(
        "robot       fit    c quadratic  affine   I_c      S        base    Izz RMS  "
        "Lz RMS / max of peak"
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
            f"{1e3 * t.base_offset:6.1f} mm {100 * t.inertia_zz:6.2f} % "
            f"{100 * t.momentum_z:7.2f} / {100 * t.momentum_z_worst:.1f} %"
        )


if __name__ == "__main__":
    main()
