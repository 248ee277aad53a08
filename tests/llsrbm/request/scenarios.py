"""Scenarios to draw, all fields of which may differ from the defaults."""

from hypothesis import strategies as st

from llsrbm.request.scenario import LARGEST_IMPULSE, MOST_NOISE, Push, Scenario

VECTORS = st.tuples(*[st.floats(-25, 25)] * 3)
PUSHES = st.builds(Push, st.floats(0, 3), VECTORS, VECTORS)


def scenarios(names, largest_seed):
    """With names out of a strategy, and seeds up to one."""
    return st.builds(
        Scenario,
        board=st.floats(0.001, 1),
        half_board=st.booleans(),
        seed=st.none() | st.integers(0, largest_seed),
        noise=st.none() | st.floats(0, MOST_NOISE),
        detector=names,
        landing=names,
        solver=names,
        trunk_mass=st.none() | st.floats(-0.5, 0.5),
        drives=names,
        pushes=st.lists(PUSHES, max_size=3).map(tuple),
        random_push=st.none() | st.floats(0, LARGEST_IMPULSE),
        estimator=names,
        replan=st.booleans(),
        replan_latency=names,
    )
