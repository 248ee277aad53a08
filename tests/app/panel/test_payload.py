"""The slider for what the trunk carries."""

from types import SimpleNamespace

from app.panel.jump_controls import PAYLOAD
from app.panel.summaries import plan_status
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from llsrbm.robots.payload import with_payload
from tests.app.pure_tab import PureTab
from tests.app.synthetic_plan import synthetic_plan


def test_a_mass_is_put_where_the_payload_is_and_none_is_no_payload():
    assert PAYLOAD.put(Jump(), 3.0).payload == (3.0, 0.0, 0.0, 0.0)
    held = Jump(payload=(2.0, 0.1, 0.0, 0.2))
    assert PAYLOAD.put(held, 4.5).payload == (4.5, 0.1, 0.0, 0.2)
    assert PAYLOAD.get(held) == 2.0
    assert PAYLOAD.put(held, 0.0).payload == ()


def test_a_robot_takes_all_that_its_slider_offers():
    tab = PureTab("go2")
    robot = load_robot("go2")
    highest = round(0.5 * robot.mass - 0.05, 1)
    assert PAYLOAD.ends_for(SimpleNamespace(heaviest=highest)) == (0.0, highest)
    with_payload(robot, (highest, 0.0, 0.0, 0.0))  # which raises beyond half of its mass
    tab.move(payload=(highest, 0.0, 0.0, 0.0))
    tab.settle()
    assert tab.state.plan.jump.payload[0] == highest


def test_a_draft_does_not_know_the_payload_and_says_so():
    status = plan_status(synthetic_plan(Jump(payload=(3.0, 0.0, 0.0, 0.0))))
    assert (status.verdict, status.rest) == ("Draft", "as it is of the robot without its payload")
