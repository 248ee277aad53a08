"""A finding of a check: the worst value of a motion, its limit, and whether that holds."""

from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from llsrbm.arrays import Array, BoolArray
from llsrbm.certificate.sampled_motion import SampledMotion
from llsrbm.motion.trajectory import json_value
from llsrbm.number_text import decimal, percent

ALLOWANCE = 0.01  # of a limit: beyond it a share does not hold
INSTANTS = 20  # of a profile's stretches: 20 ms


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


DISTANCES = ("self_distance", "clearance")
"""Checks whose worst value is a least distance between bodies, m."""

LENGTHS = ("slip", *DISTANCES)
"""Checks whose worst value is in m."""


@dataclass(frozen=True, eq=False)
class Profile:
    """Worst values that a check finds along a motion, in each of N short stretches.

    Attributes:
        begin, end: (N,) s of the stretches, in the motion's own time.
        worst: (N,) as `Finding.worst`; holds: (N,) whether that does.
        allowed: as in the finding.
    """

    begin: Array
    end: Array
    worst: Array
    holds: BoolArray
    allowed: float


class Check(ABC):
    """One check of a motion; the docstring of each says what its worst value means.

    It takes a motion in stretches, each of which begins with the instant at which the one before
    ended: so intervals count once, and what holds on from stretch to stretch is kept by the check.
    """

    name: ClassVar[str]
    unit: ClassVar[str]

    def __init__(self) -> None:
        self._worst: Finding | None = None
        self._how_bad = -np.inf  # the worst is: larger is worse
        self._beyond: dict[str, float] = defaultdict(float)  # s, of each joint, foot or pair
        self._profile: list[tuple[Array, Array, Array, BoolArray]] = []

    @abstractmethod
    def take(self, motion: SampledMotion) -> None:
        """Look at the next stretch of the motion."""

    @property
    def finding(self) -> Finding:
        """The worst value of what was taken."""
        assert self._worst is not None
        beyond = None if self._worst.holds is not False else self._beyond.get(self._worst.where)
        return replace(self._worst, beyond_s=beyond)

    @property
    def profile(self) -> Profile | None:
        """The worst values along the motion; None: nothing can be known."""
        if not self._profile or self._worst is None or self._worst.allowed is None:
            return None
        begin, end, worst, holds = map(np.concatenate, zip(*self._profile, strict=True))
        return Profile(begin, end, worst, holds, self._worst.allowed)

    def unknown(self, why: str) -> None:
        """Find that nothing can be known."""
        self._worst = Finding(self.name, None, None, self.unit, "", None, None, why=why)

    def nothing(self, why: str) -> None:
        """Find that there is nothing that could be violated."""
        self._worst = Finding(self.name, None, None, self.unit, "", None, True, why=why)

    def largest(
        self,
        motion: SampledMotion,
        values: Array,
        limits: ArrayLike,
        names: Sequence[str],
        allowed: float = 1 + ALLOWANCE,
    ) -> None:
        """Find the largest of `values` (K, n), shares of `limits` or lengths, at `names` (n,).

        `limits` broadcast to the values.
        """
        bad = np.where(np.isnan(values), np.inf, values)  # no number is as bad as can be
        beyond = bad > allowed
        if beyond.any():
            lasting = np.append(np.diff(motion.time), 0.0) @ beyond
            for name, seconds in zip(names, lasting.tolist(), strict=True):
                self._beyond[name] += seconds
        firsts = np.arange(0, len(bad), INSTANTS)
        lasts = np.minimum(firsts + INSTANTS, len(bad) - 1)
        worst = np.maximum.reduceat(bad.max(axis=1), firsts)
        self._profile.append((motion.time[firsts], motion.time[lasts], worst, worst <= allowed))
        k, n = (int(i) for i in np.unravel_index(np.argmax(bad), bad.shape))
        if self._worst is not None and not bad[k, n] > self._how_bad:
            return
        self._how_bad = largest = float(bad[k, n])
        limit = float(np.broadcast_to(limits, bad.shape)[k, n])
        self._worst = Finding(
            *(self.name, largest, limit, self.unit, names[n], float(motion.time[k])),
            holds=largest <= allowed,
            allowed=allowed,
        )

    def least(
        self, motion: SampledMotion, distance: float, instant: int, limit: float, name: str
    ) -> None:
        """Find the least distance, m, at an instant of a stretch, which has to be `limit` or more.

        Of several the one that is furthest below its limit is the worst.
        """
        time = motion.time
        holds = np.array([distance >= limit])
        self._profile.append((time[:1], time[-1:], np.array([distance]), holds))
        if self._worst is not None and not limit - distance > self._how_bad:
            return
        self._how_bad = limit - distance
        self._worst = Finding(
            *(self.name, distance, limit, self.unit, name, float(time[instant])),
            holds=distance >= limit,
            allowed=limit,
        )
