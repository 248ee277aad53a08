"""Any schedules, and plans of some, made from plans of three phases: cut anew, or put in a row."""

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from llsrbm.files.quantity import TIME, quantities
from llsrbm.mechanics import sign_continuous
from llsrbm.motion.plan import Plan
from llsrbm.request.schedule import TIMINGS, Phase, Schedule
from tests.llsrbm.synthetic import LEGS

_POINTS = ("com", "base_position", "foot_position", "contact_point", "leg_com")
_VECTORS = (
    "com_velocity",
    "angular_velocity",
    "linear_momentum",
    "angular_momentum",
    "contact_force",
)


@st.composite
def schedules(draw, legs: tuple[str, ...] = LEGS) -> Schedule:
    """Hypothesis: sound ones; each phase's feet differ from those before."""
    between = draw(st.lists(st.sets(st.sampled_from(legs)), max_size=6))
    rows, place = [], 0
    for standing in (set(legs), *between, set(), set(legs)):
        if rows and standing == set(rows[-1].feet):
            continue
        place += bool(rows) and rows[-1].is_flight
        time = draw(st.sampled_from(TIMINGS) | st.tuples(st.floats(0.02, 1), st.floats(1.1, 3)))
        name = draw(st.sampled_from(["push", "vol plané", "着地"]))
        share = draw(st.floats(0.1, 4.0))
        feet = tuple(foot for foot in legs if foot in standing)
        rows.append(Phase(name, feet, time, place, share))
    return Schedule(legs, tuple(rows))


def with_schedule(plan: Plan, phases: list[tuple[Phase, int]]) -> Plan:
    """The same knots with other phases of so many intervals; feet that swing carry nothing."""
    schedule = Schedule(plan.leg_names, tuple(phase for phase, _ in phases))
    index = np.repeat(np.arange(len(phases)), [intervals for _, intervals in phases])
    index = np.append(index, index[-1])
    points = plan.contact_force.shape[1] // len(schedule.legs)
    stands = np.repeat(schedule.stands[index], points, axis=1)
    force = plan.contact_force * stands[:, :, None]
    return replace(plan, phase=index, schedule=schedule, contact_force=force)


def in_a_row(*plans: Plan) -> Plan:
    """Jumps one after the other: the landing of one and the take-off of the next are a rebound."""
    joined = plans[0]
    for plan in plans[1:]:
        joined = _followed_by(joined, plan)
    return joined


def _followed_by(first: Plan, then: Plan) -> Plan:
    turn = Rotation.from_quat(first.base_quat[-1], scalar_first=True)
    turn = turn * Rotation.from_quat(then.base_quat[0], scalar_first=True).inv()
    stands, starts = first.foot_position[-1, 0], then.foot_position[0, 0]
    moved = _moved(then, turn, stands - turn.apply(starts))
    moved["time"] = then.time + first.time[-1]
    moved["phase"] = then.phase + len(first.schedule) - 1
    values = {}
    for name, quantity in quantities(Plan).items():
        here = getattr(first, name)
        if TIME in quantity.axes and here is not None:
            values[name] = np.concatenate([here[:-1], moved.get(name, getattr(then, name))])
    for name in ("base_quat", "foot_quat"):
        values[name] = sign_continuous(values[name])
    *before, landing = first.schedule
    place = landing.place
    after = [replace(phase, place=phase.place + place) for phase in then.schedule.phases[1:]]
    rebound = Phase("rebound", landing.feet, (0.2, 3.0), place)
    schedule = Schedule(first.schedule.legs, (*before, rebound, *after))
    return replace(first, **values, schedule=schedule, solution=None)


def _moved(plan: Plan, turn: Rotation, shift: np.ndarray) -> dict[str, np.ndarray]:
    R = turn.as_matrix()
    values = {name: getattr(plan, name) @ R.T + shift for name in _POINTS}
    values |= {name: getattr(plan, name) @ R.T for name in _VECTORS}
    values["inertia"] = R @ plan.inertia @ R.T
    for name in ("base_quat", "foot_quat"):
        quat = getattr(plan, name)
        turned = turn * Rotation.from_quat(quat.reshape(-1, 4), scalar_first=True)
        values[name] = turned.as_quat(scalar_first=True).reshape(quat.shape)
    return values
