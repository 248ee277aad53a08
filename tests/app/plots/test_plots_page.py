"""The plots in a real browser."""

from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from app.plots.charts import charts as charts_of
from app.plots.charts import shown_layers
from app.plots.choice import LANDING, PRESETS, TORQUES
from tests.app.chromium import VIEW, at_rest, choose, fill, player, press, status, tab
from tests.app.waits import wait_until

# viser lists charts in the order in which they were made, or made anew.
IN_ORDER = """Object.values(window.__viserTestpoints.uplots).sort((a, b) =>
  a.chart.root.compareDocumentPosition(b.chart.root) & Node.DOCUMENT_POSITION_FOLLOWING ? -1 : 1)"""
CHARTS = f"""() => {IN_ORDER}.map(({{chart, createCount}}) => ({{
  title: chart.root.querySelector('.u-title').firstChild.textContent,
  start: chart.scales.x.min,
  end: chart.scales.x.max,
  ticks: chart.axes.map(axis => (axis._values || []).length),
  curves: chart.series.flatMap((series, i) => series.scale === 'y'
    && chart.data[i].some(v => !Number.isNaN(v)) ? [series.label] : []),
  aligned: chart.series.length === chart.data.length,
  width: chart.over.clientWidth,
  created: createCount,
}}))"""


@pytest.fixture
def page(page):
    """With the controls of the plots, and the overview, in sight."""
    tab(page, "Plots")
    return page


def simulate(page):
    press(page, "Simulate")
    status(page, "Landed")


def drawn(page, titles, timeout=10.0):
    """The charts, once they have these titles."""
    page.wait_for_function(
        f"titles => JSON.stringify({IN_ORDER}.map(({{chart}}) =>"
        " chart.root.querySelector('.u-title').firstChild.textContent)) === JSON.stringify(titles)"
        # A chart that is new in the page is measured later.
        " && Object.values(window.__viserTestpoints.uplots).every("
        "({chart}) => chart.over.clientWidth > 200)",
        arg=titles,
        timeout=1e3 * timeout,
    )
    page.wait_for_timeout(300)
    charts = page.evaluate(CHARTS)
    for chart in charts:
        assert chart["aligned"], chart
        assert chart["width"] > 200, chart
        assert min(chart["ticks"]) >= 2, chart
    return charts


OVERVIEW_CHARTS = [
    "Base angle, yaw [°]",
    "Angular velocity, z [rad/s]",
    "Inertia, zz [kg m²]",
    "Vertical force, all feet [N]",
]


def test_every_group_is_drawn_with_plan_and_simulation_with_values_and_figures(page):
    charts = drawn(page, OVERVIEW_CHARTS)
    assert [chart["curves"] for chart in charts] == [["plan"]] * 4
    assert {chart["end"] for chart in charts} == {1.5}
    simulate(page)
    charts = drawn(page, OVERVIEW_CHARTS)
    assert [chart["curves"] for chart in charts] == [["plan", "simulation"]] * 4
    assert {chart["end"] for chart in charts} == {2.5}
    values_are_written_beside_the_titles(page)
    a_chart_is_copied_for_a_paper(page)
    layers = shown_layers(page.session.state.shown.planned, page.session.state.rollout)
    for group in (LANDING, TORQUES, "Contact forces"):
        choose(page, "Preset", group)
        headings = [chart.heading for chart in charts_of(PRESETS[group], layers)]
        charts = drawn(page, headings)
        assert 3 <= len(charts) <= 5, group
        for chart in charts:
            assert "simulation" in chart["curves"], chart
            span = chart["end"] - chart["start"]
            assert 0.3 < span < 0.5 if group == LANDING else span == 2.5, chart
    the_box_has_all_lines_by_name(page)


# ---- cursor and values

CURSORS = """() => Object.values(window.__viserTestpoints.uplots).map(({chart}) => {
  const cursors = chart.over.querySelectorAll('.llsrbm-cursor');
  if (cursors.length !== 1 || cursors[0].style.display === 'none') return null;
  const left = cursors[0].getBoundingClientRect().left - chart.over.getBoundingClientRect().left;
  return chart.posToVal(left, 'x');
})"""
SEEK = "time => window.llsrbm.player.seek(time)"
SHOW = "time => llsrbm.plots.show(time)"


