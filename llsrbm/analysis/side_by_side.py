"""One jump made in several ways, side by side: who turned how far at touchdown, and why.

The turn is about the axis that the request turns about; of a jump without a turn it is the pitch,
or the roll of one to the side. Errors of a model show in flight, where nothing corrects them:
at touchdown they may cancel with what was off at lift-off (`llsrbm.analysis.model_turn`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from llsrbm.arrays import Array
from llsrbm.mechanics import rotation_matrices, turns_between
from llsrbm.motion.flights import flights
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.number_text import decimal, degrees
from llsrbm.request.jump import Jump

Axis = Literal["roll", "pitch", "yaw"]

_AXES: tuple[Axis, ...] = ("roll", "pitch", "yaw")
_INERTIA = {"roll": "Ixx", "pitch": "Iyy", "yaw": "Izz"}
_HELD = 0.005  # share; an inertia that changes by less is held


@dataclass(frozen=True)
class Turning:
    """A simulated turn against its plan; rad, in the sense that was asked for."""

    axis: Axis
    requested: bool  # the request is to turn about it
    off: float | None  # at the first contact, beyond the plan's at its own; None: there was none
    in_flight: float | None  # of it, gained from lift-off on; None: not known
    inertia: tuple[
        float, float
    ]  # kg m2 in the plan's model: at lift-off, farthest from it in flight


@dataclass(frozen=True)
class Way:
    """One way to make the jump."""

    name: str  # "SRBM", "With replanning"
    rollout: Rollout | None = None  # what the whole robot made of its plan; None: there is none
    why_not: str = ""  # in one sentence, without its full stop


def axis_of(jump: Jump) -> Axis:
    """The axis about which a request turns, or else would be off first."""
    turns: dict[Axis, float] = {"pitch": jump.pitch, "roll": jump.roll, "yaw": jump.twist}
    for axis, turn in turns.items():
        if turn:
            return axis
    return "roll" if abs(jump.lateral) > abs(jump.forward) else "pitch"


def turning(rollout: Rollout) -> Turning:
    """The turn of a simulation."""
    jump, plan, axis = rollout.jump, rollout.plan, axis_of(rollout.jump)
    amount = {"roll": jump.roll, "pitch": jump.pitch, "yaw": jump.twist}[axis]
    sense = math.copysign(1.0, amount)
    outcome = rollout.outcome
    off, in_flight = outcome.yaw_error_at_touchdown, outcome.yaw_error_in_flight
    if axis != "yaw":
        off, in_flight = _off(rollout, _AXES.index(axis))
    return Turning(
        axis=axis,
        requested=bool(amount),
        off=None if off is None else sense * off,
        in_flight=None if in_flight is None else sense * in_flight,
        inertia=_inertia(plan, axis),
    )


def _off(rollout: Rollout, column: int) -> tuple[float | None, float | None]:
    """Turn beyond the plan about an axis of the base, rad: at touchdown, and from lift-off on."""
    flown = flights(rollout)
    if not flown or flown[-1].touchdown is None or flown[-1].lift_off is None:
        return None, None
    plan, time = rollout.plan, rollout.time
    first, touch = np.searchsorted(time, [flown[-1].lift_off, flown[-1].touchdown - 1e-9])
    # The tracked attitude stands still once the planned flight is over.
    planned = rollout.outcome.touchdown_planned_s
    last = max(first, min(touch, np.searchsorted(time, planned - 1e-9)) - 1)
    knot = int(np.searchsorted(plan.time, plan.touchdown - 1e-9))
    touch = min(int(touch), len(time) - 1)
    off = turns_between(plan.base_quat[[knot]], rollout.base_quat[[touch]], body_axes=True)
    at = [int(first), int(last)]
    tracked = turns_between(rollout.reference_base_quat[at], rollout.base_quat[at], body_axes=True)
    return float(off[0, column]), float(tracked[1, column] - tracked[0, column])


def _inertia(plan: Plan, axis: Axis) -> tuple[float, float]:
    """About the world's vertical, or an axis of the base, in the last flight."""
    there = np.flatnonzero(plan.phase == plan.schedule.flights[-1])
    about: Array = rotation_matrices(plan.base_quat[there])[..., _AXES.index(axis)]
    if axis == "yaw":
        about = np.broadcast_to([0.0, 0.0, 1.0], about.shape)
    moment = np.einsum("ki,kij,kj->k", about, plan.inertia[there], about)
    return float(moment[0]), float(moment[np.argmax(np.abs(moment - moment[0]))])


# ---- in words


def sentence(ways: Sequence[Way], *, of_models: bool = True) -> str:
    """The turn of each at touchdown; of models also in flight, by their inertia, and the best."""
    clauses: list[str] = []
    turned = False
    for way in ways:
        clauses.append(_clause(way, of_models=of_models, follows=turned))
        turned = turned or (way.rollout is not None and turning(way.rollout).off is not None)
    text = "; ".join(clauses) + (_best(ways) if of_models else "")
    return f"{text[:1].upper()}{text[1:].removesuffix('.')}."


