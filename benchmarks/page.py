"""The page's figures in headless Chromium: `python -m benchmarks.page`, from the checkout.

Times are taken inside the page. Chromium draws in software here, on the processor that also plans,
so nothing else should run beside it. `--drag` and `--play` say for how long, s; `--reach` how far:
with 12 pixels the twist stays where every jump can be planned, with 30 it goes beyond. `--others`
drags the other sliders too, each to and fro between places at random. Last, twists are typed: the
time until their plan is certified, and with drives that may give less, where none can be planned,
the time to the verdict.
"""

import argparse
import itertools
import os
import time
from pathlib import Path

import numpy as np

from benchmarks.served import resident, serving, wait_until_ready
from tests.app.chromium import PACE, VIEW, chromium, number, status

STEP = 0.1  # s between steps of the dragged slider
REACH = 30  # pixels that the hand goes to either side
PERIOD = 10.0  # s, there and back
TAKE_UP = 8_000  # ms for the last plan to settle
LAST_ANSWER = 90_000  # ms at most: where a jump cannot be done less of it is looked for
OTHERS = {"forward": "Forward [m]", "lateral": "Lateral [m]", "height": "Landing height [m]"}
FASTEST = 6  # pixels a step, at random
SEED = 7
RESTING = (20, 65, 110, 35, 80, 125, 50, 95)  # twists in degrees, one after the other
SETTLED = "[role=status][aria-busy=false]"  # the status line of a request's last answer
TYPED = [  # twist in degrees, share of the drives' torque: none can be planned
    (170, 0.45),
    (140, 0.4),
    (-160, 0.5),
]

# Types a number into a field, and notes how long it takes to a line of the status, which a selector
# finds, with a verdict at its beginning; and that line.
VERDICT = """([field, value, lines, verdict]) => new Promise(resolve => {
  const set = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  const began = performance.now();
  field.focus();
  set.call(field, value);
  field.dispatchEvent(new Event("input", { bubbles: true }));
  field.blur();
  let changed = false;
  const look = () => {
    changed ||= document.querySelector('[role=status][aria-busy=true]') !== null;
    const line = document.querySelector(lines)?.innerText ?? '';
    if (changed && RegExp(`^\\s*(${verdict})`).test(line))
      resolve([performance.now() - began, line]);
    else setTimeout(look, 5);
  };
  look();
})"""

# Notes every step of a slider, and every motion when its first picture has been drawn, with the
# page's clock; values in the slider's units.
RECORD = """([thumb, name, unit]) => {
  const record = window.record = {steps: [], drawn: []};
  new MutationObserver(() => {
    const value = Number(thumb.getAttribute('aria-valuenow')), last = record.steps.at(-1);
    if (!last || last[1] !== value) record.steps.push([performance.now(), value]);
  }).observe(thumb, {attributes: true, attributeFilter: ['aria-valuenow']});
  let seen = window.llsrbm.player.seen;
  const loop = () => {
    if (window.llsrbm.player.seen !== seen) {
      seen = window.llsrbm.player.seen;
      record.drawn.push([seen.at, Math.round(100 * seen.request[name] * unit) / 100]);
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
    """Processor time of a process without its children, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def to_and_fro(reach):
    """Pixels from the middle at each step, evenly."""
    return (reach * np.sin(2 * np.pi * step * STEP / PERIOD) for step in itertools.count(1))


def at_random(reach):
    """Pixels from the middle at each step, from one place to the next."""
    rng, at = np.random.default_rng(SEED), 0.0
    while True:
        goal = rng.uniform(-reach, reach)
        while at != goal:
            at += float(np.clip(goal - at, -FASTEST, FASTEST))
            yield at


def drag(page, seconds, places, name="twist", label="Twist [deg]"):
    """Draw a slider along places; its steps and the motions drawn, each as (ms, value)."""
    answered(page)
    row = page.get_by_text(label, exact=True).locator("xpath=ancestor::div[.//input][1]")
    thumb = row.get_by_role("slider")
    unit = 180 / np.pi if name == "twist" else 1.0
    page.evaluate(RECORD, [thumb.element_handle(), name, unit])
    box = thumb.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    began, step = time.monotonic(), 0
    while time.monotonic() - began < seconds:
        step += 1
        page.mouse.move(x + next(places), y)
        left = began + step * STEP - time.monotonic()
        if left > 0:
            page.wait_for_timeout(1000 * left)
    page.mouse.up()
    answered(page)
    page.wait_for_timeout(TAKE_UP / 4)
    record = page.evaluate("() => ({steps: window.record.steps, drawn: window.record.drawn})")
    steps = record["steps"]
    drawn = [entry for entry in record["drawn"] if entry[0] > steps[0][0]]
    return steps, drawn


def answered(page):
    """Wait until the request has its last answer, whatever it is."""
    page.locator(SETTLED).wait_for(timeout=LAST_ANSWER)


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


