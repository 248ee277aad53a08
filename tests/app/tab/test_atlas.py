"""The atlas of a tab, without a browser: what it is sent, and what its clicks open."""

import json
import math
from unittest.mock import MagicMock

import pytest

from app.link import AtlasClicked, AtlasSeen, read_event
from app.panel.acts import Act
from app.panel.atlas_controls import AtlasChoice, AtlasControls
from app.tab.atlas import AtlasDrawing, Atlases, JumpOpened
from llsrbm.atlas.learned import TITLE
from llsrbm.errors import InputError
from llsrbm.request.jump import Jump
from llsrbm.request.tuning import Tuning
from tests.app.pure_tab import planned_tab
from tests.llsrbm.atlas.tables import drawn as drawn_rows
from tests.llsrbm.atlas.tables import grid, row, write


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    write(folder / "jumps.parquet", grid())
    return folder


@pytest.fixture(scope="module")
def atlases(folder):
    return Atlases([folder])


class Drawn:
    """The drawing of a tab; `maps` and `marks` are what its page was sent."""

    def __init__(self, atlases):
        self.maps, self.marks = [], []
        self.controls = MagicMock(spec=AtlasControls)
        self.drawing = AtlasDrawing(self.controls, self, atlases)
        self.tab = planned_tab(height=0.0)

    def call(self, function, *arguments):
        """As `PageLink.call`."""
        if function == "atlas.show":
            self.maps += arguments
        else:
            self.marks.append(arguments)

    def take(self, event):
        self.tab.take(event)
        self.drawing.draw(self.tab.state)

    def move(self, **changes):
        self.tab.move(**changes)
        self.drawing.draw(self.tab.state)

    @property
    def told(self):
        return self.controls.show.call_args.args[2]


@pytest.fixture
def drawn(atlases):
    made = Drawn(atlases)
    made.take(AtlasSeen())
    return made


def test_nothing_is_read_before_the_page_shows_the_atlas(atlases):
    drawn = Drawn(atlases)
    drawn.drawing.draw(drawn.tab.state)
    assert drawn.maps == drawn.marks == []
    drawn.take(AtlasSeen())
    (sent,) = drawn.maps
    assert json.loads(json.dumps(sent, allow_nan=False)) == sent
    assert (sent["x"]["title"], sent["x"]["unit"], sent["y"]["title"]) == (
        "Twist",
        "deg",
        "Forward",
    )
    assert sent["slice"] == "Slice: Landing height 0 m"
    assert len(sent["jump"]) == len(sent["fill"]) == 36


def test_the_designs_point_moves_with_the_sliders_and_the_map_only_with_its_slice(drawn):
    drawn.move(twist=math.radians(30), forward=0.2)
    assert len(drawn.maps) == 1
    assert drawn.marks[-1] == pytest.approx((30, 0.2))
    drawn.move(height=0.05)  # the slice stays the same one
    assert len(drawn.maps) == 1
    drawn.move(height=0.2)
    assert [sent["slice"] for sent in drawn.maps][1:] == ["Slice: Landing height 0.2 m"]


def test_another_colour_and_other_axes(drawn):
    choice = AtlasChoice(seen=True, x="height", y="twist", colour="stopped-by", projection="all")
    drawn.take(choice)
    sent = drawn.maps[-1]
    assert (sent["x"]["title"], sent["y"]["title"]) == ("Landing height", "Twist")
    assert [name for _, name in sent["legend"]["keys"]] == ["none (feasible)", "joint torque"]
    assert sent["count"] == [4] * 18


def test_a_robot_that_the_sweep_has_not_is_said_and_the_choice_stays(drawn):
    drawn.take(AtlasChoice(seen=True, colour="flight"))
    drawn.tab.move(robot="slider")
    drawn.tab.settle()
    drawn.drawing.draw(drawn.tab.state)
    assert drawn.maps[-1] is None
    assert drawn.told == "This sweep has no jumps of SLIDER."
    assert drawn.tab.state.atlas.colour == "flight"


def test_a_changed_robot_and_another_model_are_said(drawn):
    drawn.move(model="srbm")
    assert drawn.told == (
        "These jumps are All feet together, LL-SRBM+. "
        "The robot's file has changed since they were planned."
    )


