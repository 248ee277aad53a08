"""The exported page, read as a browser reads it, and played from disk in one."""

import base64
import json
import math
import re
import shutil
import socket
import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from llsrbm.errors import InputError
from llsrbm.formats import export
from llsrbm.robots import load_robot
from tests.llsrbm.formats.pictures.shown import motion_of, without_meshes

HOSTILE = "<script>document.title='taken'<!--"


def facts(path):
    text = path.read_text(encoding="utf-8")
    (found,) = re.findall(r'id="facts">(.*?)</script>', text, re.DOTALL)
    return json.loads(found)


@pytest.fixture(scope="module")
def motion():
    """A plan and a rollout of a robot that is quickly drawn."""
    return motion_of("slider")


@pytest.fixture(scope="module")
def replay(motion, tmp_path_factory):
    path = tmp_path_factory.mktemp("html") / "rollout.html"
    export(motion.rollout, path, format="html")
    return path


def test_it_is_one_small_file_that_asks_for_nothing(replay):
    text = replay.read_text(encoding="utf-8")
    assert replay.stat().st_size < 2.5e6
    assert [file.name for file in replay.parent.iterdir()] == [replay.name]
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', text)
    assert policy.startswith("default-src 'none'")
    assert "http" not in policy
    assert text.index("Content-Security-Policy") < text.index("<script")


def test_no_server_is_left(motion, tmp_path):
    """viser's scene comes from a server of its own, on this machine alone."""
    before = {thread.name for thread in threading.enumerate()}
    opened = []
    bind = socket.socket.bind

    def noted(self, address):
        opened.append(address)
        return bind(self, address)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(socket.socket, "bind", noted)
        export(motion.plan, tmp_path / "x.html", format="html", fps=10)
    assert {address[0] for address in opened} <= {"127.0.0.1"}
    deadline = time.monotonic() + 10
    while {t.name for t in threading.enumerate()} - before and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not {t.name for t in threading.enumerate() if not t.daemon} - before


def test_what_it_holds(motion, replay, tmp_path):
    found = facts(replay)
    marks = {mark["name"]: mark["time"] for mark in found["timeline"]["marks"]}
    assert marks["lift-off"] == pytest.approx(motion.plan.phase_start[1])
    assert marks["first contact"] == motion.rollout.outcome.touchdown_true_s
    assert found["description"]["request"] == motion.plan.jump.as_dict()
    titles = {layer["title"] for layer in found["layers"]}
    assert titles >= {"Ghost", "Inertia ellipsoids", "Forces", "Trails", "Centre of mass"}
    numbers = np.frombuffer(base64.b64decode(found["numbers"]), "<f4")
    assert np.isfinite(numbers).all()
    export(motion.plan, tmp_path / "x.html", format="html", fps=20)
    alone = facts(tmp_path / "x.html")
    assert "Ghost" not in {layer["title"] for layer in alone["layers"]}
    assert alone["clip"]["channels"][0]["frames"] < found["clip"]["channels"][0]["frames"]


@pytest.mark.parametrize("options", [{"fps": 0.0}, {"camera": (0, 95, 1)}])
def test_options_that_make_no_sense(motion, tmp_path, options):
    with pytest.raises(InputError):
        export(motion.plan, tmp_path / "x.html", format="html", **options)
    assert not list(tmp_path.iterdir())


@pytest.fixture(scope="module")
def hostile(tmp_path_factory):
    """A plan whose words come from somebody who means harm."""
    folder = tmp_path_factory.mktemp("hostile")
    robot = load_robot("slider")
    path = folder / f"{HOSTILE}.toml"
    shutil.copytree(robot.urdf_path.parent, folder / robot.urdf_path.parent.name)
    text = robot.path.read_text(encoding="utf-8")
    path.write_text(text.replace('"../slider/', '"slider/'), encoding="utf-8")
    plan = motion_of("slider").plan
    jump = replace(plan.jump, robot=str(path), model="</script><img src=x onerror=alert(1)>")
    path = folder / "x.html"
    export(replace(plan, jump=jump), path, format="html", fps=10, camera=(90.0, 20.0, 3.0))
    return folder / "x.html"


def test_words_from_files_are_no_markup(hostile):
    text = hostile.read_text(encoding="utf-8")
    assert "<img" not in text
    assert HOSTILE not in text
    assert facts(hostile)["title"].startswith(HOSTILE)