def wait_for_cursors(page, count, time):
    page.wait_for_function(
        f"([count, time]) => {{ const at = ({CURSORS})();"
        " return at.length === count"
        " && at.every(t => time === null ? t === null : t !== null && Math.abs(t - time) < 0.02) }",
        arg=[count, time],
        timeout=10_000,
    )


def test_the_cursor_is_where_the_motion_is(page):
    at_rest(page)
    page.evaluate(SHOW, 0.2)
    assert page.evaluate(CURSORS) == [pytest.approx(0.2, abs=0.02)] * 4
    page.evaluate(SHOW, 9.0)  # beyond the axis
    wait_for_cursors(page, 4, None)
    page.evaluate(SEEK, 0.65)
    wait_for_cursors(page, 4, 0.65)
    # It outlives charts that are built anew, and other data.
    choose(page, "Preset", "Base angles")
    wait_for_cursors(page, 3, 0.65)
    fill(page, "Twist [deg]", 30)
    page.wait_for_function(
        "() => Object.values(window.__viserTestpoints.uplots).some(({chart}) =>"
        " Math.abs(Math.max(...chart.data[2].filter(Number.isFinite)) - 30) < 1)"
    )
    wait_for_cursors(page, 3, 0.65)


VALUES = """() => Object.values(window.__viserTestpoints.uplots).map(({chart}) =>
  [...chart.root.querySelectorAll('.llsrbm-values span')].map(span => Number(span.textContent)))"""
DATA = """time => Object.values(window.__viserTestpoints.uplots).map(({chart}) =>
  chart.series.flatMap((series, i) => series.scale === 'y' && series.class === 'curve'
    ? [chart.data[i][chart.valToIdx(time)]] : []))"""

SPANS = """() => Object.values(window.__viserTestpoints.uplots).map(({chart}) =>
  chart.scales.y.max - chart.scales.y.min)"""


def values_are_written_beside_the_titles(page):
    at_rest(page)
    page.evaluate(SHOW, 0.65)
    spans, data = page.evaluate(SPANS), page.evaluate(DATA, 0.65)

    def written():
        values = page.evaluate(VALUES)
        return [len(row) for row in values] == [2] * 4 and all(
            row == pytest.approx(true, abs=0.006 * span)  # with three digits at most
            for row, true, span in zip(values, data, spans, strict=True)
        )

    wait_until(written, "the values")
    # Under the pointer, while it is there.
    over = page.locator(".u-over").nth(1)
    box = over.bounding_box()
    over.hover(position={"x": 0.2 * box["width"], "y": 20})
    # The yaw turns by 2.5° from one instant of the chart to the next.
    pointed = page.evaluate(DATA, 0.5)[0]
    assert pointed != pytest.approx(data[0], abs=6.0)
    wait_until(lambda: page.evaluate(VALUES)[0] == pytest.approx(pointed, abs=3.0), "other values")
    page.mouse.move(10, 10)
    wait_until(written, "the values again")


BOX = """() => { const box = document.querySelector('.llsrbm-hover');
  return box.style.display === 'block' ? [...box.querySelectorAll('tr')].map(row =>
    [...row.children].map(cell => cell.textContent)) : null; }"""


def the_box_has_all_lines_by_name(page):
    choose(page, "Preset", "Joint torques and speeds")
    page.wait_for_function("document.querySelector('.u-title').textContent.startsWith('Largest')")
    titles = [chart["title"] for chart in page.evaluate(CHARTS)]
    drawn(page, titles)
    over = page.locator(".u-over").nth(3)
    box = over.bounding_box()
    over.hover(position={"x": 0.1 * box["width"], "y": 20})
    wait_until(lambda: page.evaluate(BOX), "the box")
    found = page.evaluate(BOX)
    assert [name for name, *_ in found] == ["time", "plan", "simulation"]
    assert {unit for _, _, unit in found[1:]} == {"W"}
    assert not any("-0" in value and float(value) == 0 for _, value, _ in found)
    over = page.locator(".u-over").first
    over.hover(position={"x": 0.1 * box["width"], "y": 20})
    limit = lambda: [row[:2] for row in (page.evaluate(BOX) or [])[1:2]]  # noqa: E731
    wait_until(lambda: limit() == [["limit", "1.00"]], "the limit")
    page.mouse.move(10, 10)
    wait_until(lambda: page.evaluate(BOX) is None, "no box")


# ---- the area

