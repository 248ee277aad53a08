import math
from dataclasses import replace
from xml.etree import ElementTree as ET

import pytest

from app.panel.comparison import Column, comparison_table
from llsrbm.analysis.figures import DesignFigures

BLUE, GREEN = (44, 123, 229), (10, 160, 90)
PLANNED = DesignFigures(
    "planned", 1.3, 0.412, 0.21, 1.57, 1.88, 0.242, 1.86, 177.0, 0.592, 0.71, None, None, 0.1771
)
LANDED = replace(
    PLANNED,
    status="landed",
    flight_time_s=0.382,
    peak_torque_ratio=0.97,
    yaw_error_at_touchdown=math.radians(-1.3),
    solve_time_s=0.095,
)


def rows(*columns):
    """Rows of the table, cell elements; it has to be well-formed for that."""
    root = ET.fromstring(comparison_table(columns))
    return {"".join(row[0].itertext()): list(row[1:]) for row in root.iter("tr")}


def texts(cells):
    return ["".join(cell.itertext()) for cell in cells]


@pytest.fixture(scope="module")
def two():
    return rows(Column("90° srbm", BLUE, PLANNED), Column("90° llsrbm", GREEN, LANDED))


def test_figures_are_rows_with_units_and_designs_columns(two):
    assert texts(two["Status"]) == ["planned", "landed"]
    assert texts(two["Flight time [s]"]) == ["0.412", "0.382"]
    assert texts(two["Least yaw inertia Izz [kg m²]"]) == ["1.86", "1.86"]
    assert texts(two["Planned torque [%]"]) == ["71", "71"]
    assert texts(two["Peak torque [%]"]) == ["–", "97"]
    assert texts(two["Yaw at contact [°]"]) == ["–", "−1.3"]
    assert texts(two["Solve time [ms]"]) == ["177", "95"]


def test_the_best_is_bold(two):
    bold = {
        name: [i for i, cell in enumerate(cells) if "bold" in cell.get("style")]
        for name, cells in two.items()
        if any("bold" in cell.get("style") for cell in cells)
    }
    assert bold == {"Solve time [ms]": [1]}


def test_the_difference_to_the_current_design_is_told_on_hover(two):
    current, other = two["Flight time [s]"]
    assert current.get("title") is None
    assert other.get("title") == "−0.030 s against the current design"
    assert two["Peak torque [%]"][1].get("title") is None


def test_names_have_the_colours_of_their_ghosts():
    html = comparison_table([Column("a", BLUE, PLANNED), Column("b", GREEN, PLANNED)])
    first, second = (html.index(text) for text in (">a</div>", ">b</div>"))
    assert html.index("rgba(44,123,229,1)") < first < html.index("rgba(10,160,90,1)") < second


def test_whether_a_push_was_recovered_from_is_told_of_those_that_were_pushed():
    assert "Recovered" not in comparison_table([Column("a", BLUE, LANDED)])
    columns = [Column(str(known), BLUE, LANDED, known) for known in (True, False, None)]
    (row,) = [row for row in comparison_table(columns).split("<tr>") if "Recovered" in row]
    assert [word in row for word in (">yes<", ">no<", ">–<")] == [True] * 3


def test_names_cannot_write_the_page():
    bad = '<script>alert("x")</script>&\' onclick="y"'
    html = comparison_table([Column(bad, BLUE, replace(PLANNED, status=bad))])
    assert "<script" not in html
    root = ET.fromstring(html)
    assert not [name for element in root.iter() for name in element.attrib if name == "onclick"]
    assert bad in "".join(root.itertext())
