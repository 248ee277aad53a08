"""The page's figures in headless Chromium: `python -m benchmarks.page`, from the checkout.

Times are taken inside the page. Chromium draws in software here, on the processor that also plans,
so nothing else should run beside it. `--drag` and `--play` say for how long, s; `--reach` how far:
with 12 pixels the twist stays where every jump can be planned, with 30 it goes beyond.
"""

from __future__ import annotations

import argparse
import itertools
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from tests.app.chromium import PACE, VIEW, chromium, status

PROGRAM = [sys.executable, "-m", "llsrbm.cli", "serve", "--port", "0"]
STEP = 0.1  # s between steps of the dragged slider
REACH = 30  # pixels that the hand goes to either side
PERIOD = 10.0  # s, there and back
TAKE_UP = 8_000  # ms for the last plan to settle

# Notes every step of the twist's slider, and every motion when its first picture has been drawn,
# with the page's clock.
RECORD = """() => {
  const thumb = document.querySelector('[role=slider]');
  const record = window.record = {steps: [], drawn: []};
  new MutationObserver(() => {
    const value = Number(thumb.getAttribute('aria-valuenow')), last = record.steps.at(-1);
    if (!last || last[1] !== value) record.steps.push([performance.now(), value]);
  }).observe(thumb, {attributes: true, attributeFilter: ['aria-valuenow']});
  let seen = window.llsrbm.player.seen;
  const loop = () => {
    if (window.llsrbm.player.seen !== seen) {
      seen = window.llsrbm.player.seen;
      record.drawn.push([seen.at, Math.round(seen.request.twist * 180 / Math.PI)]);
    }
    requestAnimationFrame(loop);
  };
  requestAnimationFrame(loop);
}"""
FIRST_PICTURE = """() => new Promise(resolve => {
  const look = () => {
    const player = window.llsrbm?.player;
    if (player?.playing && player.seen) resolve(player.seen.at / 1000);
    else requestAnimationFrame(look);
  };
  look();
})"""
RENDERED = "() => [performance.now(), window.__viserTestpoints.rendererInfo.render.frame]"


def processor_time(pid):
    """Of a process without its children, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def resident(pid):
    """Memory of a process and its children, MB."""
    listed = subprocess.run(
        ["ps", "-o", "rss=", "--ppid", str(pid), "-p", str(pid)],
        capture_output=True,
        text=True,
        check=True,
    )
    return sum(int(line) for line in listed.stdout.split()) / 1024


def drag(page, seconds, reach=REACH):
    """Draw the twist's slider to and fro; (latencies ms, steps, drawn values, settled)."""
    status(page, "Planned")
    page.evaluate(RECORD)
    thumb = page.get_by_role("slider").first
    box = thumb.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    began, step = time.monotonic(), 0
    while time.monotonic() - began < seconds:
        step += 1
        page.mouse.move(x + reach * np.sin(2 * np.pi * step * STEP / PERIOD), y)
        left = began + step * STEP - time.monotonic()
        if left > 0:
            page.wait_for_timeout(1000 * left)
    page.mouse.up()
    status(page, "Planned")
    page.wait_for_timeout(TAKE_UP / 4)
    record = page.evaluate("() => ({steps: window.record.steps, drawn: window.record.drawn})")
    steps = record["steps"]
    drawn = [entry for entry in record["drawn"] if entry[0] > steps[0][0]]
    return steps, drawn


def latencies(steps, drawn):
    """ms from each step to the first picture of it or of a later one; inf for none.

    A picture belongs to the newest step of its value before it.
    """
    times = np.array([at for at, _ in steps])
    values = np.array([value for _, value in steps])
    shown = []  # (time, index of the step)
    for at, value in drawn:
        steps_before = np.flatnonzero((times <= at) & (values == value))
        if len(steps_before):
            shown.append((at, int(steps_before[-1])))
    found = []
    for index, at in enumerate(times):
        later = [seen for seen, which in shown if which >= index and seen >= at]
        found.append(min(later) - at if later else np.inf)
    order = [which for _, which in shown]
    return np.array(found), order


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drag", type=float, default=10.0)
    parser.add_argument("--play", type=float, default=60.0)
    parser.add_argument("--reach", type=float, default=REACH, help="pixels, to either side")
    options = parser.parse_args()
    began = time.monotonic()
    server = subprocess.Popen(PROGRAM, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        url = re.search(r"http://\S+", server.stdout.readline()).group()
        print(f"start to a page that answers     {time.monotonic() - began:6.2f} s")
        while server.stderr.readline() != "ready\n":
            pass
        print(f"start to everything ready        {time.monotonic() - began:6.2f} s")
        with chromium() as browser:
            firsts = []
            for _ in range(4):
                context = browser.new_context(viewport=VIEW)
                page = context.new_page()
                page.goto(url)
                firsts.append(page.evaluate(FIRST_PICTURE))
                page.wait_for_timeout(1000)
                context.close()
            listed = ", ".join(f"{first:.2f}" for first in firsts)
            print(f"first picture of a playing robot  {listed} s after opening")
            page = browser.new_context(viewport=VIEW).new_page()
            page.goto(url)
            page.evaluate(FIRST_PICTURE)
            page.wait_for_timeout(3000)

            busy = processor_time(server.pid)
            start = page.evaluate(RENDERED)
            page.wait_for_timeout(1000 * options.play)
            end = page.evaluate(RENDERED)
            busy = processor_time(server.pid) - busy
            seconds = (end[0] - start[0]) / 1000
            rate = (end[1] - start[1]) / seconds
            print(f"playing {seconds:3.0f} s                    {rate:6.1f} frames/s")
            print(
                f"  at a resolution of             {page.evaluate('llsrbm.player.resolution'):6.2f}"
            )
            print(f"  server's share of a core       {busy / seconds:6.1%}")

            for mode in ("playing", "paused"):
                if mode == "paused":
                    page.get_by_role("button", name="Pause").click()
                    page.wait_for_timeout(PACE)
                steps, drawn = drag(page, options.drag, options.reach)
                found, order = latencies(steps, drawn)
                stale = sum(b < a for a, b in itertools.pairwise(order))
                last = drawn[-1][1] == steps[-1][1]
                late = np.percentile(found, 95)
                print(
                    f"dragging while {mode:7s}           {np.median(found):6.0f} ms median, "
                    f"{late:.0f} ms p95, {found.max():.0f} ms worst of {len(found)}"
                )
                print(
                    f"  motions drawn {len(drawn)}, older after newer {stale}, "
                    f"last is the last value: {last}"
                )
            page.get_by_role("button", name="Simulate").click()
            status(page, "Landed", timeout=60_000)
            page.get_by_role("button", name="Play").click()
            page.wait_for_timeout(3000)
            start = page.evaluate(RENDERED)
            page.wait_for_timeout(8000)
            end = page.evaluate(RENDERED)
            rate = 1000 * (end[1] - start[1]) / (end[0] - start[0])
            print(f"playing with a simulation        {rate:6.1f} frames/s")
        print(f"memory, server and processes     {resident(server.pid):6.0f} MB")
    finally:
        server.terminate()
        server.communicate()


if __name__ == "__main__":
    main()