def report(title, steps, drawn):
    """Print how late and in which order the motions of a drag were drawn."""
    found, order = latencies(steps, drawn)
    stale = sum(b < a for a, b in itertools.pairwise(order))
    late = np.percentile(found, 95)
    print(
        f"{title:31}{np.median(found):6.0f} ms median, {late:.0f} ms p95, "
        f"{found.max():.0f} ms worst of {len(found)}"
    )
    last = drawn[-1][1] == steps[-1][1]
    print(
        f"  motions drawn {len(drawn)}, older after newer {stale}, last is the last value: {last}"
    )


def type_into(page, label, value):
    """Type a number, and wait for its answer."""
    number(page, label).fill(str(value))
    page.wait_for_timeout(PACE)
    answered(page)
    page.wait_for_timeout(TAKE_UP / 4)


def limit_torque(page, share):
    """Have the drives give that share of their torque; None: the robot's own."""
    event = {"kind": "tuning", "group": "limits", "name": "torque_share", "value": share}
    page.evaluate("event => llsrbm.page.send(event)", event)
    page.wait_for_timeout(TAKE_UP / 4)
    answered(page)


def rests(page):
    """Print how long typed twists take until their plans are certified."""
    field = number(page, "Twist [deg]").element_handle()
    taken = []
    for twist in RESTING:
        taken.append(page.evaluate(VERDICT, [field, str(twist), SETTLED, "Feasible"])[0])
        page.wait_for_timeout(TAKE_UP / 4)
    print(
        f"typed to certified             {np.median(taken):6.0f} ms median, {max(taken):.0f} ms "
        f"worst of {len(taken)}"
    )


def verdicts(page):
    """Print how long typed twists that cannot be planned take to their verdicts."""
    taken = []
    for twist, share in TYPED:
        type_into(page, "Twist [deg]", 0)
        limit_torque(page, share)
        field = number(page, "Twist [deg]").element_handle()
        took, line = page.evaluate(
            VERDICT, [field, str(twist), "[role=status]", "Nearest|Infeasible"]
        )
        taken.append(took)
        print(
            f"  {twist}° with {share:.0%} of the torque   {took:6.0f} ms: {line.split(chr(10))[0]}"
        )
        limit_torque(page, None)
    print(f"typed to a verdict               {max(taken):6.0f} ms at worst of {len(taken)}")


def first_pictures(browser, url):
    """Print how long a newly opened page takes to its first picture."""
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


def frame_rate(page, seconds):
    """Frames a second over so long, and how long (s) that was by the page's clock."""
    start = page.evaluate(RENDERED)
    page.wait_for_timeout(1000 * seconds)
    end = page.evaluate(RENDERED)
    took = (end[0] - start[0]) / 1000
    return (end[1] - start[1]) / took, took


def playing(page, pid, seconds):
    """Print frame rate and resolution of a page that plays, and what the server does meanwhile."""
    busy = processor_time(pid)
    rate, took = frame_rate(page, seconds)
    busy = processor_time(pid) - busy
    print(f"playing {took:3.0f} s                    {rate:6.1f} frames/s")
    print(f"  at a resolution of             {page.evaluate('llsrbm.player.resolution'):6.2f}")
    print(f"  server's share of a core       {busy / took:6.1%}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drag", type=float, default=10.0)
    parser.add_argument("--play", type=float, default=60.0)
    parser.add_argument("--reach", type=float, default=REACH, help="pixels, to either side")
    parser.add_argument("--others", action="store_true", help="drag the other sliders, too")
    options = parser.parse_args()
    began = time.monotonic()
    with serving() as (server, url):
        print(f"start to a page that answers     {time.monotonic() - began:6.2f} s")
        wait_until_ready(server)
        print(f"start to everything ready        {time.monotonic() - began:6.2f} s")
        with chromium() as browser:
            first_pictures(browser, url)
            page = browser.new_context(viewport=VIEW).new_page()
            page.goto(url)
            page.evaluate(FIRST_PICTURE)
            page.wait_for_timeout(3000)
            playing(page, server.pid, options.play)
            for mode in ("playing", "paused"):
                if mode == "paused":
                    page.get_by_role("button", name="Pause").click()
                    page.wait_for_timeout(PACE)
                moved = drag(page, options.drag, to_and_fro(options.reach))
                report(f"dragging while {mode}", *moved)
            for name, label in OTHERS.items() if options.others else ():
                moved = drag(page, options.drag, at_random(options.reach), name, label)
                report(f"dragging {label}", *moved)
                type_into(page, label, 0)
            rests(page)
            type_into(page, "Twist [deg]", 90)
            page.get_by_role("button", name="Simulate").click()
            status(page, "Landed", timeout=60_000)
            page.get_by_role("button", name="Play").click()
            page.wait_for_timeout(3000)
            rate, _ = frame_rate(page, 8.0)
            print(f"playing with a simulation        {rate:6.1f} frames/s")
            verdicts(page)
        print(f"memory, server and processes     {sum(resident(server.pid)):6.0f} MB")


if __name__ == "__main__":
    main()
