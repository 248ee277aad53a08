from dataclasses import replace

import casadi as ca
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from llsrbm.models import make_model
from llsrbm.planning.problem.layout import LEAST_INTERVALS, Layout, split
from llsrbm.planning.problem.parameters import parameter_sizes
from llsrbm.planning.problem.stage import Stage
from llsrbm.request.schedule import together
from llsrbm.robots import load_robot
from tests.llsrbm.schedules import schedules
from tests.llsrbm.synthetic import LEGS

ALL, NONE = (True,) * 4, (False,) * 4
HIND = (False, False, True, True)
LAYOUT = Layout(contacts=4, stands=(ALL, NONE, ALL), intervals=(3, 4, 5))
REAR_LAST = Layout(contacts=4, stands=(ALL, HIND, NONE, ALL), intervals=(4, 3, 5, 4))
MODEL = make_model("srbm", load_robot("anymal"))

layouts = st.builds(
    Layout.of,
    schedules(),
    contacts=st.sampled_from([4, 16]),
    intervals=st.integers(9, 60),
    foot_coordinates=st.sampled_from([3, 4]),
    clears=st.booleans(),
    turns=st.booleans(),
)


# ---- intervals


@given(total=st.integers(9, 300))
def test_three_whole_phases_share_the_intervals_evenly(total):
    parts = split(total, together(LEGS))
    assert sum(parts) == total
    assert max(parts) - min(parts) <= 2
    assert Layout.of(together(LEGS), 4, total, 3).total == total


