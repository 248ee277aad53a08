import math
from dataclasses import replace

import pytest

from llsrbm.look.titles import file_words, title, title_of, titles_of
from llsrbm.request.jump import Jump
from llsrbm.request.route import Landing
from llsrbm.request.scenario import Push, Scenario
from llsrbm.request.tuning import Tuning
from tests.app.synthetic_plan import refined_plan, synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout

TWIST = Jump(twist=math.pi / 2)
UP_TO = Landing(forward=0.2)
TURNED = Landing(forward=0.3, twist=math.pi / 2, slope=math.radians(10))
PUSH = Push(0.4, (0, 12, 0))


@pytest.mark.parametrize(
    ("title", "decisions"),
    [
        ("90° llsrbm-plus", (TWIST,)),
        (
            "-45° + 30 cm back + 12.5 cm right + 10 cm down srbm",
            (Jump("anymal", "srbm", -math.pi / 4, -0.3, -0.125, -0.1),),
        ),
        (
            "route: 20 cm forward, 90° + 30 cm forward, slope 10° llsrbm-plus",
            (Jump(route=(UP_TO, TURNED)),),
        ),
        ("route of 3 landings llsrbm-plus", (Jump(route=(UP_TO, TURNED, UP_TO)),)),
        ("my 20 cm forward srbm", (Jump("/some/where/my.toml", "srbm", forward=0.2),)),
        (
            "90° llsrbm-plus, seed 7, half board 25 mm",
            (TWIST, Tuning(), Scenario(board=0.025, half_board=True, seed=7)),
        ),
        (
            "90° llsrbm-plus, seed 0, noise 2, norm, trunk +12 %",
            (TWIST, Tuning(), Scenario(noise=2.0, detector="norm", trunk_mass=0.12)),
        ),
        (
            "90° llsrbm-plus, push 13 N s at 0.45 s, replanning",
            (TWIST, Tuning(), Scenario(pushes=(Push(0.45, (5, 12, 0)),), replan=True)),
        ),
        (
            "90° llsrbm-plus, push 3 N m s at 1 s, random push 10 N s, estimator drift",
            (
                TWIST,
                Tuning(),
                Scenario(
                    pushes=(Push(1, (0, 0, 0), (0, 0, 3)),), random_push=10, estimator="drift"
                ),
            ),
        ),
        ("90° llsrbm-plus, 2 pushes", (TWIST, Tuning(), Scenario(pushes=(PUSH, PUSH)))),
        ("g1 180° llsrbm-plus, arms held", (Jump("g1", twist=math.pi, arms="held"),)),
        ("go2 back flip llsrbm-plus", (Jump("go2", type="flip", pitch=-math.tau),)),
        (
            "2 x front flip + 90° llsrbm-plus",
            (Jump(type="flip", pitch=2 * math.tau, twist=math.pi / 2),),
        ),
        ("2 hops of 20 cm forward llsrbm-plus", (Jump(type="hops", forward=0.2, hops=2),)),
        (
            "rear-last 90° + 30 cm forward llsrbm-plus",
            (Jump(type="rear-last", twist=math.pi / 2, forward=0.3),),
        ),
        (
            "run-up 30 cm forward from 0.5 m/s to 0.25 m/s llsrbm-plus",
            (Jump(type="run-up", forward=0.3, speed=0.5, end_speed=0.25),),
        ),
    ],
)
def test_a_title_tells_what_was_decided(title, decisions):
    assert title_of(*decisions) == title


@pytest.mark.parametrize(
    ("words", "jump"),
    [
        ("twist90", TWIST),
        (
            "twist-45_back30cm_right12cm_down10cm_srbm",
            Jump("anymal", "srbm", -math.pi / 4, -0.3, -0.124, -0.1),
        ),
        ("on-the-spot", Jump(twist=1e-3)),
        ("backflip", Jump("go2", type="flip", pitch=-math.tau)),
        ("2xfrontflip_twist90", Jump(type="flip", pitch=2 * math.tau, twist=math.pi / 2)),
        ("hops2_forward20cm", Jump(type="hops", forward=0.2, hops=2)),
        ("rear-last_forward30cm", Jump(type="rear-last", forward=0.3)),
        ("mine_up10cm", Jump(type="/some/where/mine.toml", height=0.1)),
    ],
)
def test_a_files_name_tells_the_request(words, jump):
    assert file_words(jump) == words


def test_a_motions_title_has_robot_and_model_as_in_menus():
    draft = synthetic_plan(replace(TWIST, robot="go2"))
    assert title(draft) == "Unitree Go2: 90° LL-SRBM+"
    assert title(refined_plan(draft)) == "Unitree Go2: 90° whole body"
    assert title(synthetic_rollout(draft, seed=7)) == "Unitree Go2: 90° LL-SRBM+, seed 7"
    mine = replace(draft, jump=Jump("/some/where/my.toml", "srbm", forward=0.2))
    assert title(mine) == "my: 20 cm forward SRBM"


def test_several_tell_what_differs_only():
    friction, seeded = Tuning(limits={"friction": 0.4}), Scenario(board=0.02, seed=3)
    slider = [Jump("slider", "srbm", 1.0), Jump("slider", "llsrbm", 1.0)]
    assert titles_of([(jump, friction, seeded) for jump in slider]) == (
        "57.3° srbm",
        "57.3° llsrbm",
    )
    assert titles_of([(TWIST, Tuning(), seeded), (TWIST, friction, Scenario(board=0.02))]) == (
        "90° llsrbm-plus, seed 3",
        "90° llsrbm-plus, friction 0.4",
    )
    assert titles_of([(TWIST, Tuning(), None), (Jump("go2"), Tuning(), None)]) == (
        "90° llsrbm-plus",
        "go2 on the spot llsrbm-plus",
    )
    assert titles_of([(Jump("g1", arms=arms), Tuning(), None) for arms in ("free", "held")]) == (
        "on the spot llsrbm-plus",
        "on the spot llsrbm-plus, arms held",
    )


def test_what_is_named_alike_is_numbered():
    other = Jump(twist=1.0)
    assert titles_of([(jump, Tuning(), None) for jump in (TWIST, other, TWIST)]) == (
        "90° llsrbm-plus (1)",
        "57.3° llsrbm-plus",
        "90° llsrbm-plus (2)",
    )
    assert titles_of([]) == ()
