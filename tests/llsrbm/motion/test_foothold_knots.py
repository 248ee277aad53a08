import numpy as np

from llsrbm.motion.sampling import foothold_knots
from llsrbm.request.schedule import Phase
from tests.llsrbm.schedules import in_a_row, with_schedule
from tests.llsrbm.synthetic import synthetic_plan

FRONT, HIND = ("LF", "RF"), ("LH", "RH")
ALL = FRONT + HIND


def test_one_jump_stands_where_it_starts_and_where_it_ends():
    plan = synthetic_plan()
    assert foothold_knots(plan).tolist() == [[0] * 4, [48] * 4]


def test_every_place_of_hops_has_its_footholds():
    """The second jump leads as far from the first's landing as it does from its own start."""
    one = synthetic_plan(twist=0.0, forward=0.3)
    plan = in_a_row(one, one)
    feet = plan.foot_position[foothold_knots(plan), np.arange(4)]
    np.testing.assert_allclose(feet[0], one.foot_position[0])
    np.testing.assert_allclose(feet[1], feet[0] + [0.3, 0, 0], atol=1e-12)
    np.testing.assert_allclose(feet[2], feet[0] + [0.6, 0, 0], atol=1e-12)


def test_a_foot_that_lifts_early_stands_where_it_stood():
    plan = with_schedule(
        synthetic_plan(),
        [
            (Phase("take-off", ALL, "takeoff"), 12),
            (Phase("rear push", HIND, "takeoff"), 4),
            (Phase("flight", (), "flight"), 16),
            (Phase("landing", ALL, "landing", 1), 16),
        ],
    )
    assert foothold_knots(plan).tolist() == [[0] * 4, [48] * 4]


def test_a_foot_that_skips_a_place_has_none_there():
    one = synthetic_plan()
    plan = with_schedule(
        in_a_row(one, one),
        [
            (Phase("take-off", ALL, "takeoff"), 16),
            (Phase("flight", (), "flight"), 16),
            (Phase("rebound", HIND, (0.2, 3.0), 1), 32),
            (Phase("flight", (), "flight", 1), 16),
            (Phase("landing", ALL, "landing", 2), 16),
        ],
    )
    assert foothold_knots(plan).tolist() == [[0] * 4, [-1, -1, 64, 64], [96] * 4]