@given(total=st.integers(9, 300), schedule=schedules())
def test_a_phase_gets_its_share_of_a_third(total, schedule):
    parts = split(total, schedule)
    assert len(parts) == len(schedule)
    assert min(parts) >= LEAST_INTERVALS
    for phase, count in zip(schedule, parts, strict=True):
        wanted = max(LEAST_INTERVALS, total // 3 * phase.share)
        # The first flight has what the thirds leave over.
        assert wanted - 0.5 <= count <= wanted + 0.5 + 2


# ---- places in the vector


@given(layout=layouts)
def test_every_scalar_has_one_place(layout):
    taken = np.zeros(layout.size_total, dtype=int)
    for k, role in enumerate(layout.roles):
        places = layout.variables(k)
        assert tuple(places) == (*layout.states(role), *layout.controls(role))
        for name, place in places.items():
            assert place.stop - place.start == layout.size(name, role) > 0
            taken[place] += 1
        states = sum(layout.size(name, role) for name in layout.states(role))
        assert states == layout.state_size(role)
    assert (taken == 1).all()


@given(layout=layouts)
def test_feet_are_variables_in_the_air_and_forces_on_the_ground(layout):
    """By the schedule's own word on each foot at each knot and before it."""
    d, corners = layout.foot_coordinates, layout.corners
    stands = np.array(layout.stands)[layout.phase]
    for k in range(layout.total):
        sizes = {n: p.stop - p.start for n, p in layout.variables(k).items()}
        now, before, after = stands[k], stands[max(k - 1, 0)], stands[k + 1]
        at_knot = ~now | ~before
        assert sizes.get("feet", 0) == sizes.get("feet_velocity", 0) == d * at_knot.sum()
        assert sizes.get("force", 0) == 3 * corners * now.sum()
        assert sizes.get("feet_step", 0) == d * (~now).sum()
        assert sizes.get("feet_stop", 0) == d * (~now & after).sum()
        assert sizes.get("next_force", 0) == 3 * corners * (~now & after).sum()
        assert sizes.get("next_feet", 0) == d * (now & ~after).sum()
        # The last knot has no force to step to.
        steps = (now & after).sum() if k < layout.total - 1 else 0
        assert sizes.get("force_step", 0) == 3 * corners * steps
        assert ("next_duration" in sizes) == (layout.phase[k + 1] != layout.phase[k])


# ---- what follows what


@settings(max_examples=15)
@given(layout=layouts.filter(lambda layout: layout.foot_coordinates == 3 and layout.corners == 1))
def test_a_stages_next_state_has_the_states_of_the_next(layout):
    symbols = {n: ca.SX.sym(n, size) for n, size in parameter_sizes(layout).items()}
    for role, knots in layout.blocks():
        if role.terminal:
            continue
        following = layout.roles[knots[-1] + 1]
        stage = Stage(role, layout, MODEL, symbols)
        assert stage.next_state(following).shape == (layout.state_size(following), 1)
        assert stage.variables.numel() == layout.state_size(role) + layout.control_size(role)


@given(layout=layouts)
def test_blocks_are_runs_of_one_role(layout):
    covered = []
    for role, knots in layout.blocks():
        assert all(layout.roles[k] == role for k in knots)
        covered += knots
    assert covered == list(range(layout.knots))


# ---- swings


@given(layout=layouts)
def test_every_lift_off_has_its_touchdown(layout):
    """Swings, told by the roles' own edges."""
    lifts = {(leg, k) for k, role in enumerate(layout.roles) for leg in role.leaving}
    touches = {(leg, k) for k, role in enumerate(layout.roles) for leg in role.landing}
    swings = layout.swings
    assert {(leg, lift) for leg, lift, _ in swings} == lifts
    assert {(leg, touch) for leg, _, touch in swings} == touches
    for leg, lift, touch in swings:
        assert 0 < lift < touch < layout.total
        assert not layout.standing[lift:touch, leg].any()
        assert layout.standing[lift - 1, leg]
        assert layout.standing[touch, leg]
        assert leg in layout.roles[lift - 1].lifting_off
        assert leg in layout.roles[touch - 1].touching_down
        inside = layout.roles[lift + 1 : touch]
        assert all(leg in role.flying for role in inside)


@given(layout=layouts)
def test_progress_of_a_swing(layout):
    progress, step = layout.swing_progress
    in_air = np.zeros(progress.shape, dtype=bool)
    for leg, lift, touch in layout.swings:
        here = progress[lift : touch + 1, leg]
        assert (here[0], here[-1]) == (0.0, 1.0)
        np.testing.assert_allclose(np.diff(here), step[lift:touch, leg], atol=1e-12)
        in_air[lift : touch + 1, leg] = True
    np.testing.assert_array_equal(np.isnan(progress), ~in_air)


def test_front_feet_swing_from_the_push_to_the_landing():
    lift, away, touch = 4, 7, 12
    assert REAR_LAST.swings == (
        (0, lift, touch),
        (1, lift, touch),
        (2, away, touch),
        (3, away, touch),
    )
    pushing = REAR_LAST.roles[5]
    assert pushing.standing == pushing.remaining == (2, 3)
    assert pushing.swinging == pushing.flying == pushing.in_air == (0, 1)
    assert pushing.in_contact
    assert not pushing.is_flight
    assert REAR_LAST.roles[lift].leaving == (0, 1)
    assert REAR_LAST.roles[touch].landing == (0, 1, 2, 3)
    np.testing.assert_allclose(REAR_LAST.swing_progress[0][6], [0.25, 0.25, np.nan, np.nan])


# ---- names


@given(layout=layouts)
def test_a_body_that_turns_over_lands_upright_after_the_last_flight(layout):
    flights = [p for p, row in enumerate(layout.stands) if not any(row)]
    for role in layout.roles[:-1]:
        assert role.leans == (layout.turns and role.phase < flights[-1])
        assert role.lands_upright == (layout.turns and role.phase > flights[-1])
        assert role.clears == (layout.clears and not role.initial)


def test_names_of_files_say_which_feet_stand_when():
    assert LAYOUT.name == "1111-0000-1111"
    assert REAR_LAST.name == "1111-0011-0000-1111"
    assert replace(LAYOUT, turns=True).name == "1111-0000-1111-turns"
