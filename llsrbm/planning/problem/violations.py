"""Violations of the constraints and defects of the dynamics of a motion."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from llsrbm.arrays import Array
from llsrbm.errors import Stop
from llsrbm.mechanics import GRAVITY, turns_between
from llsrbm.motion.solve_report import Violation
from llsrbm.planning.problem.constraints import CONSTRAINTS, Constraint
from llsrbm.planning.problem.constraints.base import JointDemand
from llsrbm.planning.problem.knots import DYNAMICS, Knots
from llsrbm.planning.problem.layout import BODY_PLACES, SHIFT, SHORTFALL, TURNED
from llsrbm.planning.problem.limit_table import Limit

# A plan is solved when no violation exceeds this in its own SI unit: 1 mm, 1 mN, 1 mm/s ...
TOLERANCE = 1e-3

# What counts as equally bad in different units, to name the worst violation and the best attempt.
SCALES = {
    "m": 0.05,
    "m/s": 0.5,
    "rad": 0.1,
    "rad/s": 3.0,
    "N": 30.0,
    "Nm": 10.0,
    "kg m2/s": 0.5,
    "s": 0.1,
    "1": 1.0,
}

# How far a limit is moved, times its value, to see whether it is the one that is exceeded.
FAR = 20.0


# Units of the states that are not the body's; of feet and their velocities the yaw's are others.
STATE_UNITS = {
    "feet": "m",
    "feet_velocity": "m/s",
    "force": "N",
    "duration": "s",
    "arms": "rad",
    "arms_velocity": "rad/s",
    TURNED: "rad/s",
    SHIFT: "m",
    SHORTFALL: "1",
}


# Constraint -> what it means that it is violated; an amount follows.
BROKEN = {
    "given_contacts": "standing feet miss their places",
    "feet_at_rest": "feet move as they leave or meet the ground",
    "friction_pyramid": "feet push aside harder than friction holds",
    "joint_torque": "a joint needs more torque than it has",
    "torque_at_speed": "a joint needs more torque than it has at its speed",
    "joint_speed": "a joint has to be faster than its drive",
    "joint_stops": "a joint goes beyond its stop",
    "edge": "a foot comes too near to an edge that it crosses",
    "clearance": "a foot flies too low",
    "body_clearance": "trunk or knees come too near to what they clear",
    "knee_height": "a knee comes too near to the ground",
    "legs_apart": "two legs come too near to each other",
    "feet_apart": "two feet come too near to each other",
    "reach": "a foot is out of its leg's reach",
    "legs_reach": "a leg does not reach where its foot is planned",
    "foot_speed": "a foot swings too fast",
    "foot_yaw": "a foot turns further than its leg can",
    "foot_turn": "a foot turns too fast",
    "put_down": "a foot is put down beside its place",
    "rolling": "feet roll away from where they are planned",
    "phase_times": "a phase is too short or too long",
    "apex_height": "the centre of mass flies too low or too high",
    "momentum_balance": "forces and momentum disagree",
    "rebound": "the landing throws the robot up again",
    "upright_landing": "the trunk lands tilted",
    "short_of_turn": "the trunk is turned too little or too far as it touches down",
    "turns_over": "the trunk turns over too little",
    "true_turn": "the whole body turns otherwise than the model",
    "final_state": "the motion does not end as it should",
    "final_place": "the centre of mass ends beside its place",
    "arms_at_rest": "arms do not come to rest",
    "shortfall": "less is done than was asked for",
    "dynamics_position": "the centre of mass jumps",
    "dynamics_velocity": "the centre of mass moves otherwise than forces say",
    "dynamics_attitude": "the trunk turns otherwise than its rate says",
    "dynamics_momentum": "angular momentum changes otherwise than forces say",
}


def broken_in_words(name: str) -> str:
    """The sentence of a violated constraint, up to the amount."""
    gap = name.removeprefix("dynamics_")
    unnamed = f"{name} is violated" if gap == name else f"{gap.replace('_', ' ')} jumps"
    return BROKEN.get(name, unnamed)


def dynamics_defects(knots: Knots) -> dict[str, tuple[str, Array]]:
    """Name -> unit and (N,) |x[k+1] - F(x[k], u[k])| (eq. 8), of all states that there are."""
    gaps = knots.rows[DYNAMICS].values.reshape(len(knots.dt), -1)
    gap = {name: gaps[:, place] for name, place in BODY_PLACES.items()}
    turn = turns_between(knots.quat[1:] - gap["quat"], knots.quat[1:], body_axes=True)
    defects = {
        "dynamics_position": ("m", gap["position"]),
        "dynamics_velocity": ("m/s", gap["velocity"]),
        "dynamics_attitude": ("rad", turn),
        "dynamics_momentum": ("kg m2/s", gap["momentum"] * knots.task.mass),
    }
    found = {name: (unit, np.abs(error).max(axis=1)) for name, (unit, error) in defects.items()}
    unit_force = knots.task.mass * GRAVITY / knots.layout.contacts
    for name, unit in STATE_UNITS.items():
        if (rows := knots.rows.get(name)) is not None:
            amount = np.zeros(len(knots.dt))
            np.maximum.at(amount, rows.knot, np.abs(rows.values))
            found[f"dynamics_{name}"] = unit, amount * (unit_force if unit == "N" else 1.0)
    return found


def violations(knots: Knots) -> dict[str, Violation]:
    """Constraint name -> its largest violation."""
    amounts = dynamics_defects(knots) | {
        c.name: (c.unit, c.violation(knots)) for c in CONSTRAINTS if c.checked(knots.task)
    }
    return {name: _largest(knots, unit, amount) for name, (unit, amount) in amounts.items()}


def violation(knots: Knots, constraint: Constraint) -> Violation:
    """The largest violation of one constraint."""
    return _largest(knots, constraint.unit, constraint.violation(knots))


def _largest(knots: Knots, unit: str, amount: Array) -> Violation:
    # A solver that diverges leaves NaN: the worst there can be.
    amount = np.where(np.isfinite(amount), amount, np.inf)
    worst = int(np.argmax(amount))
    return Violation(
        amount=float(amount[worst]),
        unit=unit,
        phase=phase_name(knots, worst),
        time=float(knots.time[worst]),
    )


def phase_name(knots: Knots, knot: int) -> str:
    """Name of the phase that a knot is in."""
    return knots.task.schedule[int(knots.phase[knot])].name


def satisfied(found: dict[str, Violation]) -> bool:
    """True if no violation exceeds the tolerance."""
    return all(v.amount <= TOLERANCE for v in found.values())


def excess(found: dict[str, Violation]) -> float:
    """The largest violation in the units of `SCALES`."""
    return max(map(severity, found.values()))


def severity(violation: Violation) -> float:
    """A violation in the units of `SCALES`."""
    # A constraint of several units is named with the first.
    return violation.amount / SCALES[violation.unit.split(",")[0]]


def worst_of(found: Mapping[str, Violation]) -> str | None:
    """The constraint that is violated most; None: none is."""
    return max(found, key=lambda name: severity(found[name]), default=None)


def describe_worst(found: dict[str, Violation], knots: Knots | None = None) -> str:
    """The violated constraints in words, the worst first, at most three.

    Args:
        found: constraint name -> its largest violation.
        knots: of which they are; with them, limits of the drives are described by the joint.
    """
    broken = sorted(
        ((name, v) for name, v in found.items() if v.amount > TOLERANCE),
        key=lambda item: -severity(item[1]),
    )
    if not broken:
        return "no constraint is violated, the optimum was not reached"
    constraints = {c.name: c for c in CONSTRAINTS}
    words = []
    for name, v in broken:
        constraint = constraints.get(name)
        demand = constraint.demand(knots) if constraint and knots else None
        where = f"in {v.phase} at {v.time:.2f} s"
        plain = f"{broken_in_words(name)} by {v.amount:.3g} {v.unit} {where}"
        words.append(plain if demand is None else str(demand.demand))
    # Torque at rest and torque at speed may be exceeded by the same joint.
    return "; ".join(list(dict.fromkeys(words))[:3])


def stops(knots: Knots) -> tuple[Stop, ...]:
    """Violated constraints, the worst first, with the limits that would have to be others.

    Of a solve that failed this is what it could not mend, which need not be what made it fail:
    `llsrbm.planning.answer.reasons` finds that.
    """
    found = violations(knots)
    broken = sorted(
        (name for name, v in found.items() if v.amount > TOLERANCE),
        key=lambda name: -severity(found[name]),
    )
    constraints = {c.name: c for c in CONSTRAINTS}
    return tuple(
        _stop_of(knots, constraints[name], found[name])
        if name in constraints
        else _plain_stop(name, found[name])
        for name in broken
    )


def _plain_stop(name: str, v: Violation) -> Stop:
    return Stop(name, v.phase, v.time, v.amount, v.unit, title=broken_in_words(name))


def _stop_of(knots: Knots, constraint: Constraint, v: Violation) -> Stop:
    exceeded = _exceeded(knots, constraint)
    if exceeded is not None:
        return exceeded
    return with_demand(_plain_stop(constraint.name, v), constraint.demand(knots), knots)


def _exceeded(knots: Knots, constraint: Constraint) -> Stop | None:
    """The limit of a violated constraint that would have to be another, if there is one."""
    for limit in (each for each in constraint.limits if not each.states):
        value = limit.of(knots.task)
        step = FAR * max(abs(value), TOLERANCE) * (-1 if limit.lower_bound else 1)
        enough, too_little = value + step, value
        if violation_with(knots, constraint, limit, enough).amount > TOLERANCE:
            continue
        while abs(enough - too_little) > 1e-3 * abs(enough) + TOLERANCE / 10:
            middle = (enough + too_little) / 2
            if violation_with(knots, constraint, limit, middle).amount > TOLERANCE:
                too_little = middle
            else:
                enough = middle
        where = violation(knots, constraint)
        found = stop(constraint, limit, value, enough, where)
        return with_demand(found, constraint.demand(knots), knots)
    return None


def violation_with(knots: Knots, constraint: Constraint, limit: Limit, value: float) -> Violation:
    """Largest violation of a constraint if `limit` were `value`."""
    return violation(knots.under(limit.put(knots.task, value)), constraint)


def stop(
    constraint: Constraint, limit: Limit, value: float, needed: float, where: Violation
) -> Stop:
    """A limit that would have to be `needed`, as `where` shows."""
    return Stop(
        constraint=constraint.name,
        phase=where.phase,
        time=where.time,
        amount=abs(needed - value),
        unit=limit.unit,
        limit=limit.name,
        title=limit.title,
        value=value,
        needed=needed,
    )


def with_demand(stop: Stop, demand: JointDemand | None, knots: Knots) -> Stop:
    """A stop with the joint, the amount and the place of a demand, if there is one."""
    if demand is None:
        return stop
    return replace(
        stop,
        phase=phase_name(knots, demand.interval),
        time=float(knots.time[demand.interval]),
        demand=demand.demand,
    )