BOXES = """() => Object.fromEntries([['area', '[data-llsrbm-pinned]'], ['picture', 'canvas'],
  ['bar', '#llsrbm-transport']].map(([name, where]) => {
    const box = document.querySelector(where)?.getBoundingClientRect();
    return [name, box && [box.left, box.top, box.right, box.bottom].map(Math.round)];
  }))"""


TOPS = """[...document.querySelectorAll('.uplot')].map(e => e.offsetParent
  && Math.round(e.getBoundingClientRect().top))"""


@pytest.mark.parametrize(
    ("view", "rows"), [(VIEW, 2), ({"width": 1920, "height": 1080}, 1)], ids=["small", "large"]
)
def test_charts_are_as_wide_as_the_picture_and_cover_nothing(page, view, rows):
    page.set_viewport_size(view)

    def arranged():
        boxes = page.evaluate(BOXES)
        area, picture, bar = boxes["area"], boxes["picture"], boxes["bar"]
        return (
            (area[0], area[2], area[3]) == (picture[0], picture[2], view["height"])
            and max(picture[3], bar[3]) <= area[1] + 1
            and picture[3] - picture[1] > 0.45 * view["height"]
            and len(set(page.evaluate(TOPS))) == rows  # side by side
        )

    wait_until(arranged, "the arrangement")
    drawn(page, OVERVIEW_CHARTS)
    the_page_stays_where_it_is_whatever_is_scrolled_into_view(page)


def the_page_stays_where_it_is_whatever_is_scrolled_into_view(page):
    scrolled = """(where) => {
      const low = document.createElement("div");
      low.id = "low";
      low.style.cssText = "position: absolute; top: 100%; height: 50px; width: 50px";
      document.querySelector(where).append(low);
      low.scrollIntoView();
      return document.querySelector("canvas").getBoundingClientRect().top;
    }"""
    for where in ("body", "[data-dock-root]"):
        assert page.evaluate(scrolled, where) < 0
        wait_until(lambda: page.evaluate(BOXES)["picture"][1] == 0, "the picture's place")
        page.evaluate("document.getElementById('low').remove()")


def test_the_area_is_minimised_and_opened(page):
    drawn(page, OVERVIEW_CHARTS)
    fields_of_viser_that_are_missing_are_named(page)
    page.locator("[data-llsrbm-pinned] [data-dock-minimize]").first.click()
    page.wait_for_function("document.querySelectorAll('.uplot').length === 0")
    tab(page, "Plots")
    box = page.get_by_label("Plot area")
    wait_until(lambda: not box.is_checked(), "the server's word")

    def flat():
        boxes = page.evaluate(BOXES)
        top, bottom = boxes["area"][1], boxes["area"][3]
        return bottom - top < 40 and boxes["picture"][3] <= top + 1

    wait_until(flat, "the picture in its place")
    box.click()
    drawn(page, OVERVIEW_CHARTS)


def fields_of_viser_that_are_missing_are_named(page):
    assert page.evaluate("llsrbm.plots.missing()") == []
    lost = """() => { const points = window.__viserTestpoints, uplots = points.uplots;
      delete points.uplots;
      const without = llsrbm.plots.missing();
      points.uplots = { some: { chart: { over: document.body } } };
      const lacking = llsrbm.plots.missing();
      points.uplots = uplots;
      return [without, lacking]; }"""
    without, lacking = page.evaluate(lost)
    assert without == ["__viserTestpoints.uplots"]
    assert "__viserTestpoints.uplots: posToVal" in lacking
    assert "__viserTestpoints.uplots: over" not in lacking


def test_a_click_tells_its_time_and_a_drag_does_not(page):
    end = drawn(page, OVERVIEW_CHARTS)[1]["end"]
    over = page.locator(".u-over").nth(1)
    over.scroll_into_view_if_needed()
    box = over.bounding_box()
    middle = box["y"] + box["height"] / 2
    page.mouse.click(box["x"] + 0.4 * box["width"], middle)
    assert player(page, "time") == pytest.approx(0.4 * end, abs=0.02 * end)
    page.mouse.move(box["x"] + 0.2 * box["width"], middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.7 * box["width"], middle, steps=4)
    page.mouse.up()
    page.wait_for_timeout(300)
    assert player(page, "time") == pytest.approx(0.4 * end, abs=0.02 * end)
    # The drag has zoomed, and the cursor goes with the axis.
    page.evaluate(SEEK, 0.5 * end)
    for zoomed in page.evaluate(CHARTS):
        assert zoomed["start"] == pytest.approx(0.2 * end, abs=0.02 * end)
        assert zoomed["end"] == pytest.approx(0.7 * end, abs=0.02 * end)
    wait_for_cursors(page, 4, 0.5 * end)
    page.wait_for_timeout(500)  # viser makes charts anew as it likes

    def unzoomed():
        # A chart that is being made anew takes no clicks.
        page.mouse.dblclick(box["x"] + 0.4 * box["width"], middle)
        page.wait_for_timeout(500)
        return page.evaluate(f"end => ({CHARTS})().every(c => c.end === end)", end)

    wait_until(unzoomed, "the whole axis")


