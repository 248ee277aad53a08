"""Check of the whole body's dynamics: nothing but its contacts and gravity moves the robot."""

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array, stretches
from llsrbm.certificate.finding import Check
from llsrbm.certificate.sampled_motion import NO_FORCES, SampledMotion
from llsrbm.motion.rollout import Rollout
from llsrbm.robots.feet import pushed_points

ARM = 0.2  # m: a moment of ARM m g is as bad as a force of m g
SHARE = 0.1  # of both that may be missing
CLEAR = 0.01  # m: a robot flies that has its feet by more above the ground, without a contact
EDGE = 0.04  # s of either end of a flight that do not count: feet leave and land between frames
LEAST = 0.08  # s of a flight beside these from which its mean rates are told
FALLS = 0.15  # of g: what falls by less stands, though no contact was found


class Dynamics(Check):
    """The six rows of the floating base, which has no drive, of M a + h - J^T f.

    worst = max(|F| / (m g), |M| / (0.2 m x m g)), F the force (N) and M the moment (Nm) about the
    base's origin that the motion lacks; a tenth is allowed. In a rollout with soles the forces
    alone are known, not where they act, and M is left out. `limit`: the weight.

    Of a motion without forces only flights can be told, where there are none: F and M are what
    gravity lacks to the mean rates of the momenta, M about the CoM. One that does not fall as it
    must breaks the check, which is unknown otherwise.
    """

    name, unit = "dynamics", "N"

    def __init__(self) -> None:
        super().__init__()
        self._flight = np.empty((0, 1 + 6))  # of the one under way: s, linear and angular momentum

    def take(self, motion: SampledMotion) -> None:
        """The largest remainder, force or moment."""
        if motion.effort is None:
            if self._worst is None:
                self.unknown(NO_FORCES)
            self._take_flights(motion)
            return
        if isinstance(motion.source, Rollout) and motion.source.pushes:
            self.unknown("pushes act beside the contacts")
            return
        shares = _shares(motion.effort[:, :6], motion.weight)
        if motion.whole_feet:
            shares[:, 1] = 0.0
        self.largest(motion, shares, motion.weight, ("force", "moment"), allowed=SHARE)

    def _take_flights(self, motion: SampledMotion) -> None:
        lowest = pushed_points(motion.robot, motion.placed)[..., 2].min(axis=(1, 2))
        flies = (lowest > CLEAR) & ~motion.contact.any(axis=1)
        shares = np.zeros((len(motion.time), 2))
        for first, end in stretches(flies):
            if first > 0:
                self._flight = self._flight[:0]
            span = slice(first, end)
            own = np.column_stack([motion.time[span], _momenta(motion, span)])
            self._flight = np.concatenate([self._flight, own])
            shares[span] = _lacks(self._flight, motion)
        if not flies[-1]:
            self._flight = self._flight[:0]
        if (shares > SHARE).any():
            names = ("force in flight", "moment in flight")
            self.largest(motion, shares, motion.weight, names, allowed=SHARE)


def _shares(wrenches: Array, weight: float) -> Array:
    """(K, 2): forces and moments (K, 6) as shares of the weight, and of it at `ARM`."""
    lengths = np.linalg.norm(wrenches.reshape(-1, 2, 3), axis=-1)
    shares: Array = lengths / [weight, ARM * weight]
    return shares


def _momenta(motion: SampledMotion, span: slice) -> Array:
    """(K, 6) kg m/s, kg m2/s, world axes, about the CoM."""
    data = motion.model.createData()
    states = zip(motion.q[span], motion.v[span], strict=True)
    return np.array(
        [pin.computeCentroidalMomentum(motion.model, data, q, v).vector for q, v in states]
    )


def _lacks(flight: Array, motion: SampledMotion) -> Array:
    """(2,) shares that the mean rates of a flight's momenta lack, less what its halves differ by;
    0: it is too short to tell, or no flight, as the robot does not fall.
    """
    time = flight[:, 0]
    if time[-1] - time[0] < 2 * EDGE + LEAST:
        return np.zeros(2)
    inner = flight[(time > time[0] + EDGE) & (time < time[-1] - EDGE)]
    middle = len(inner) // 2
    whole, former, latter = map(_rates, (inner, inner[:middle], inner[middle:]))
    if whole[2] > -FALLS * motion.weight:
        return np.zeros(2)
    lacks = whole + np.array([0.0, 0.0, motion.weight, 0.0, 0.0, 0.0])
    found, uncertain = _shares(np.stack([lacks, latter - former]), motion.weight)
    return np.maximum(found - uncertain, 0.0)


def _rates(flight: Array) -> Array:
    """(6,) N, Nm: mean rates of the momenta."""
    rates: Array = np.polyfit(flight[:, 0] - flight[0, 0], flight[:, 1:], 1)[0]
    return rates