def test_a_robot_without_meshes_is_drawn_by_what_collides(tmp_path):
    export(without_meshes(tmp_path), tmp_path / "x.html", format="html", fps=10)
    channels = facts(tmp_path / "x.html")["clip"]["channels"]
    nodes = [node for c in channels for track in c["tracks"] for node in track["nodes"]]
    assert sum(node.startswith("/links/") for node in nodes) == 3  # pelvis and feet


needs_chromium = pytest.mark.skipif(shutil.which("chromium") is None, reason="no Chromium")


def played(browser, path):
    """The page, opened from disk; `faults` has errors, its console's too, and requests."""
    from tests.app.chromium import opened

    page = opened(browser, path.as_uri(), {"width": 640, "height": 420})
    page.on("console", lambda said: page.faults.append(said.text) if said.type == "error" else None)
    page.wait_for_function("window.llsrbm.player.clip")
    return page


@pytest.fixture(scope="module")
def tab(browser, replay):
    """A page left open would go on drawing beside later tests."""
    page = played(browser, replay)
    yield page
    page.context.close()


@needs_chromium
class TestInABrowser:
    def test_it_plays_by_itself_until_a_key_is_pressed(self, tab):
        first = tab.evaluate("llsrbm.player.time")
        tab.wait_for_function("t => Math.abs(llsrbm.player.time - t) > 0.05", arg=first)
        tab.keyboard.press("Space")
        assert not tab.evaluate("llsrbm.player.playing")
        tab.keyboard.press("End")
        assert tab.evaluate("llsrbm.player.time") == tab.evaluate("llsrbm.player.clip.end")

    def test_the_robot_is_where_the_simulator_had_it(self, tab, motion):
        rollout, base = motion.rollout, tab.evaluate("llsrbm.camera.target.follow")
        tab.evaluate("llsrbm.player.pause()")
        for tick in np.linspace(0, len(rollout.time) - 1, 5).astype(int):
            tab.evaluate("t => llsrbm.player.seek(t)", float(rollout.time[tick]))
            tab.wait_for_function(
                """([name, x]) => Math.hypot(...window.__viserMutable.nodeRefFromName[name].position
                  .toArray().map((value, i) => value - x[i])) < 1e-3""",
                arg=[base, rollout.qpos[tick, :3].tolist()],
            )
            quat = tab.evaluate(
                """name => { const q = window.__viserMutable.nodeRefFromName[name].quaternion;
                  return [q.w, q.x, q.y, q.z]; }""",
                base,
            )
            assert abs(np.dot(quat, rollout.qpos[tick, 3:7])) == pytest.approx(1, abs=1e-3)

    def test_the_timeline(self, tab):
        assert tab.locator("#llsrbm-transport").get_by_text("flight").count() > 0
        track = tab.get_by_role("group", name="Timeline")
        box = track.bounding_box()
        tab.mouse.click(box["x"] + 0.25 * box["width"], box["y"] + box["height"] / 2)
        end = tab.evaluate("llsrbm.player.clip.end")
        assert tab.evaluate("llsrbm.player.time") == pytest.approx(0.25 * end, abs=0.02 * end)

    def test_layers(self, tab, replay):
        for layer in facts(replay)["layers"]:
            visible = f"window.__viserMutable.nodeRefFromName['{layer['node']}'].visible === {{}}"
            box = tab.get_by_role("checkbox", name=layer["title"])
            box.uncheck()
            tab.wait_for_function(visible.format("false"))
            box.check()
            tab.wait_for_function(visible.format("true"))

    def test_nothing_went_wrong(self, tab):
        assert tab.faults == []


@needs_chromium
def test_it_is_looked_at_from_where_was_asked_for_and_words_from_files_do_nothing(browser, hostile):
    tab = played(browser, hostile)
    tab.wait_for_function("window.__viserMutable.cameraControl.getPosition().length() > 2")
    x, y, z = tab.evaluate(
        """() => { const { cameraControl: c } = window.__viserMutable;
          const place = c.getPosition(), at = c.getTarget();
          return [place.x - at.x, place.z - at.z, place.y - at.y]; }"""
    )
    assert math.hypot(x, y, z) == pytest.approx(3.0, rel=1e-3)
    assert math.degrees(math.asin(z / 3)) == pytest.approx(20.0, abs=0.1)
    assert tab.title().startswith(HOSTILE)
    assert tab.locator("#llsrbm-replay h1").inner_text().startswith(HOSTILE)
    assert tab.locator("#llsrbm-replay img").count() == 0
    assert tab.faults == []
    tab.context.close()
