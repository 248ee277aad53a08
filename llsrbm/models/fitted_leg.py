"""Any leg: joint angles and the columns of J as quadratic polynomials of its foot's place.

They are fitted over the robot file's reach by inverse kinematics, soles level.
"""

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.arrays import Array
from llsrbm.body.trunk_and_knees import knee_joint
from llsrbm.models.leg_drives import LegDrives, Matrix
from llsrbm.robots.leg_fit import sampled_legs
from llsrbm.robots.leg_maps import quadratic_features, quadratic_term_rates, quadratic_terms
from llsrbm.robots.robot import Robot

_SAMPLES, _SEED = 800, 0


class FittedLeg(LegDrives):
    """Quadratic polynomials of x for the joint angles, the columns of J, and the knee's place.

    Attributes:
        residuals: RMS errors over the samples: "angle" rad or m; "torque" share of the mean column;
            "knee" m, of legs that have one.
    """

    def __init__(
        self, angles: Array, jacobian: Array, knee: Array | None, residuals: dict[str, float]
    ) -> None:
        """Maps of the features: to q (f, n), to J, row by row (f, 6 n), to the knee (f, 3) if any.

        Rows of J: linear, angular.
        """
        self.joints = angles.shape[1]
        self.residuals = residuals
        self._angles = ca.sparsify(ca.DM(angles.T), 1e-9)
        self._jacobian = ca.sparsify(ca.DM(jacobian.T), 1e-9)
        self._knee = None if knee is None else ca.sparsify(ca.DM(knee.T), 1e-9)

    @staticmethod
    def of(robot: Robot) -> list[LegDrives]:
        """Fit every leg of a robot."""
        x, q = sampled_legs(robot, _SAMPLES, _SEED)
        motion, origins = robot.chains.motion(q), robot.chains.origins(q)
        joint = knee_joint(robot)
        fitted: list[LegDrives] = []
        for leg in range(len(robot.legs)):
            features = quadratic_features(x[:, leg])
            J = np.concatenate([motion.foot_jacobian[:, leg], motion.foot_turning[:, leg]], axis=1)
            flat = J.transpose(0, 2, 1).reshape(len(J), -1)
            angles, columns = (np.linalg.lstsq(features, y)[0] for y in (q[:, leg], flat))
            residuals = {
                "angle": float(np.sqrt(np.mean((features @ angles - q[:, leg]) ** 2))),
                "torque": float(
                    np.sqrt(np.mean((features @ columns - flat) ** 2)) / np.abs(flat).mean()
                ),
            }
            knee = None
            if joint is not None:
                places = origins[:, leg, joint] - robot.hips[leg]
                knee = np.linalg.lstsq(features, places)[0]
                residuals["knee"] = float(np.sqrt(np.mean((features @ knee - places) ** 2)))
            fitted.append(FittedLeg(angles, columns, knee, residuals))
        return fitted

    def numbers(self) -> dict[str, Any]:
        knee = {} if self._knee is None else {"knee": str(self._knee)}
        return {"angles": str(self._angles), "jacobian": str(self._jacobian), **knee}

    def knee(self, x: Matrix) -> Matrix | None:
        return None if self._knee is None else ca.mtimes(self._knee, quadratic_terms(x))

    def angles(self, x: Matrix) -> Matrix:
        return ca.mtimes(self._angles, quadratic_terms(x))

    def rates(self, x: Matrix, x_rate: Matrix) -> Matrix:
        return ca.mtimes(self._angles, quadratic_term_rates(x, x_rate))

    def holding_torque(self, x: Matrix, force: Matrix, moment: Matrix | None) -> Matrix:
        J = ca.reshape(ca.mtimes(self._jacobian, quadratic_terms(x)), 6, self.joints)
        torque = ca.mtimes(J[:3, :].T, force)
        if moment is not None:
            torque = torque + ca.mtimes(J[3:, :].T, moment)
        return -torque
