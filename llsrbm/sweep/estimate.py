"""What a sweep will take, said before it begins."""

from __future__ import annotations

from dataclasses import dataclass

from llsrbm.sweep.points import Points

# s a jump on one core of a cloud machine of 2026, mean of the three robots, failures included.
SECONDS_A_PLAN = 0.5
SECONDS_A_SIMULATION = 1.1
SECONDS_A_DIAGNOSIS = 3.0  # spread over all jumps
# bytes; Parquet packs rows of planned jumps to this, and trajectories hardly at all.
BYTES_A_ROW = 500
BYTES_A_TRAJECTORY = 50_000

LARGE = 10**6
"""Rows from which on a sweep is to be confirmed: more than two days on two workers."""


@dataclass(frozen=True)
class Estimate:
    """How large a sweep is, roughly.

    Attributes:
        jumps, rows: exactly.
        seconds: of one worker.
        size: of the results, bytes.
    """

    jumps: int
    rows: int
    seconds: float
    size: float

    def in_words(self, workers: int | None) -> str:
        """One line; `workers`: how many there will be, None: the cluster's, who knows how many."""
        if workers is None:
            long = f"{duration_in_words(self.seconds)} of work for the cluster"
        else:
            many = f"{workers} worker{'s' if workers > 1 else ''}"
            long = f"{duration_in_words(self.seconds / workers)} on {many}"
        return f"{self.jumps} jumps, {self.rows} rows; expected {long}, {_in_bytes(self.size)}"


def estimate(points: Points, jumps: int | None = None) -> Estimate:
    """What a sweep takes.

    Args:
        points: its jumps; jumps: of them those that are still to be done, if not all.
    """
    spec = points.spec
    jumps = points.count if jumps is None else jumps
    rows = jumps * spec.rows_a_jump()
    seconds = jumps * (SECONDS_A_PLAN + spec.diagnose * SECONDS_A_DIAGNOSIS)
    seconds += rows * spec.simulated * SECONDS_A_SIMULATION
    size = rows * BYTES_A_ROW + jumps * spec.trajectories * BYTES_A_TRAJECTORY
    return Estimate(jumps, rows, seconds, size)


def duration_in_words(seconds: float) -> str:
    """For instance "40 s", "12 min", "3.5 h" or "2.1 days"."""
    for unit, size, limit in (("s", 1.0, 90.0), ("min", 60.0, 5400.0), ("h", 3600.0, 172_800.0)):
        if seconds < limit:
            amount = seconds / size
            return f"{amount:.1f} {unit}" if unit == "h" else f"{amount:.0f} {unit}"
    return f"{seconds / 86_400:.1f} days"


def _in_bytes(size: float) -> str:
    for unit, amount in (("kB", 1e3), ("MB", 1e6), ("GB", 1e9)):
        if size < 1000 * amount:
            return f"about {size / amount:.1f} {unit}"
    return f"about {size / 1e12:.1f} TB"