def test_a_click_opens_its_jump_and_undo_takes_it_back(drawn, atlases):
    before = drawn.tab.state.design
    number = drawn.maps[0]["jump"][4 * 1 + 3]
    event = drawn.drawing.opened(AtlasClicked(atlases.names[0], number))
    drawn.take(event)
    jump = drawn.tab.state.design.jump
    assert jump == event.jump
    asked = drawn.tab.submits[-1].task.jump
    assert asked == jump
    assert drawn.marks[-1] == pytest.approx((math.degrees(jump.twist), jump.forward))
    drawn.take(Act.UNDO)
    assert drawn.tab.state.design == before


@pytest.mark.parametrize(("sweep", "number"), [("nosuch", 0), (None, 72), (None, 2**52)])
def test_a_click_on_nothing_is_nothing(drawn, atlases, sweep, number):
    assert drawn.drawing.opened(AtlasClicked(sweep or atlases.names[0], number)) is None


def test_limits_of_a_sweep_come_along_and_other_drives_are_said(drawn):
    event = JumpOpened(Jump(twist=0.5), Tuning(limits={"friction": 0.3}), other_drives=True)
    drawn.take(event)
    assert drawn.tab.state.design.tuning.limits == {"friction": 0.3}
    assert drawn.tab.notes()[0][0] == "Opened with other drives"


def test_limits_are_axes_with_the_robots_own_where_the_design_has_none(tmp_path):
    rows = [
        row(number, forward=x, limit_friction=limit)
        for number, (x, limit) in enumerate((x, limit) for x in (0.0, 0.3) for limit in (0.3, 0.6))
    ]
    write(tmp_path / "jumps.parquet", rows, limits=("friction",))
    drawn = Drawn(Atlases([tmp_path]))
    drawn.take(AtlasSeen())
    assert drawn.maps[-1]["y"]["title"] == "Forward"
    assert drawn.maps[-1]["x"]["title"] == "Limit: friction"
    assert drawn.marks[-1][0] == 0.5


def test_of_a_robot_without_a_table_the_page_says_how_one_is_made(monkeypatch):
    monkeypatch.setattr("llsrbm.atlas.learned.outcomes_of", lambda robot: None)
    drawn = Drawn(Atlases())
    drawn.take(AtlasSeen())
    assert drawn.maps == [None]
    assert drawn.told.endswith("has no table of solved jumps; `llsrbm robot learn` makes one.")
    assert drawn.drawing.opened(AtlasClicked(TITLE, 0)) is None


def test_without_sweeps_the_map_is_of_the_tables_of_solved_jumps():
    drawn = Drawn(Atlases())
    drawn.take(AtlasSeen())
    assert drawn.told == ""
    jump = drawn.drawing.opened(AtlasClicked(TITLE, max(drawn.maps[-1]["jump"]))).jump
    assert jump.robot == "anymal"


def test_sweeps_by_name(folder, tmp_path):
    atlases = Atlases([folder])
    assert atlases.names == (folder.name, TITLE)
    assert atlases.named("") is atlases.named(folder.name)
    assert atlases.named("../../etc") is None
    with pytest.raises(InputError, match="given twice"):
        Atlases([folder, folder, folder])
    with pytest.raises(InputError, match="expected the folder of a sweep"):
        Atlases([tmp_path])


@pytest.mark.parametrize(
    ("message", "event"),
    [
        ('{"kind": "atlas-seen", "count": 1}', AtlasSeen()),
        ('{"kind": "atlas", "sweep": "a", "jump": 7, "count": 1}', AtlasClicked("a", 7)),
        ('{"kind": "atlas", "sweep": "a", "jump": -1}', None),
        ('{"kind": "atlas", "sweep": "a", "jump": NaN}', None),
        ('{"kind": "atlas", "sweep": 3, "jump": 1}', None),
        (f'{{"kind": "atlas", "sweep": "{"x" * 2000}", "jump": 1}}', None),
    ],
)
def test_what_a_page_sends_is_checked(message, event):
    assert read_event(message) == event


def test_jumps_of_a_drawn_sweep_are_described_where_they_are(tmp_path):
    write(tmp_path / "jumps.parquet", drawn_rows())
    drawn = Drawn(Atlases([tmp_path]))
    drawn.take(AtlasSeen())
    sent = drawn.maps[-1]
    assert (sent["x"]["title"], sent["y"]["title"]) == ("Lateral", "Forward")
    opened = drawn.drawing.opened(AtlasClicked(sent["sweep"], sent["jump"][30]))
    assert sent["at"][0][30] == pytest.approx(opened.jump.lateral, rel=1e-3)
    assert sent["at"][1][30] == pytest.approx(opened.jump.forward, rel=1e-3)