RANGE = f"""() => {{
  const {{ min, max }} = {IN_ORDER}[1].chart.scales.y;
  return [min, max];
}}"""


def test_values_are_zoomed_by_the_axis_and_stay_so(page):
    drawn(page, OVERVIEW_CHARTS)
    whole = page.evaluate(RANGE)
    over = page.locator(".u-over").nth(1)
    over.scroll_into_view_if_needed()
    box = over.bounding_box()
    page.mouse.move(box["x"] - 20, box["y"] + box["height"] / 2)  # on the axis
    page.mouse.wheel(0, -400)
    page.wait_for_function(f"whole => ({RANGE})()[1] < whole[1]", arg=whole)
    zoomed = page.evaluate(RANGE)
    assert whole[0] < zoomed[0] < zoomed[1] < whole[1]
    # Other values do not end it.
    fill(page, "Twist [deg]", 120)
    wait_until(lambda: page.session.state.plan.jump.twist > 2, "the plan")
    page.wait_for_timeout(300)
    assert page.evaluate(RANGE) == pytest.approx(zoomed)
    page.mouse.down()
    page.mouse.move(box["x"] - 20, box["y"] + box["height"] / 2 + 15, steps=3)
    page.mouse.up()
    assert page.evaluate(RANGE)[0] > zoomed[0]
    page.mouse.dblclick(box["x"] - 20, box["y"] + box["height"] / 2)
    page.wait_for_function(f"zoomed => ({RANGE})()[1] > zoomed[1] + 0.1", arg=zoomed)


def a_chart_is_copied_for_a_paper(page):
    chart = f"{IN_ORDER}[0].chart"
    svg = ET.fromstring(page.evaluate(f"llsrbm.plotFigure.svgOf({chart})"))
    assert svg.get("width") == "88mm"
    words = [text.text for text in svg.iter("{http://www.w3.org/2000/svg}text")]
    assert {"Base angle, yaw [°]", "plan", "simulation", "time [s]", "50"} <= set(words)
    curves = [
        path.get("d")
        for path in svg.iter("{http://www.w3.org/2000/svg}path")
        if path.get("stroke-width") == "1" and path.get("d").count("L") > 50
    ]
    assert len(curves) == 2
    assert not any("NaN" in curve for curve in curves)
    # Where the page may not write to the clipboard, it is a file.
    page.evaluate("void (navigator.clipboard.write = () => Promise.reject())")
    for kind, head in (("PNG", b"\x89PNG"), ("SVG", b"<svg")):
        page.locator(".u-over").first.hover()
        with page.expect_download() as saved:
            page.get_by_role("button", name=f"Copy as {kind}").first.click()
        assert saved.value.suggested_filename == f"chart.{kind.lower()}"
        assert Path(saved.value.path()).read_bytes().startswith(head)


def test_a_chart_is_dragged_onto_another_one(page):
    drawn(page, OVERVIEW_CHARTS)
    titles = page.locator(".uplot .u-title")
    titles.nth(3).drag_to(page.locator(".u-over").nth(2))
    first, second = OVERVIEW_CHARTS[:2]
    both = "Inertia, zz · Vertical force, all feet [kg m² or N]"
    (*_, chart) = drawn(page, [first, second, both])
    assert chart["curves"] == ["plan Inertia, zz", "plan Vertical force, all feet"]
    # What is on offer, by the button that adds it.
    button = page.get_by_role("button", name="Add chart")
    page.wait_for_function("b => b.draggable", arg=button.element_handle())
    button.drag_to(page.locator(".u-over").first)
    drawn(page, [f"{first[:-4]} · CoM position [° or m]", second, both])
