"""A finding of a check: the worst value of a motion, its limit, and whether that holds."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from llsrbm.arrays import Array
from llsrbm.certificate.sampled_motion import SampledMotion
from llsrbm.motion.trajectory import json_value
from llsrbm.number_text import decimal, percent

ALLOWANCE = 0.01  # of a limit: beyond it a share does not hold


@dataclass(frozen=True)
class Finding:
    """The worst value that one check finds in a motion.

    Attributes:
        name: of the check.
        worst: a share of the limit (where that is 0, 1 and a share of the weight), or a length in
            m; None if it cannot be known.
        limit: in `unit`; None where there is none, or where it is not known.
        unit: of the limit; of `worst` as well where that is a length.
        allowed: what `worst` may be, or has to be at least where it is a distance between bodies.
        where: joint, foot or pair of links; time_s: s, of the motion's own time.
        holds: None if it cannot be known.
        beyond_s: s, how long the joint, foot or pair `where` is beyond what is allowed, in all;
            None where it is not, or where that is not counted.
        why: reason why it is not known, or why there is nothing to hold; what follows where it does
            not hold.
    """

    name: str
    worst: float | None
    limit: float | None
    unit: str
    where: str
    time_s: float | None
    holds: bool | None
    allowed: float | None = None
    why: str = ""
    beyond_s: float | None = None

    def as_dict(self) -> dict[str, Any]:
        """Plain data without the name, null for what is not known or not finite."""
        stated = vars(self)
        return {key: json_value(value) for key, value in stated.items() if key != "name"}

    @property
    def is_length(self) -> bool:
        """True if `worst` is in m; otherwise it is a share of the limit."""
        return self.name in LENGTHS

    @property
    def when(self) -> str:
        """The instant, for people, and how long what is allowed is exceeded."""
        if self.time_s is None:
            return ""
        long = "" if self.beyond_s is None else f", {1e3 * self.beyond_s:.0f} ms beyond"
        return f"{self.time_s:.2f} s{long}"

    def shown(self, value: float) -> str:
        """A value like `worst`, for people: mm, per cent of the limit, or of the weight above 0."""
        if self.is_length:
            return f"{decimal(1e3 * value, 1)} mm"
        if self.limit == 0:
            return f"{percent(value - 1, 1)} of the weight"
        return percent(value, 1)


LENGTHS = ("slip", "self_distance", "clearance")
"""Checks whose worst value is in m."""


class Check(ABC):
    """One check of a motion; the docstring of each says what its worst value means."""

    name: ClassVar[str]
    unit: ClassVar[str]

    @abstractmethod
    def find(self, motion: SampledMotion) -> Finding:
        """The worst value of the motion."""

    def unknown(self, why: str) -> Finding:
        """That nothing can be known."""
        return Finding(self.name, None, None, self.unit, "", None, None, why=why)

    def nothing(self, why: str) -> Finding:
        """That there is nothing that could be violated."""
        return Finding(self.name, None, None, self.unit, "", None, True, why=why)

    def largest(
        self,
        motion: SampledMotion,
        values: Array,
        limits: ArrayLike,
        names: tuple[str, ...],
        allowed: float = 1 + ALLOWANCE,
    ) -> Finding:
        """The largest of `values` (K, n), shares of `limits` or lengths, at `names` (n,).

        `limits` broadcast to the values.
        """
        bad = np.where(np.isnan(values), np.inf, values)  # no number is as bad as can be
        k, n = (int(i) for i in np.unravel_index(np.argmax(bad), bad.shape))
        worst, limit = float(bad[k, n]), float(np.broadcast_to(limits, bad.shape)[k, n])
        holds = worst <= allowed
        beyond = np.append(np.diff(motion.time), 0.0)[bad[:, n] > allowed].sum()
        return Finding(
            *(self.name, worst, limit, self.unit, names[n], float(motion.time[k])),
            holds=holds,
            allowed=allowed,
            beyond_s=None if holds else float(beyond),
        )

    def least(
        self, motion: SampledMotion, distance: float, instant: int, limit: float, name: str
    ) -> Finding:
        """The least distance, m, at an instant of the motion, which has to be `limit` or more."""
        return Finding(
            *(self.name, distance, limit, self.unit, name, float(motion.time[instant])),
            holds=distance >= limit,
            allowed=limit,
        )
