"""Routes of several landings as a jump, a file and a design state them."""

import json
import math

import pytest

from llsrbm.commands.options import in_words
from llsrbm.errors import InputError
from llsrbm.request.design import Design, dump_design, load_design
from llsrbm.request.jump import Jump
from llsrbm.request.route import Landing, load_route, through, waypoints

ROUTE = (Landing(forward=0.3), Landing(forward=0.2, height=0.1, twist=0.5, slope=0.2))
FILE = """
[[landing]]
forward = 0.3

[[landing]]
forward = 0.2
height = 0.1
twist = 90
cross_slope = -10
"""


def test_a_route_is_the_same_however_it_is_given():
    jump = Jump(route=ROUTE)
    assert jump.type == "hops"
    assert jump.jumps == 2
    assert Jump(**jump.as_dict()) == jump
    assert Jump(route=[landing._asdict() for landing in ROUTE]) == jump
    assert hash(jump) == hash(Jump(route=list(ROUTE)))


def test_a_route_of_one_landing_is_a_plain_jump():
    plain = Jump(forward=0.2, height=0.1, twist=0.5, slope=0.2)
    assert Jump(route=ROUTE[1:]) == plain
    assert "route" not in plain.as_dict()


def test_a_design_has_it():
    jump = Jump(route=ROUTE)
    text = dump_design(Design(jump))
    assert json.loads(text)["jump"]["route"] == jump.as_dict()["route"]
    assert load_design(text.encode()).jump == jump


def test_its_file_has_degrees(tmp_path):
    path = tmp_path / "course.toml"
    path.write_text(FILE)
    first, second = load_route(path)
    assert first == Landing(forward=0.3)
    assert second == Landing(0.2, 0.0, 0.1, math.pi / 2, 0.0, math.radians(-10))
    assert "landing 2: twist 90°" in in_words(Jump(route=(first, second)))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("forward = 1", "expected a route"),
        ("landing = 3", "expected a route"),
        ("landing = []", "no landing; expected a route"),
        ("[[landing]]\nslope = 40", "(-30 to 30 deg), got 0.698132 (40 deg)"),
        ("[[landing]]\nforwards = 1", "landing 1: unknown 'forwards'; did you mean \"forward\"?"),
        ("[[landing]]\nforward = 50", "landing 1: forward: expected -3 to 3 m, got 50"),
        ("[[landing]]\nslope = 45", "landing 1: slope: expected"),
        ("[[landing]]\nforward = '1'", "landing 1: forward: expected a finite number"),
        ("[[landing]]\n" * 6, "at most 5 landings"),
    ],
)
def test_a_wrong_file_is_one_line(tmp_path, text, said):
    path = tmp_path / "course.toml"
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        load_route(path)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("given", [3, "abc", {"forward": 1}, [3], [{"forward": math.nan}]])
def test_what_is_no_route_is_refused(given):
    with pytest.raises(InputError, match="route"):
        Jump(route=given)


def test_a_route_alone_says_where_to_jump():
    with pytest.raises(InputError, match="route: the request has forward, too"):
        Jump(route=ROUTE, forward=0.1)
    with pytest.raises(InputError, match="route: the request has hops, too"):
        Jump(route=ROUTE, hops=2)


def test_a_row_of_jumps_is_so_many_by_themselves_each_from_the_slope_before():
    first, second = Jump(robot="go2", route=ROUTE, takeoff_slope=0.1).singly(ROUTE)
    assert first == Jump(robot="go2", forward=0.3, takeoff_slope=0.1)
    assert second == Jump(robot="go2", forward=0.2, height=0.1, twist=0.5, slope=0.2)
    two = Jump(type="hops", hops=2, forward=0.2).singly([None, None])
    assert two == (Jump(forward=0.2),) * 2


def test_places_and_landings_are_the_same_route():
    quarter = math.pi / 2
    route = (
        Landing(forward=0.3, height=0.1, twist=quarter),
        Landing(forward=0.2, lateral=0.1, slope=0.1),
        Landing(lateral=-0.3, twist=-quarter, cross_slope=0.2),
    )
    places = waypoints(route)
    expected = [(0.3, 0, 0.1, quarter), (0.2, 0.2, 0.1, quarter), (0.5, 0.2, 0.1, 0)]
    for place, there in zip(places, expected, strict=True):
        assert place == pytest.approx(there)
    for again, landing in zip(through(places, route), route, strict=True):
        assert again == pytest.approx(landing)
    assert all(landing.slope == landing.cross_slope == 0.0 for landing in through(places))


def test_a_route_is_gone_along_without_what_its_jump_was():
    hurdle = Jump(robot="go2", type="hurdle", forward=0.4, payload=(2.0,), stones={"FL": (0.02, 0)})
    jump = hurdle.along(ROUTE)
    assert jump == Jump(robot="go2", payload=(2.0,), route=ROUTE)
    assert jump.along(ROUTE[:1]) == Jump(robot="go2", payload=(2.0,), forward=0.3)
    assert jump.along(()) == Jump(robot="go2", payload=(2.0,))
    assert jump.landings == ROUTE
    assert Jump(forward=0.2, hops=3, type="hops").landings == 3 * (Landing(forward=0.2),)


def test_a_route_of_a_type_of_ones_own_stays_of_it(tmp_path):
    own = tmp_path / "own.toml"
    jump = Jump(type=str(own), route=ROUTE)
    assert jump.along((*ROUTE, ROUTE[0])).type == str(own)
