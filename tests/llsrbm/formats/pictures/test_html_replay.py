"""The replay page, unpacked as a browser would, and played in one."""

import base64
import gzip
import json
import re
import shutil
import socket
import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.formats import export
from llsrbm.motion.sampling import resample
from llsrbm.motion.whole_body import whole_body_motion
from llsrbm.robots import load_robot
from tests.llsrbm.formats.pictures.shown import motion_of
from tests.llsrbm.kinematics import link_poses

HOSTILE = "<script>document.title='taken'<!--"


class Page:
    """The page's facts and arrays."""

    def __init__(self, path):
        self.text = path.read_text(encoding="utf-8")
        self.facts = json.loads(self.element("facts"))
        stored = gzip.decompress(base64.b64decode(self.element("numbers")))
        numbers = np.frombuffer(stored, "<f4")
        self.arrays = {
            name: numbers[each["start"] // 4 : each["start"] // 4 + each["length"]]
            for name, each in self.facts["arrays"].items()
        }

    def element(self, name):
        (text,) = re.findall(f'id="{name}">(.*?)</script>', self.text, re.DOTALL)
        return text


@pytest.fixture(scope="module", params=["anymal", "slider"])
def motion(request):
    """A plan and a rollout of a robot that turns half around."""
    return motion_of(request.param)


@pytest.fixture(scope="module")
def replay(motion, tmp_path_factory):
    path = tmp_path_factory.mktemp("html") / "rollout.html"
    export(motion.rollout, path, format="html")
    return path


@pytest.fixture(scope="module")
def page(replay):
    return Page(replay)


def poses(page, name):
    """(K, bodies, 7)."""
    return page.arrays[name].reshape(len(page.arrays["time"]), -1, 7)


def test_it_is_small_and_asks_for_nothing(replay, page):
    assert replay.stat().st_size < 2.5e6
    assert [file.name for file in replay.parent.iterdir()] == [replay.name]
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', page.text)
    assert policy.startswith("default-src 'none'")
    assert "http" not in policy


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


def test_bodies_are_where_the_motion_has_them(motion, page):
    """By Pinocchio's own kinematics, through half a turn."""
    sampled = whole_body_motion(motion.rollout, 120.0, events=True)
    np.testing.assert_allclose(page.arrays["time"], sampled.time, atol=1e-6)
    stored = poses(page, "solid")
    robot = sampled.robot
    for k in range(0, len(sampled.time), 7):
        for i, body in enumerate(page.facts["bodies"]):
            place, R = link_poses(robot, sampled.qpos[k])[body]
            np.testing.assert_allclose(stored[k, i, :3], place, atol=1e-5)
            turn = Rotation.from_quat(stored[k, i, 3:], scalar_first=True).as_matrix()
            np.testing.assert_allclose(turn, R, atol=1e-5)
    np.testing.assert_allclose(page.arrays["com"].reshape(-1, 3), sampled.com, atol=1e-5)


def test_attitudes_can_be_mixed(page):
    """No quaternion is on the other side of the one before it."""
    for name in ("solid", "ghost"):
        quat = poses(page, name)[..., 3:]
        assert (np.sum(quat[1:] * quat[:-1], axis=-1) > 0.5).all()


def test_the_ghost_is_the_plan(motion, page):
    sampled = resample(motion.plan, page.arrays["time"].astype(float))
    np.testing.assert_allclose(poses(page, "ghost")[:, 0, :3], sampled.base_position, atol=1e-5)


def test_a_plan_has_no_ghost(motion, tmp_path):
    export(motion.plan, tmp_path / "x.html", format="html")
    alone = Page(tmp_path / "x.html")
    assert "ghost" not in alone.arrays
    assert "solid" in alone.arrays


def test_forces_carry_the_robot_at_the_end(motion, page):
    robot = load_robot(motion.rollout.jump.robot)
    force = page.arrays["force"].reshape(len(page.arrays["time"]), -1, 6)[..., 3:]
    weight = robot.mass * 9.81
    standing = force[page.arrays["time"] > page.arrays["time"][-1] - 0.2].mean(axis=0).sum(axis=0)
    np.testing.assert_allclose(standing, [0, 0, weight], atol=0.03 * weight)
    # Means of all ticks: nothing between two frames is lost.
    dt = np.diff(page.arrays["time"].astype(float))
    pushed = (force[:-1].sum(axis=1) * dt[:, None]).sum(axis=0)
    momentum = motion.rollout.linear_momentum[-1] - motion.rollout.linear_momentum[0]
    expected = momentum + np.array([0, 0, weight * motion.rollout.duration])
    np.testing.assert_allclose(pushed, expected, atol=2e-3 * weight)


def test_the_ellipsoid_has_the_inertia(motion, page):
    robot = load_robot(motion.rollout.jump.robot)
    sampled = whole_body_motion(motion.rollout, 120.0, events=True)
    rows = page.arrays["ellipsoid"].reshape(-1, 7).astype(float)
    a, b, c = rows[:, :3].T
    moments = robot.mass / 5 * np.stack([b**2 + c**2, a**2 + c**2, a**2 + b**2], axis=1)
    R = Rotation.from_quat(rows[:, 3:], scalar_first=True).as_matrix()
    inertia = np.einsum("kij,kj,klj->kil", R, moments, R)
    np.testing.assert_allclose(inertia, sampled.inertia, atol=1e-4 * sampled.inertia.max())


def test_phases_and_events(motion, page):
    outcome = motion.rollout.outcome
    marks = {mark["name"]: mark["time"] for mark in page.facts["timeline"]["marks"]}
    assert marks["lift-off"] == pytest.approx(motion.plan.phase_start[1])
    assert marks["touchdown"] == pytest.approx(motion.plan.phase_start[2])
    assert marks["first contact"] == outcome.touchdown_true_s
    assert marks["detected"] == outcome.touchdown_detected_s
    assert page.facts["description"]["request"] == motion.plan.jump.as_dict()


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
    export(replace(plan, jump=jump), folder / "x.html", format="html")
    return folder / "x.html"


def test_words_from_files_are_no_markup(hostile):
    page = Page(hostile)
    assert "<img" not in page.element("facts")
    assert HOSTILE not in page.text
    assert page.facts["title"].startswith(HOSTILE)


needs_chromium = pytest.mark.skipif(shutil.which("chromium") is None, reason="no Chromium")


def played(browser, path):
    """The page, opened from disk; `faults` has errors, its console's too, and requests."""
    from tests.app.chromium import opened

    page = opened(browser, path.as_uri(), {"width": 640, "height": 420})
    page.on("console", lambda said: page.faults.append(said.text) if said.type == "error" else None)
    page.wait_for_function("window.replay.player")  # before, the element of that id
    return page


def pose_of(tab, name):
    """Where a node is drawn: its place and attitude w, x, y, z in the scene."""
    return tab.evaluate(
        """(name) => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => {
          const { position, quaternion } = window.__viserMutable.nodeRefFromName[name];
          done([...position.toArray(), quaternion.w, quaternion.x, quaternion.y, quaternion.z]);
        })))""",
        name,
    )


@pytest.mark.browser
@needs_chromium
@pytest.mark.parametrize("motion", ["slider"], indirect=True)
def test_a_browser_draws_what_was_recorded(browser, replay, motion):
    tab = played(browser, replay)
    rollout, base = motion.rollout, f"/robot/{Page(replay).facts['bodies'][0]}"
    tab.evaluate("replay.player.pause()")
    for tick in np.linspace(0, len(rollout.time) - 1, 5).astype(int):
        tab.evaluate("t => replay.player.seek(t)", float(rollout.time[tick]))
        tab.wait_for_function(
            """([name, x]) => Math.hypot(...window.__viserMutable.nodeRefFromName[name].position
              .toArray().map((value, i) => value - x[i])) < 1e-3""",
            arg=[base, rollout.qpos[tick, :3].tolist()],
        )
        pose = pose_of(tab, base)
        assert abs(np.dot(pose[3:], rollout.qpos[tick, 3:7])) == pytest.approx(1, abs=1e-4)
    assert tab.faults == []
    tab.close()


@pytest.fixture(scope="module")
def tab(browser, tmp_path_factory):
    """A robot that is quickly drawn; a page left open would go on drawing beside later tests."""
    path = tmp_path_factory.mktemp("slider") / "replay.html"
    export(motion_of("slider").rollout, path, format="html")
    page = played(browser, path)
    yield page
    page.close()


@pytest.mark.browser
@needs_chromium
class TestInABrowser:
    def test_time_goes_on_while_it_plays(self, tab):
        first = tab.evaluate("replay.player.time")
        tab.wait_for_function("t => Math.abs(replay.player.time - t) > 0.05", arg=first)
        tab.keyboard.press("Space")
        assert not tab.evaluate("replay.player.playing")
        assert tab.faults == []

    def test_keys(self, tab):
        camera = "window.__viserMutable.cameraControl.getPosition().toArray()"
        before = tab.evaluate(camera)
        end = tab.evaluate("replay.player.end")
        tab.keyboard.press("End")
        assert tab.evaluate("replay.player.time") == end
        tab.keyboard.press("ArrowLeft")
        assert 0 < end - tab.evaluate("replay.player.time") < 1 / 120 + 1e-6
        tab.keyboard.press("ArrowRight")
        assert tab.evaluate("replay.player.time") == end
        tab.keyboard.press("Home")
        assert tab.evaluate("replay.player.time") == 0
        tab.keyboard.press("l")
        assert not tab.evaluate("replay.player.loop")
        assert tab.evaluate(camera) == pytest.approx(before)  # viser's own keys move it

    def test_the_timeline(self, tab):
        strip = tab.locator("#rows").bounding_box()
        for share in (0.05, 0.25):
            tab.mouse.click(strip["x"] + share * strip["width"], strip["y"] + 4)
            at = tab.evaluate("replay.player.time / replay.player.end")
            assert at == pytest.approx(share, abs=0.01)
        assert "lift-off" in tab.locator("#track").inner_text()

    def test_layers(self, tab):
        for layer, node in (
            ("Plan", "/ghost"),
            ("Inertia ellipsoid", "/ellipsoid"),
            ("Contact forces", "/forces"),
            ("CoM, trails", "/trails"),
            ("robot", "/robot"),
        ):
            visible = f"window.__viserMutable.nodeRefFromName['{node}'].visible === {{}}"
            tab.get_by_role("checkbox", name=layer).uncheck()
            tab.wait_for_function(visible.format("false"))
            tab.get_by_role("checkbox", name=layer).check()
            tab.wait_for_function(visible.format("true"))
        assert tab.faults == []

    def test_the_camera(self, tab):
        place = "window.__viserMutable.cameraControl.getPosition().toArray()"
        tab.get_by_label("Look from where it began").click()
        before = tab.evaluate(place)
        moved = f"([a, least]) => Math.hypot(...{place}.map((v, i) => v - a[i])) > least"
        tab.mouse.move(300, 150)
        tab.mouse.wheel(0, 400)
        tab.wait_for_function(moved, arg=[before, 0.05])
        tab.get_by_label("Look from where it began").click()
        tab.wait_for_function(moved.replace("> least", "< least"), arg=[before, 1e-3])
        assert tab.faults == []


@pytest.mark.browser
@needs_chromium
def test_words_from_files_do_nothing_in_a_browser(browser, hostile):
    tab = played(browser, hostile)
    assert tab.title().startswith(HOSTILE)
    assert tab.locator("#replay h1").inner_text().startswith(HOSTILE)
    assert tab.locator("#replay img").count() == 0
    assert tab.faults == []
    tab.close()
