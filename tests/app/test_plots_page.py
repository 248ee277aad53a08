"""The plots in a real browser."""

from __future__ import annotations

import pytest

from app.curves import GROUPS, LANDING
from tests.app.chromium import PACE, VIEW, chromium, status

pytestmark = pytest.mark.browser

CHARTS = """() => Object.values(window.__viserTestpoints.uplots).map(({chart, createCount}) => ({
  title: chart.root.querySelector('.u-title').innerText,
  start: chart.scales.x.min,
  end: chart.scales.x.max,
  ticks: chart.axes.map(axis => (axis._values || []).length),
  curves: chart.series.flatMap((series, i) => series.scale === 'y'
    && chart.data[i].some(v => !Number.isNaN(v)) ? [series.label] : []),
  aligned: chart.series.length === chart.data.length,
  width: chart.over.clientWidth,
  created: createCount,
}))"""


@pytest.fixture(scope="module")
def browser():
    with chromium() as started:
        yield started


@pytest.fixture
def page(browser, designer):
    context = browser.new_context(viewport=VIEW)
    page = context.new_page()
    faults = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.goto(designer.url)
    status(page, "Planned")
    yield page
    assert faults == []
    context.close()


def choose(page, label, value):
    page.get_by_label(label).click()
    page.get_by_role("option", name=value, exact=True).click()
    page.wait_for_timeout(PACE)


def drawn(page, titles, timeout=10.0):
    """The charts, once they have these titles."""
    page.wait_for_function(
        "titles => JSON.stringify(Object.values(window.__viserTestpoints.uplots).map(({chart}) =>"
        " chart.root.querySelector('.u-title').innerText)) === JSON.stringify(titles)",
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


OVERVIEW = [
    "Base yaw [°]",
    "Base yaw rate [rad/s]",
    "CoM height [m]",
    "Vertical force, all feet [N]",
]


def test_every_group_is_drawn_with_plan_and_simulation(page):
    charts = drawn(page, OVERVIEW)
    assert [chart["curves"] for chart in charts] == [["plan"]] * 4
    assert {chart["end"] for chart in charts} == {1.5}
    page.get_by_role("button", name="Simulate").click()
    status(page, "Landed")
    charts = drawn(page, OVERVIEW)
    assert [chart["curves"] for chart in charts] == [["plan", "simulation"]] * 4
    assert {chart["end"] for chart in charts} == {2.5}
    for group in GROUPS:
        if group == "Overview":
            continue
        choose(page, "Quantity", group)
        page.wait_for_timeout(300)
        titles = [chart["title"] for chart in page.evaluate(CHARTS)]
        assert not set(titles) & set(OVERVIEW) or group == "Contact forces"
        charts = drawn(page, titles)
        assert 3 <= len(charts) <= 5, titles
        for chart in charts:
            assert "simulation" in chart["curves"], chart
            span = chart["end"] - chart["start"]
            assert 0.3 < span < 0.5 if group == LANDING else span == 2.5, chart
