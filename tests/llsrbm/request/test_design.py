"""Design files: what is written comes back, and nothing else is let in."""

import json
import math
import string

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from llsrbm.errors import FileFormatError, InputError
from llsrbm.request.design import LARGEST, Design, dump_design, file_name, load_design
from llsrbm.request.jump import ARMS, Jump
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning
from tests.llsrbm.request.scenarios import scenarios

TWIST = Jump(twist=math.pi / 2)

amounts = st.floats(-100, 100)
names = st.text(string.ascii_lowercase + "_-", min_size=1, max_size=20)
printable = st.characters(categories=("L", "N", "P", "S"))
tables = st.dictionaries(names, st.floats(-1e9, 1e9), max_size=5)
jumps = st.builds(
    Jump, names, names, amounts, amounts, amounts, amounts, arms=st.sampled_from(ARMS)
)
designs = st.builds(
    Design,
    jumps,
    st.builds(Tuning, tables, tables),
    scenarios(names, 2**53 - 1) | st.just(Scenario()),
    title=st.text(printable, max_size=80),
    note=st.text(printable, max_size=400),
)


def written(**changes):
    """A design's file with other values in it."""
    return json.dumps(json.loads(dump_design(Design(TWIST))) | changes).encode()


@given(designs)
def test_a_design_comes_back_as_it_was(design):
    text = dump_design(design)
    assert load_design(text.encode()) == design
    assert dump_design(load_design(text.encode())) == text


def test_a_file_holds_the_task_and_what_differs(tmp_path):
    design = Design(
        Jump(robot="go2", twist=-0.5, forward=0.2, arms="held"),
        Tuning(limits={"friction": 0.4}),
        Scenario(board=0.025, seed=7),
        title="On ice",
    )
    path = tmp_path / file_name(design)
    path.write_text(dump_design(design))
    assert path.name == "on-ice.jump.json"
    assert json.loads(path.read_text()) == {
        "schema": "llsrbm.design/1",
        "title": "On ice",
        "jump": {
            "robot": "go2",
            "model": "llsrbm-plus",
            "twist": -0.5,
            "forward": 0.2,
            "lateral": 0.0,
            "height": 0.0,
            "arms": "held",
        },
        "limits": {"friction": 0.4},
        "scenario": {"board": 0.025, "seed": 7},
    }
    assert load_design(path) == load_design(str(path)) == design


def test_a_file_from_before_there_were_arms_has_them_free():
    content = b'{"schema": "llsrbm.design/1", "jump": {"robot": "g1", "model": "srbm"}}'
    assert load_design(content).jump == Jump("g1", "srbm", arms="free")


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"", "design: an empty file; expected a design (llsrbm.design/1)"),
        (b"PK\x03\x04\xff", "design: not a text file in UTF-8; expected a design"),
        (b"[" * LARGEST, "design: not a JSON file: nested too deeply"),
        (b" " * (LARGEST + 1), "design: too large for a design (llsrbm.design/1); at most 64000"),
        (
            b'{"schema": "llsrbm.design/2", "jump": 1}',
            'design: schema: expected "llsrbm.design/1", got "llsrbm.design/2"',
        ),
        (b'{"schema": 1, "schema": 2}', 'design: "schema" appears twice; expected every key once'),
        (b'{"schema": NaN}', "design: expected finite numbers, got NaN"),
        (b'{"schema": ' + b"9" * 5000 + b"}", "design: not a JSON file: Exceeds the limit (4300"),
        (b'{"schema": "llsrbm.design/1"}', 'design: missing key "jump"; expected: schema, title,'),
        (written(wieghts={}), 'design: unknown key "wieghts"; did you mean "weights"?'),
        (
            written(jump={"robot": "go2"}),
            'design: jump: missing key "model"; expected: robot, model',
        ),
        (
            written(jump={"robot": "go2", "model": "srbm", "pitch": 1.0}),
            "design: jump: pitch: 57.2958 deg; expected whole turns: -360, 0 or 360 deg",
        ),
        (
            written(jump={"robot": "g1", "model": "srbm", "arms": "up"}),
            'design: jump: arms: no choice "up"; valid: free, held',
        ),
        (written(title="x" * 81), "design: title: string should have at most 80 characters, got"),
        (written(note="two\nlines"), "design: note: expected one line of printable text, got"),
        (written(title="\ud800"), "design: title: input should be a valid string, unable to parse"),
        (written(weights={"time": "1"}), "design: weights.time: input should be a valid number"),
        (written(limits={"friction": 1e300}), "design: limits.friction: input should be less than"),
        (written(scenario={"board": -1}), "design: scenario: board: expected 0 to 1 m, got -1"),
        (written(scenario={"half_board": True}), "scenario: half board: expected the board's"),
        (written(scenario={"seed": 2**53}), "scenario: seed: expected at most 9007199254740991"),
        (written(scenario={"board": True}), "scenario: board: expected a finite number, got True"),
        (written(scenario={"detector": "\n"}), "scenario: detector: expected a name, got '\\n'"),
        (
            written(scenario={"sead": 1}),
            'design: scenario: unknown key "sead"; did you mean "seed"? valid: board',
        ),
    ],
)
def test_what_is_no_design_is_refused_in_one_line(content, complaint):
    with pytest.raises(FileFormatError) as refused:
        load_design(content)
    assert complaint in str(refused.value)
    assert str(refused.value).isprintable()
    assert len(str(refused.value)) < 400


@pytest.mark.parametrize("amount", ["1e400", "-1e400", "101", "1e99", '"1"', "true", "null", "[1]"])
def test_an_amount_is_a_number_of_this_world(amount):
    text = (
        '{"schema": "llsrbm.design/1", "jump": '
        f'{{"robot": "go2", "model": "srbm", "twist": {amount}}}}}'
    )
    with pytest.raises(FileFormatError, match=r"jump: twist: expected (a finite|-100)"):
        load_design(text.encode())


@given(st.binary(max_size=300) | st.text(max_size=100).map(str.encode))
@example(b'{"schema": "llsrbm.design/1", "jump": {"robot": "a", "model": "b", "\\ud800": 1}}')
@example(b'{"schema": {"\\n": []}}')
def test_any_bytes_are_a_design_or_refused(content):
    try:
        load_design(content)
    except FileFormatError as refused:
        assert str(refused).isprintable()


@pytest.mark.parametrize(
    "design",
    [
        Design(TWIST, title="two\nlines"),
        Design(TWIST, note="x" * 401),
        Design(Jump(forward=1e6)),
        Design(TWIST, scenario=Scenario(seed=2**53)),
    ],
)
def test_what_no_file_may_hold_is_not_written(design):
    with pytest.raises(InputError, match="this design: "):
        dump_design(design)


@pytest.mark.parametrize(
    ("design", "name"),
    [
        (Design(TWIST), "anymal.jump.json"),
        (Design(TWIST, title="90° twist: srbm / llsrbm"), "90-twist-srbm-llsrbm.jump.json"),
        (Design(TWIST, title="../../etc/passwd"), "etc-passwd.jump.json"),
        (Design(Jump(robot="/home/me/my_robot.toml")), "my-robot.jump.json"),
        (Design(TWIST, title="跳"), "design.jump.json"),
    ],
)
def test_a_file_is_named_after_its_design(design, name):
    assert file_name(design) == name
