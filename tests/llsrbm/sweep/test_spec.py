import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.errors import InputError
from llsrbm.installed import assets_directory
from llsrbm.sweep.points import Points
from llsrbm.sweep.spec import Spec, find_spec
from tests.llsrbm.sweep.specs import GRID, parse_spec, spec

HEAD = 'title = "x"\nrobots = ["anymal"]\n'

numbers = st.floats(-3, 3).map(lambda x: round(x, 6))
lists = st.lists(numbers, min_size=1, max_size=4, unique=True).map(
    lambda values: f"[{', '.join(map(repr, values))}]"
)
ranges = st.tuples(numbers, st.floats(0.01, 2), st.integers(1, 5)).map(
    lambda r: f"{{ from = {r[0]!r}, to = {r[0] + r[1]!r}, count = {r[2]} }}"
)
axes = st.dictionaries(
    st.sampled_from(["twist", "forward", "lateral", "height", "speed"]), lists | ranges, max_size=4
)


@given(axes)
def test_any_grid_survives_being_sent(axes):
    text = HEAD + "[axes]\n" + "".join(f"{name} = {axis}\n" for name, axis in axes.items())
    one = parse_spec(text, "x.toml")
    other = Spec.from_table(json.loads(json.dumps(one.as_table())))
    assert other == one
    assert other.digest() == one.digest()


@given(st.text(max_size=60))
def test_whatever_the_text_one_line_says_what_is_wrong(text):
    try:
        parse_spec(text, "x.toml")
    except InputError as error:
        assert str(error).startswith("x.toml: ")
        assert "\n" not in str(error)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[axes]\ntwits = [1]", 'unknown key "axes.twits"; did you mean "twist"?'),
        ("[axes]\ntwist = { from = 1, to = 0, count = 3 }", "from 1 to 0 is empty"),
        ("[axes]\ntwist = { from = 0, to = 1, count = 0 }", "axes.twist.count"),
        ("[axes]\ntwist = { from = 0, to = 1 }", 'axes.twist: missing "count"'),
        ("[axes]\ntwist = [1, 1]", "listed twice"),
        ("[axes]\ntwist = 'far'", "axes.twist: expected a number, a list or a table"),
        ("[axes]\ntwist = [nan]", "finite number"),
        ("[axes]\ntwist = [1]\ntwist_deg = [1]", "are the same"),
        ("[axes]\nslope = [0.1]\nslope_deg = [5]", "are the same"),
        ("[axes]\nslope_deg = { from = 0, to = 40, count = 2 }", "axes.slope_deg: expected"),
        ("[axes]\npitch_deg = [90]", "whole turns"),
        ("[axes]\npitch_deg = { from = 0, to = 360, count = 3 }", "expected a list of values"),
        ("[axes]\nhops = [1.5]", "expected a whole number"),
        ("[axes]\nspeed = { range = 'robot', count = 2 }", 'range = "robot" is for twist'),
        ("[limits]\nfriction = { range = 'robot', count = 2 }", "has no range of it"),
        ("[drives]\ntorque = { from = 1, to = 2, count = 2 }", "expected a list of factors"),
        ("[drives]\npower = [1]", 'unknown key "drives.power"; valid: torque, speed'),
        ("[simulate]\nseeds = [1, 1]", "simulate.seeds"),
        ("[simulate]\nseed = 1", 'expected "seeds"'),
        ("[simulate]\nnoise = 10", "noise: expected 0 to 3"),
        ("[simulate]\nwind = 1", "wind"),
        ("sampling = 'dense'", "'grid', 'random' or 'sobol'"),
        ("sampling = 'sobol'", "count: missing"),
        ("count = 3", "count: a grid has"),
        ('robots = ["anymal"]', 'missing key "title"'),
        ('title = "x"\nrobots = []', "robots: expected at least 1"),
        ('title = "x"\nrobots = ["go2", "go2"]', "robots: one is named twice"),
        ("title = '", "not a TOML file"),
    ],
)
def test_a_bad_spec_gets_one_line(text, said):
    with pytest.raises(InputError) as error:
        parse_spec(text if "robots" in text else HEAD + text, "x.toml")
    assert said in str(error.value)
    assert str(error.value).startswith("x.toml: ")
    assert "\n" not in str(error.value)


def test_comments_do_not_make_another_spec_but_values_do():
    assert spec(GRID + "# more\n").digest() == spec().digest()
    assert spec(GRID.replace("0.2", "0.3")).digest() != spec().digest()
    assert spec("seed = 3\n" + GRID).digest() != spec().digest()


def test_seeds_are_a_jumps_own_or_those_listed():
    own = parse_spec("seed = 100\n" + HEAD + "[axes]\ntwist=[0,1]\n[simulate]\nseeds = 2", "x")
    assert [p.seeds for p in Points(own)] == [(100, 101), (102, 103)]
    listed = parse_spec(HEAD + "[axes]\ntwist=[0,1]\n[simulate]\nseeds = [7, 5]", "x")
    assert [p.seeds for p in Points(listed)] == [(7, 5), (7, 5)]
    none = parse_spec(HEAD + "[axes]\ntwist=[0,1]\n[simulate]\nboard = 0.02", "x")
    assert [p.seeds for p in Points(none)] == [(None,), (None,)]
    assert none.scenario().board == 0.02
    assert parse_spec(HEAD, "x").scenario() is None


@pytest.mark.parametrize("path", sorted((assets_directory() / "sweeps").glob("*.toml")))
def test_shipped_sweeps_can_be_run(path):
    assert Points(find_spec(path.stem)).count > 0


def test_sizes_of_shipped_sweeps():
    quick = Points(find_spec("quick"))
    assert 150 <= quick.rows <= 250
    assert set(quick.spec.robots) == {"anymal", "go2", "slider"}
    assert quick.spec.simulated
    assert Points(find_spec("anymal-10k")).rows == 10_000
    assert Points(find_spec("anymal-2k-simulated")).rows == 2_000


def test_a_name_that_there_is_not():
    with pytest.raises(InputError, match='no sweep "quik"; did you mean "quick"'):
        find_spec("quik")
    with pytest.raises(InputError, match="cannot be read"):
        find_spec("./quick.toml")
