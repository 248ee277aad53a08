"""What a result is worth: every constraint and the dynamics, recomputed in NumPy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from llsrbm.planning.constraints import CONSTRAINTS
from llsrbm.planning.knots import Knots
from llsrbm.trajectory.plan import Phase, Violation

Array = NDArray[np.float64]

# A plan is solved when no violation exceeds this in its own SI unit: 1 mm, 1 mN, 1 mm/s ...
TOLERANCE = 1e-3

# What counts as equally bad in different units, to name the worst violation and the best attempt.
SCALES = {"m": 0.05, "m/s": 0.5, "rad": 0.1, "rad/s": 3.0, "N": 30.0, "kg m2/s": 0.5, "s": 0.1}

PHASE_NAMES = {Phase.TAKEOFF: "take-off", Phase.FLIGHT: "flight", Phase.LANDING: "landing"}


def dynamics_defects(knots: Knots) -> dict[str, tuple[str, Array]]:
    """Name -> unit and (N,) |x[k+1] - F(x[k], u[k])| (eq. 8), from the stored knots alone."""
    dt = knots.dt[:, None]
    v, a, r = knots.velocity, knots.acceleration, knots.position
    q = Rotation.from_quat(knots.quat, scalar_first=True)
    turned = q[:-1] * Rotation.from_rotvec(knots.rotation_rate * dt)
    defects = {
        "dynamics_position": ("m", r[1:] - r[:-1] - v[:-1] * dt - a * dt**2 / 2),
        "dynamics_velocity": ("m/s", v[1:] - v[:-1] - a * dt),
        "dynamics_attitude": ("rad", (turned.inv() * q[1:]).as_rotvec()),
        "dynamics_momentum": (
            "kg m2/s",
            knots.momentum[1:] - knots.momentum[:-1] - knots.momentum_step,
        ),
    }
    return {name: (unit, np.abs(error).max(axis=1)) for name, (unit, error) in defects.items()}


def violations(knots: Knots) -> dict[str, Violation]:
    """Constraint name -> its largest violation."""
    amounts = dynamics_defects(knots) | {c.name: (c.unit, c.violation(knots)) for c in CONSTRAINTS}
    found = {}
    for name, (unit, amount) in amounts.items():
        # A solver that diverges leaves NaN: the worst there can be.
        amount = np.where(np.isfinite(amount), amount, np.inf)
        worst = int(np.argmax(amount))
        found[name] = Violation(
            amount=float(amount[worst]),
            unit=unit,
            phase=PHASE_NAMES[Phase(knots.phase[worst])],
            time=float(knots.time[worst]),
        )
    return found


def satisfied(found: dict[str, Violation]) -> bool:
    """Whether no violation exceeds the tolerance."""
    return all(v.amount <= TOLERANCE for v in found.values())


def excess(found: dict[str, Violation]) -> float:
    """The largest violation in the units of `SCALES`."""
    return max(_scaled(violation) for violation in found.values())


def _scaled(violation: Violation) -> float:
    # A constraint of several units is named with the first.
    return violation.amount / SCALES[violation.unit.split(",")[0]]


def describe_worst(found: dict[str, Violation]) -> str:
    """The violated constraints in words, the worst first, at most three."""
    broken = sorted(
        ((name, v) for name, v in found.items() if v.amount > TOLERANCE),
        key=lambda item: -_scaled(item[1]),
    )
    if not broken:
        return "no constraint is violated, the optimum was not reached"
    return "; ".join(
        f"{name} is violated by {v.amount:.3g} {v.unit} in {v.phase} at {v.time:.2f} s"
        for name, v in broken[:3]
    )
