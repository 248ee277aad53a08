"""Stick figures in a real browser: those that are to be seen move, unless less motion is wanted."""

import re
from pathlib import Path

import numpy as np

from llsrbm.library import stick_figure
from llsrbm.library.stick_figure import Role
from tests.llsrbm.library.shipped_motions import card, library

NAMES = ("go2-back-flip-0001", "go2-hops-0001")
SCRIPT = Path(stick_figure.__file__).with_suffix(".js")
ADD = """(figures) => document.body.append(...figures.map((figure, k) => {
  const svg = window.llsrbm.stickFigure(figure);
  const place = `width: 200px; height: 84px; margin-top: ${3000 * k}px`;
  svg.setAttribute("style", `display: block; ${place}`);
  return svg;
}))"""
# How often the trunk of each figure is drawn within half a second.
DRAWN = """async () => {
  const svgs = [...document.querySelectorAll("svg")], counts = svgs.map(() => 0);
  const observer = new MutationObserver((records) => {
    for (const { target } of records)
      if (!target.nextSibling) counts[svgs.indexOf(target.parentElement)] += 1;
  });
  observer.observe(document.body, { subtree: true, attributes: true, attributeFilter: ["d"] });
  await new Promise((done) => setTimeout(done, 500));
  observer.disconnect();
  return counts;
}"""


def page_with(browser, **options):
    """Two figures, the second of which is far below."""
    figures = library().stick_figures()
    page = browser.new_context(viewport={"width": 400, "height": 300}, **options).new_page()
    page.set_content("<body></body>")
    page.add_script_tag(content=SCRIPT.read_text("utf-8"))
    page.evaluate(ADD, [figures[name].drawn(card(name).figures.duration_s) for name in NAMES])
    page.wait_for_function("document.querySelector('svg path')")
    return page


def test_those_in_sight_move(browser):
    page = page_with(browser)
    first, second = page.evaluate(DRAWN)
    assert first > 2
    assert second == 0
    page.evaluate("scrollTo(0, document.body.scrollHeight)")
    page.wait_for_function("document.querySelectorAll('svg')[1].firstChild")
    first, second = page.evaluate(DRAWN)
    assert first == 0
    assert second > 2
    page.evaluate("document.body.hidden = true")
    page.evaluate(DRAWN)
    assert page.evaluate(DRAWN) == [0, 0]
    page.context.close()


def test_for_less_motion_the_top_of_the_flight_is_shown(browser):
    page = page_with(browser, reduced_motion="reduce")
    assert page.evaluate(DRAWN) == [0, 0]
    outline = page.evaluate("document.querySelector('svg path:last-child').getAttribute('d')")
    found = np.array(re.findall(r"-?[\d.]+", outline), dtype=float).reshape(-1, 2)
    figure = library().stick_figures()[NAMES[0]]
    trunk = figure.points[:, figure.roles == Role.TRUNK].astype(float)
    top = trunk[trunk[..., 1].mean(axis=1).argmax()]
    # The outline's corners are some of the trunk's, downwards as pictures have it.
    apart = np.abs(found[:, None] - top * [1, -1]).max(axis=-1).min(axis=1)
    assert len(found) >= 4
    assert apart.max() < 0.1
    page.context.close()
