"""Plans made anew while a robot was under way, and their part of a rollout's file."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from llsrbm.arrays import Array
from llsrbm.errors import Error, FileFormatError
from llsrbm.files.native import part_of
from llsrbm.files.npz import LARGEST_NUMBER, Arrays, checked
from llsrbm.files.quantity import LEG, REPLAN, TIME, WXYZ, XYZ, Kind, Quantity

DEADLINE = 0.02
"""s of computing time within which an answer is in time: 50 Hz."""


@dataclass(frozen=True, eq=False)
class Replan:
    """One answer of the replanner: K knots, L legs; world frame. No knots where nothing was found.

    Attributes:
        measured, applied: s since the first plan's start, when the state was measured and when the
            controller took it over; nan: it came too late, or not at all.
        computing_time: s of the processor's time.
        solved: whether a motion was found that satisfies every constraint.
        iterations: of the solver.
        touchdown: s, when the first feet are to meet the ground.
        time: (K,) s since the first plan's start.
        com: (K, 3) m; base_quat: (K, 4) w, x, y, z.
        foot_position: (K, L, 3) m; foot_quat: (K, L, 4) w, x, y, z.
    """

    measured: float
    applied: float
    computing_time: float
    solved: bool
    iterations: int
    touchdown: float
    time: Array
    com: Array
    base_quat: Array
    foot_position: Array
    foot_quat: Array


def followed(replans: Sequence[Replan], time: float) -> Replan | None:
    """The newest one that is followed at a time, s; None: still the first plan."""
    taken = [replan for replan in replans if replan.applied <= time]  # nan is never
    return max(taken, key=lambda replan: replan.applied, default=None)


_PREFIX = "replan/"
_NEVER = -1.0

_EACH = {
    "asked": Quantity((REPLAN,), "s", "when the state was measured"),
    "applied": Quantity((REPLAN,), "s", "when the controller took it over"),
    "computing_time": Quantity((REPLAN,), "s", "processor time"),
    "solved": Quantity((REPLAN,), "", "whether every constraint is satisfied", kind=Kind.WHOLE),
    "iterations": Quantity((REPLAN,), "", "of the solver", kind=Kind.WHOLE),
    "touchdown": Quantity((REPLAN,), "s", "when the first feet are to meet the ground"),
    "knots": Quantity((REPLAN,), "", "how many it has", kind=Kind.WHOLE),
}
_MOTION = {
    "time": Quantity((TIME,), "s", "since the first plan's start"),
    "com": Quantity((TIME, XYZ), "m", "centre of mass"),
    "base_quat": Quantity((TIME, WXYZ), "", "attitude of the base"),
    "foot_position": Quantity((TIME, LEG, XYZ), "m", "feet"),
    "foot_quat": Quantity((TIME, LEG, WXYZ), "", "attitudes of the feet"),
}


def replan_arrays(replans: Sequence[Replan]) -> Arrays:
    """Content of a rollout's file: R replans, the knots of all in one array, K of each.

    A time that is not there, of a replan that never applied or found no touchdown, is stored as -1.
    Raises `Error`: a replan holds numbers that are not finite, other than times that are not there.
    """
    if not replans:
        return {}
    arrays: Arrays = {}
    for key, entry in _EACH.items():
        values = [_number(replan, key) for replan in replans]
        if entry.kind is Kind.WHOLE:
            arrays[key] = np.array(values, dtype=np.int64)
        else:
            arrays[key] = np.nan_to_num(np.array(values, dtype=np.float64), nan=_NEVER)
    if arrays["knots"].any():
        found = [replan for replan in replans if len(replan.time)]
        arrays |= {key: np.concatenate([getattr(r, key) for r in found]) for key in _MOTION}
    for key, value in arrays.items():
        if not (np.abs(value) <= LARGEST_NUMBER).all():
            raise Error(f"a replan's {key} holds numbers that are not finite; it is not written")
    return {_PREFIX + key: value for key, value in arrays.items()}


def _number(replan: Replan, key: str) -> float:
    if key == "knots":
        return len(replan.time)
    return float(getattr(replan, "measured" if key == "asked" else key))


def replans_from_arrays(arrays: Arrays, legs: int, path: str | Path) -> tuple[Replan, ...]:
    """The replans of `legs` feet in a rollout's archive; raises `FileFormatError` naming `path`."""
    own = part_of(arrays, _PREFIX)
    if not own:
        return ()
    where = f"{path}: {_PREFIX}"
    each = checked(own, _EACH, where)
    knots, solved = each["knots"], each["solved"]
    motion: Arrays = {}
    if knots.any():
        motion = checked(own, _MOTION, where)
        if motion["foot_position"].shape[1] != legs:
            raise FileFormatError(f'{where} key "foot_position": expected {legs} feet')
    else:
        motion = {key: _empty(entry, legs) for key, entry in _MOTION.items()}
    total = len(motion["time"])
    if (knots < 0).any() or (knots > total).any() or knots.sum() != total:
        raise FileFormatError(f'{where} key "knots": expected {total} in all, as "time" has')
    if not np.isin(solved, (0, 1)).all():
        raise FileFormatError(f'{where} key "solved": expected 0 or 1')
    ends = np.cumsum(knots)
    return tuple(
        Replan(
            measured=float(each["asked"][k]),
            applied=_time(each["applied"][k]),
            computing_time=float(each["computing_time"][k]),
            solved=bool(solved[k]),
            iterations=int(each["iterations"][k]),
            touchdown=_time(each["touchdown"][k]),
            **{key: value[end - knots[k] : end] for key, value in motion.items()},
        )
        for k, end in enumerate(ends)
    )


def _time(stored: float) -> float:
    return float(stored) if stored >= 0 else np.nan


def _empty(entry: Quantity, legs: int) -> Array:
    sizes = {"T": 0, "L": legs}
    return np.zeros([sizes[size] if isinstance(size, str) else size for size in entry.shape])