def rows(ways: Sequence[Way]) -> list[tuple[str, tuple[str, ...]]]:
    """Figures as rows: title with unit, and a text a way."""
    known = [None if way.rollout is None else turning(way.rollout) for way in ways]
    axis = next((turn.axis for turn in known if turn is not None), "yaw")
    found: list[tuple[str, tuple[str, ...]]] = [
        (
            f"{_INERTIA[axis]} as planned [kg m²]",
            tuple("–" if turn is None else _inertia_words(turn) for turn in known),
        ),
        (
            f"{axis.capitalize()} beyond the plan in flight [°]",
            tuple(_signed(None if turn is None else turn.in_flight) for turn in known),
        ),
        (
            f"{axis.capitalize()} beyond the plan at touchdown [°]",
            tuple(_signed(None if turn is None else turn.off) for turn in known),
        ),
        ("Feet off the plan at the end [mm]", tuple(map(_feet, ways))),
        ("Outcome", tuple(map(_outcome, ways))),
    ]
    return found


def _clause(way: Way, *, of_models: bool, follows: bool) -> str:
    """`follows`: another clause has said what is measured."""
    # A model turns by itself; a robot with something, or without.
    who, how = (way.name, "") if of_models else ("the robot", f" {_condition(way.name)}")
    rollout = way.rollout
    if rollout is None:
        reason = f" ({way.why_not.rstrip('.')})" if way.why_not else ""
        return f"{who} has no plan{how}{reason}"
    turn, fell = turning(rollout), rollout.outcome.fell_at_s
    if turn.off is None:
        at = "" if fell is None else f" at {decimal(fell, 2)} s"
        return f"{who} falls{at}{how} and does not touch down on its feet"
    amount = degrees(abs(turn.off))
    if turn.requested:
        amount = f"{amount} {'less' if turn.off < 0 else 'more'}"
        words = f"at touchdown {who} has turned {amount} than planned{how}"
    else:
        words = f"at touchdown {who} is {amount} off its plan in {turn.axis}{how}"
    if follows:
        words = f"{who} {amount}" if of_models else f"{amount}{how}"
    about = f"feet {_feet(way)} mm off at the end"
    if of_models:
        about = _about_model(turn, follows=follows)
    after = "" if fell is None else f", and falls at {decimal(fell, 2)} s"
    return f"{words} ({about}){after}"


def _condition(name: str) -> str:
    """Such as "with ideal drives", "without replanning"."""
    words = name.lower()
    return words if words.startswith("with") else f"with {words}"


def _about_model(turn: Turning, *, follows: bool) -> str:
    """`follows`: another clause has said where, and the unit."""
    where, unit = ("", "") if follows else (" in flight", " kg m²")
    inertia = f"{_INERTIA[turn.axis]} {_inertia_words(turn)}{unit}"
    if turn.in_flight is None:
        return inertia
    amount = degrees(abs(turn.in_flight))
    if not turn.requested or amount == degrees(0.0):
        return f"{amount} in flight, {inertia}"
    return f"{amount} {'lost' if turn.in_flight < 0 else 'gained'}{where}, {inertia}"


def _inertia_words(turn: Turning) -> str:
    first, farthest = turn.inertia
    if abs(farthest / first - 1) < _HELD:
        return f"held at {decimal(first, 2)}"
    return f"{decimal(first, 2)} → {decimal(farthest, 2)}"


def _best(ways: Sequence[Way]) -> str:
    """The way whose plan is nearest to what the robot did in flight, as far as the figures tell."""
    errors = {
        way.name: round(math.degrees(abs(turn.in_flight)), 1)
        for way in ways
        if way.rollout is not None and (turn := turning(way.rollout)).in_flight is not None
    }
    if len(errors) < 2:
        return ""
    smallest = min(errors.values())
    best = [name for name, error in errors.items() if error == smallest]
    if len(best) == len(errors):
        return ": all foresee the flight alike"
    among = "" if all(way.rollout is not None for way in ways) else " of these"
    return f": {' and '.join(best)} foresee{'s' if len(best) == 1 else ''} the flight best{among}"


def _signed(angle: float | None) -> str:
    return "–" if angle is None else decimal(math.degrees(angle), 1, signed=True)


def _feet(way: Way) -> str:
    return "–" if way.rollout is None else decimal(1000 * way.rollout.outcome.foot_error)


def _outcome(way: Way) -> str:
    if way.rollout is None:
        return "no plan"
    outcome = way.rollout.outcome
    if not way.rollout.landed:
        return "fell"
    return "landed" if outcome.strict else "landed, not strict"
