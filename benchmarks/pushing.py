"""Pushing the robot in headless Chromium: `python -m benchmarks.pushing`, from the checkout.

With replanning on, the motion is stopped in flight, the arrow on the trunk dragged and let go of,
again and again. Printed are the time from the end of the drag to the first picture of the robot
that follows a new plan (a simulation lies between), and memory before and after. Chromium draws in
software here, on the processor that also simulates, so nothing else should run beside it.
`--seconds` says for how long, `--robot` of which one.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import time

import numpy as np

from benchmarks.page import FIRST_PICTURE, PROGRAM, resident
from tests.app.chromium import PACE, PIXELS, VIEW, choose, chromium, status, unfold
from tests.app.waits import wait_until

WARM_UP = 3  # pushes that count for nothing: the first one loads solvers
EARLIEST = 0.04  # s after a push: it is measured, and the answer is followed 20 ms later
SHARE = (0.1, 0.5)  # of the flight, in which pushes begin
LENGTH = (0.15, 0.45)  # m that the tip is dragged
STEPS = 6  # of a hand

# The next time that the hand lets go: ms from then until a robot is drawn that follows a new plan.
WATCH = """instant => {
  const { player } = window.llsrbm, before = player.clip;
  const rendered = () => window.__viserTestpoints.rendererInfo.render.frame;
  window.drawnAfter = null;
  window.addEventListener("pointerup", () => {
    const began = performance.now();
    let there = null;
    const look = () => {
      const clip = player.clip;
      const solid = clip?.strands.find(({ tracks }) =>
        tracks.some(({ nodes }) => nodes.includes("/links/base")));
      const follows = clip !== before && solid?.time.at(-1) >= instant && player.time >= instant;
      if (follows && there === null) there = rendered();
      if (there !== null && rendered() > there) window.drawnAfter = performance.now() - began;
      else requestAnimationFrame(look);
    };
    look();
  }, { once: true, capture: true });
}"""
FLIGHT = """() => {
  const piece = [...document.querySelectorAll("#llsrbm-transport .row")][0]
    .querySelector('[title*="flight"]');
  return [parseFloat(piece.style.left), parseFloat(piece.style.width)].map(
    (share) => share / 100 * window.llsrbm.player.clip.end);
}"""


def heap(devtools):
    """MB that the page's scripts hold, without what nobody needs any more."""
    devtools.send("HeapProfiler.collectGarbage")
    return devtools.send("Runtime.getHeapUsage")["usedSize"] / 2**20


def push(page, rng):
    """Drag an arrow of a random length along x or y; (ms until drawn, the status line)."""
    start, length = page.evaluate(FLIGHT)
    instant = start + length * rng.uniform(*SHARE)
    axis = rng.integers(2)
    drag(page, instant, axis, rng.choice((-1, 1)) * rng.uniform(*LENGTH))
    page.evaluate(WATCH, instant + EARLIEST)
    page.mouse.up()
    page.wait_for_function("window.drawnAfter !== null", timeout=30_000)
    line = page.get_by_role("status")
    wait_until(lambda: line.inner_text().startswith(("Landed", "Fell")), "the end", 60)
    return page.evaluate("window.drawnAfter"), line.inner_text()


def drag(page, instant, axis, way):
    """Stop at an instant, s, and drag the arrow's tip by `way`, m, along x or y: 0 or 1."""
    page.evaluate("t => { llsrbm.player.pause(); llsrbm.player.seek(t); }", instant)
    page.wait_for_function(
        "window.__viserMutable.nodePoseData['/push/tip'] !== undefined"
        " && window.__viserMutable.nodeRefFromName['/push/tip'] !== undefined"
    )
    page.wait_for_timeout(500)  # the tip has come to where the robot is
    points = np.zeros((2, 3))
    points[1, axis] = way
    grab, there = np.array(page.evaluate(PIXELS, ["/push/tip", *points.tolist()]))
    page.mouse.move(*grab)
    page.wait_for_timeout(PACE)
    page.mouse.down()
    for share in np.linspace(0, 1, STEPS):
        page.mouse.move(*(grab + share * (there - grab)))
        page.wait_for_timeout(PACE)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--robot", default="ANYmal B", help="as the page calls it")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    server = subprocess.Popen(PROGRAM, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        url = re.search(r"http://\S+", server.stdout.readline()).group()
        while server.stderr.readline() != "ready\n":
            pass
        with chromium() as browser:
            page = browser.new_context(viewport=VIEW).new_page()
            devtools = page.context.new_cdp_session(page)
            page.goto(url)
            page.evaluate(FIRST_PICTURE)
            choose(page, "Robot", options.robot)
            status(page, "Feasible", timeout=120_000)
            unfold(page, "Scenario")
            for label in ("Replan", "Push"):
                page.get_by_label(label, exact=True).check()
                page.wait_for_timeout(PACE)
            for _ in range(WARM_UP):
                push(page, rng)
            server_before, heap_before = resident(server.pid), heap(devtools)
            began, found, landed = time.monotonic(), [], 0
            while time.monotonic() - began < options.seconds:
                latency, line = push(page, rng)
                found.append(latency)
                landed += line.startswith("Landed")
            server_after, heap_after = resident(server.pid), heap(devtools)
        print(
            f"pushes in {time.monotonic() - began:.0f} s          {len(found):6d}, {landed} landed"
        )
        print(
            f"end of the drag to a new plan's motion  {np.median(found):6.0f} ms median, "
            f"{np.percentile(found, 95):.0f} ms p95, {max(found):.0f} ms worst"
        )
        print(
            f"memory, server and processes     {server_before:6.0f} MB, then {server_after:.0f} MB"
        )
        print(f"memory, the page's script        {heap_before:6.1f} MB, then {heap_after:.1f} MB")
    finally:
        server.terminate()
        server.communicate()


if __name__ == "__main__":
    main()
