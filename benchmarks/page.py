"""The page's figures in headless Chromium: `python -m benchmarks.page`, from the checkout.

Prints time from start to a page that answers, time to a visible robot, bytes on the wire, time from
a slider's new value to its plan on the screen, frame rate, and memory of server and process.
"""

from __future__ import annotations

import re
import statistics
import subprocess
import sys
import time

from tests.app.chromium import VIEW, chromium, dark, fill, number, picture, status

PROGRAM = [sys.executable, "-m", "llsrbm.cli", "serve", "--port", "0"]
VALUES = (60, -120, 30, 150, -45, 90, -150, 10)

# Resolves, in ms since the field's input event, when the status has come back to "Planned" and the
# browser has drawn a frame.
WAIT_FOR_PLAN = """() => new Promise(resolve => {
  let begin = performance.now();
  const note = () => { begin = performance.now(); };
  document.addEventListener('input', note, {capture: true, once: true});
  let left = false;
  const watch = new MutationObserver(() => {
    const text = document.querySelector('[role=status]').innerText;
    if (!text.startsWith('Planned')) left = true;
    else if (left || text !== window.before) {
      watch.disconnect();
      requestAnimationFrame(() => resolve(performance.now() - begin));
    }
  });
  window.before = document.querySelector('[role=status]').innerText;
  watch.observe(document.body, {subtree: true, childList: true, characterData: true});
})"""
FRAME_RATE = """() => new Promise(resolve => {
  const begin = performance.now();
  let frames = 0;
  const count = now => {
    frames += 1;
    if (now - begin > 4000) resolve(1000 * frames / (now - begin));
    else requestAnimationFrame(count);
  };
  requestAnimationFrame(count);
})"""


def resident(pid):
    """Memory of a process and its children, MB."""
    listed = subprocess.run(
        ["ps", "-o", "rss=", "--ppid", str(pid), "-p", str(pid)],
        capture_output=True,
        text=True,
        check=True,
    )
    return sum(int(line) for line in listed.stdout.split()) / 1024


def visible_after(page, began):
    while dark(picture(page)).sum() < 3000:
        if time.monotonic() - began > 60:
            return float("nan")
    return time.monotonic() - began


def main():
    began = time.monotonic()
    server = subprocess.Popen(PROGRAM, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        url = re.search(r"http://\S+", server.stdout.readline()).group()
        print(f"start to a page that answers    {time.monotonic() - began:6.2f} s")
        while server.stderr.readline() != "ready\n":
            pass
        print(f"start to all solvers ready      {time.monotonic() - began:6.2f} s")
        with chromium() as browser:
            browser.new_page(viewport=VIEW).close()
            for attempt in ("first", "second"):
                context = browser.new_context(viewport=VIEW)
                page = context.new_page()
                sizes = []
                page.on(
                    "websocket",
                    lambda socket, sizes=sizes: socket.on(
                        "framereceived", lambda frame: sizes.append(len(frame))
                    ),
                )
                opened = time.monotonic()
                page.goto(url)
                seconds = visible_after(page, opened)
                print(f"{attempt + ' tab: robot visible after':30s}  {seconds:6.2f} s")
                status(page, "Planned")
                if attempt == "first":
                    print(f"largest message (meshes)        {max(sizes) / 1e6:6.2f} MB")
                    context.close()
            page.wait_for_timeout(2000)
            print(f"playing                         {page.evaluate(FRAME_RATE):6.1f} frames/s")
            number(page, "Twist [deg]").wait_for()
            times = []
            for value in VALUES:
                page.evaluate(f"window.planned = ({WAIT_FOR_PLAN})(); 0")
                fill(page, "Twist [deg]", value)
                times.append(page.evaluate("window.planned"))
                page.wait_for_timeout(300)
            print(f"new value to plan on screen     {statistics.median(times):6.0f} ms median")
            print(f"                                {max(times):6.0f} ms worst of {len(times)}")
        print(f"memory, server and process      {resident(server.pid):6.0f} MB")
    finally:
        server.terminate()
        server.communicate()


if __name__ == "__main__":
    main()
