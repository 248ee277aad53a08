"""The objective recomputed in NumPy, and what each weight does."""

import numpy as np
import pytest

from llsrbm.mechanics import GRAVITY
from llsrbm.planning.answer.planner import planner_for
from llsrbm.planning.problem.costs import default_weights
from llsrbm.planning.problem.parameters import parameter_places
from llsrbm.request.jump import Jump
from tests.llsrbm.planning.solved import REQUESTS, TYPES, function, parameters, solved, variable


def terms(knots) -> dict[str, float]:
    """Each cost without its weight, from the finished motion."""
    mass, contacts = knots.task.mass, knots.force.shape[1]
    force = knots.force / (mass * GRAVITY / contacts)
    n = np.bincount(knots.phase[:-1])
    out = dict.fromkeys(default_weights(), 0.0)
    standing, last = knots.layout.standing, len(knots.time) - 2
    by_leg = force.reshape(len(force), standing.shape[1], -1)
    for k, phase in enumerate(knots.phase[:-1]):
        out["force_magnitude"] += (force[k] ** 2).sum() / n[phase] / contacts
        if k < last:
            both = standing[k] & standing[k + 1]
            step = (by_leg[k + 1] - by_leg[k])[both]
            out["force_smoothness"] += n[phase] * (step**2).sum() / contacts
        out["linear_momentum"] += (knots.velocity[k] ** 2).sum() / n[phase]
        out["angular_momentum"] += ((knots.momentum[k] / mass) ** 2).sum() / n[phase]
        out["tilt"] += (knots.quat[k, 1:3] ** 2).sum() / n[phase]
        out["tilt_rate"] += (knots.rotation_rate[k, :2] ** 2).sum() / n[phase]
        for name in ("feet_step", "feet_stop"):
            if name in knots.layout.variables(k):
                out["swing_effort"] += n[phase] * (variable(knots, name, k) ** 2).sum()
        moved = np.diff(knots.foot_position[k : k + 2], axis=0)[0][~standing[k]]
        out["foot_movement"] += n[phase] * (moved**2).sum()
    out["time"] = (knots.durations**2).sum()
    out["final_orientation"] = ((knots.quat[-1] - knots.task.goal_quat) ** 2).sum()
    return out


@pytest.mark.parametrize(
    ("model", "request_name"),
    [("srbm", "all"), ("llsrbm-plus", "all"), *(("llsrbm-plus", t) for t in TYPES)],
)
def test_the_objective_is_the_weighted_sum(model, request_name):
    s = solved(model, request_name)
    found = terms(s.knots)
    # How far feet move in an interval is known from chords alone.
    layout, f, p = (
        s.planner.layout,
        function(s.planner, "nlp_f"),
        parameters(s.planner.layout, s.task),
    )
    without = p.copy()
    without[parameter_places(layout)["weight_foot_movement"]] = 0
    moving = float(f(s.w, p) - f(s.w, without))
    weights = s.task.weights
    assert moving == pytest.approx(weights["foot_movement"] * found.pop("foot_movement"), rel=0.05)
    total = sum(weights[name] * term for name, term in found.items())
    assert s.plan.report.cost - moving == pytest.approx(total, rel=1e-6)


# By default every phase is as short as allowed, so time can only be made less dear.
FACTORS = {
    "force_smoothness": 100.0,
    "force_magnitude": 1000.0,
    "foot_movement": 50.0,
    "swing_effort": 20.0,
    "tilt": 20.0,
    "tilt_rate": 20.0,
    "linear_momentum": 20.0,
    "angular_momentum": 10.0,
    "time": 0.02,
}


@pytest.mark.parametrize("name", FACTORS)
def test_a_larger_weight_makes_its_term_smaller(name):
    before = terms(solved("llsrbm-plus", "all").knots)[name]
    planner = planner_for("anymal", "llsrbm-plus")
    planner.plan(
        Jump(model="llsrbm-plus", **REQUESTS["all"]),
        weights={name: FACTORS[name] * default_weights()[name]},
        patient=False,
    )
    after = terms(planner.last_knots())[name]
    if FACTORS[name] > 1:
        assert after < 0.997 * before
    else:
        assert after > 1.02 * before
