from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.errors import InputError
from llsrbm.robots import load_robot
from llsrbm.sweep.points import Points
from tests.llsrbm.sweep.specs import GRID, parse_spec, spec

HEAD = 'title = "x"\nrobots = ["anymal"]\n'
DRAWN = """title = "x"
robots = ["anymal", "go2"]
sampling = "{}"
count = 50
seed = 4
[axes]
twist = {{ from = -1, to = 1 }}
height = {{ range = "robot" }}
forward = [0.0, 0.1, 0.2]
"""

sizes = st.integers(1, 4)


@given(sizes, sizes, sizes, sizes)
def test_the_count_is_that_of_the_points(twists, forwards, frictions, torques):
    def ramp(low, high, count):
        return [low + (high - low) * k / max(count - 1, 1) for k in range(count)]

    twist, forward = ramp(-1, 1, twists), ramp(0, 0.5, forwards)
    friction, torque = ramp(0.3, 0.5, frictions), ramp(0.8, 1.2, torques)
    points = Points(
        parse_spec(
            HEAD
            + f"[axes]\ntwist={{from=-1,to={1 if twists > 1 else -1},count={twists}}}\n"
            + f"forward={forward}\n[limits]\nfriction={friction}\n[drives]\ntorque={torque}\n",
            "x",
        )
    )
    expected = [*product(torque, friction, twist, forward)]
    assert points.count == len(expected)
    assert len({point.id for point in points}) == len(expected)
    for k, point in enumerate(points):
        assert point.number == k
        found = point.drive_torque, point.limits["friction"], point.jump.twist, point.jump.forward
        assert found == pytest.approx(expected[k])


def test_arms_are_free_unless_the_spec_holds_them():
    for line, arms in (("", "free"), ('arms = "held"\n', "held")):
        assert [point.jump.arms for point in Points(parse_spec(HEAD + line, "x"))] == [arms]


def test_rows_and_ids_say_which_point_it_is():
    points = Points(spec(GRID + "[simulate]\nseeds = 3\n"))
    assert points.rows == 3 * points.count
    assert [row for point in points for row in point.rows] == [*range(points.rows)]
    # The same request in another sweep.
    alone = Points(spec(GRID.replace('"anymal", ', "")))
    assert [p.id for p in alone] == [p.id for p in points if p.jump.robot == "go2"]
    with pytest.raises(IndexError):
        points[points.count]


@pytest.mark.parametrize("sampling", ["random", "sobol"])
def test_any_drawn_point_can_be_had_without_those_before_it(sampling):
    text = DRAWN.format(sampling)
    forth = [*Points(spec(text))]
    points = Points(spec(text))
    assert [points[k] for k in reversed(range(points.count))] == forth[::-1]
    assert len({point.id for point in forth}) == 100
    low, high = load_robot("go2").file.task.height
    heights = [p.jump.height for p in forth[50:]]
    assert low <= min(heights) < max(heights) <= high
    assert {p.jump.forward for p in forth} == {0.0, 0.1, 0.2}
    # Both robots are asked the same.
    assert [p.jump.twist for p in forth[:50]] == [p.jump.twist for p in forth[50:]]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HEAD.replace("anymal", "anymall"), 'no robot "anymall"; did you mean "anymal"'),
        (HEAD + 'models = ["point"]', 'no model "point"'),
        (HEAD + 'types = ["cartwheel"]', 'unknown jump type "cartwheel"'),
        (HEAD + "[limits]\nfrictoin = [0.5]", 'no limit "frictoin"; did you mean "friction"'),
        (HEAD + '[simulate]\ndetector = "ear"', "ear"),
        (HEAD + "[axes]\ntwist={from=0,to=1,count=1000000}\nheight={from=0,to=1,count=1000000}\n",
         "1e+12 rows; expected at most 1e+08"),
        (HEAD + "sampling='random'\ncount=1000000000000", "1e+12 rows"),
        (HEAD + "[simulate]\nseeds=1000000000000", "1e+12 rows"),
    ],
)  # fmt: skip
def test_what_there_is_not_is_said_before_anything_begins(text, said):
    with pytest.raises(InputError) as error:
        Points(parse_spec(text, "x"))
    assert said in str(error.value)
    assert "\n" not in str(error.value)
