"""The replay page, unpacked as a browser would, and played in one."""

from __future__ import annotations

import base64
import gzip
import json
import re
import shutil
import time
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.errors import InputError
from llsrbm.formats import export
from llsrbm.look.visuals import link_visuals
from llsrbm.motion.sampling import resample
from llsrbm.motion.whole_body import whole_body_motion
from llsrbm.robots import load_robot
from tests.llsrbm.formats.pictures.shown import motion_of
from tests.llsrbm.kinematics import link_poses

HOSTILE = "<script>document.title='taken'<!--"


class Page(HTMLParser):
    """Elements with an id or a name, and their text."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.texts, self.attributes = [], {}, []
        self._inside = None
        self.feed(text)
        self.facts = json.loads(self.texts["facts"])
        stored = gzip.decompress(base64.b64decode(self.texts["numbers"]))
        self.arrays = {
            name: np.frombuffer(stored, each["kind"], each["length"], each["start"])
            for name, each in self.facts["arrays"].items()
        }

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        self._inside = dict(attrs).get("id", tag)

    def handle_data(self, data):
        self.texts.setdefault(self._inside, data)

    def handle_endtag(self, tag):
        self._inside = None


@pytest.fixture(scope="module", params=["anymal", "slider", "go2"])
def motion(request):
    """A plan and a rollout of a robot that turns half around."""
    return motion_of(request.param)


@pytest.fixture(scope="module")
def replay(motion, tmp_path_factory):
    path = tmp_path_factory.mktemp("html") / "rollout.html"
    began = time.monotonic()
    export(motion.rollout, path, format="html")
    return path, time.monotonic() - began


@pytest.fixture(scope="module")
def page(replay):
    return Page(replay[0].read_text(encoding="utf-8"))


def poses(page, name):
    """(K, bodies, 7)."""
    return page.arrays[name].reshape(len(page.arrays["time"]), -1, 7)


def test_it_is_small_and_quickly_made(replay):
    path, seconds = replay
    assert path.stat().st_size < 3e6
    assert seconds < 20
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def test_it_asks_for_nothing(replay):
    text = replay[0].read_text(encoding="utf-8")
    page = Page(text)
    assert not {"src", "href"} & {name for name, _ in page.attributes}
    assert "link" not in page.tags
    assert set(re.findall(r"https?://[^\s\"']+", text)) <= {"http://www.w3.org/2000/svg"}
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', text)
    assert policy.startswith("default-src 'none'")
    assert "unsafe" not in policy


def test_bodies_are_where_the_motion_has_them(motion, page):
    """By Pinocchio's own kinematics, through half a turn."""
    sampled = whole_body_motion(motion.rollout, 120.0, events=True)
    np.testing.assert_allclose(page.arrays["time"], sampled.time, atol=1e-6)
    stored = poses(page, "solid")
    robot = sampled.robot
    for k in range(0, len(sampled.time), 7):
        for i, body in enumerate(page.facts["bodies"]):
            place, R = link_poses(robot, sampled.qpos[k])[body["name"]]
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
    alone = Page((tmp_path / "x.html").read_text(encoding="utf-8"))
    assert "ghost" not in alone.arrays
    assert "solid" in alone.arrays


def test_forces_carry_the_robot_at_the_end(motion, page):
    robot = load_robot(motion.rollout.jump.robot)
    force = page.arrays["force"].reshape(len(page.arrays["time"]), -1, 6)[..., 3:]
    weight = robot.mass * 9.81
    standing = force[page.arrays["time"] > page.arrays["time"][-1] - 0.2].mean(axis=0).sum(axis=0)
    np.testing.assert_allclose(standing, [0, 0, weight], atol=0.03 * weight)
    flying = page.arrays["flight"].astype(bool)
    assert np.abs(force[flying]).max() < 1e-6 * weight
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


@pytest.mark.parametrize("detail", ["fine", "coarse"])
def test_meshes_are_the_robots(motion, page, detail):
    visuals = link_visuals(load_robot(motion.plan.jump.robot), coarse=detail == "coarse")
    unit = page.facts["meshUnit"]
    points = page.arrays[f"{detail}_points"].reshape(-1, 4)[:, :3] * (unit / 32767)
    np.testing.assert_allclose(points, np.vstack([v.vertices for v in visuals]), atol=5e-5)
    paint = page.arrays[f"{detail}_paint"].reshape(-1, 4)[:, :3]
    np.testing.assert_array_equal(paint, np.vstack([v.rgb for v in visuals]))
    faces = page.arrays[f"{detail}_faces"].reshape(-1, 3)
    np.testing.assert_array_equal(faces, np.vstack([v.faces for v in visuals]))
    counts = [(len(v.vertices), len(v.faces)) for v in visuals]
    assert [tuple(body[detail].values()) for body in page.facts["bodies"]] == counts


def test_phases_and_events(motion, page):
    outcome = motion.rollout.outcome
    marks = {mark["name"]: mark["time"] for mark in page.facts["timeline"]["marks"]}
    assert marks["take-off"] == pytest.approx(motion.plan.phase_start[1])
    assert marks["touch-down planned"] == pytest.approx(motion.plan.phase_start[2])
    assert marks["first contact"] == outcome.touchdown_true_s
    assert marks["detected"] == outcome.touchdown_detected_s
    assert page.facts["description"]["request"] == motion.plan.jump.as_dict()


def test_the_same_motion_gives_the_same_page(motion, tmp_path):
    for name in ("a.html", "b.html"):
        export(motion.plan, tmp_path / name, format="html", fps=30)
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_a_camera_that_makes_no_sense(motion, tmp_path):
    for camera in ((0, 100, 1), (0, 0, 0), (0, float("nan"), 1)):
        with pytest.raises(InputError, match="camera: expected azimuth"):
            export(motion.plan, tmp_path / "x.html", format="html", camera=camera)
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
    export(replace(plan, jump=jump), folder / "x.html", format="html")
    return folder / "x.html"


def test_words_from_files_are_no_markup(hostile):
    page = Page(hostile.read_text(encoding="utf-8"))
    assert "img" not in page.tags
    assert page.tags.count("script") == 3
    assert page.facts["title"].startswith(HOSTILE)
    assert page.texts["title"].startswith(HOSTILE)


needs_chromium = pytest.mark.skipif(shutil.which("chromium") is None, reason="no Chromium")


def played(browser, path):
    """The page, opened from disk; `faults` has errors, its console's too, and requests."""
    from tests.app.chromium import opened

    page = opened(browser, path.as_uri(), {"width": 640, "height": 420})
    page.on("console", lambda said: page.faults.append(said.text) if said.type == "error" else None)
    page.wait_for_function("window.replay")
    return page


def drawn(tab):
    """The picture, once it is up to date."""
    tab.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return tab.locator("#picture").screenshot()


@pytest.mark.browser
@needs_chromium
def test_a_browser_draws_what_was_recorded(browser, replay, motion):
    tab = played(browser, replay[0])
    rollout = motion.rollout
    base = Page(replay[0].read_text(encoding="utf-8")).facts["bodies"][0]["name"]
    for tick in np.linspace(0, len(rollout.time) - 1, 7).astype(int):
        pose = tab.evaluate(
            """([time, name]) => new Promise((done) => {
              replay.player.pause();
              replay.player.seek(time);
              requestAnimationFrame(() => requestAnimationFrame(
                () => done(replay.scene.drawn[name])));
            })""",
            [float(rollout.time[tick]), base],
        )
        np.testing.assert_allclose(pose[:3], rollout.qpos[tick, :3], atol=1e-3)
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
        tab.wait_for_function("t => replay.player.time > t + 0.05", arg=first)
        tab.keyboard.press("Space")
        still = tab.evaluate("replay.player.time")
        tab.wait_for_timeout(200)
        assert tab.evaluate("replay.player.time") == still
        assert tab.faults == []

    def test_keys(self, tab):
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

    def test_dragging_along_the_timeline_moves_the_robot(self, tab):
        strip = tab.locator("#rows").bounding_box()
        pictures = []
        for share in (0.05, 0.25):
            tab.mouse.move(strip["x"] + share * strip["width"], strip["y"] + 4)
            tab.mouse.down()
            tab.mouse.up()
            at = tab.evaluate("replay.player.time / replay.player.end")
            assert at == pytest.approx(share, abs=0.01)
            pictures.append(drawn(tab))
        assert pictures[0] != pictures[1]

    def test_layers(self, tab):
        tab.evaluate("replay.player.pause(); replay.player.seek(0.1)")
        seen = {drawn(tab)}
        for layer in ("Plan", "Inertia ellipsoid", "Contact forces", "CoM, trails", "robot"):
            tab.get_by_role("checkbox", name=layer).uncheck()
            seen.add(drawn(tab))
        # The plan and the robot are at the same place as long as it stands.
        assert len(seen) >= 5
        assert tab.faults == []

    def test_the_camera(self, tab):
        before = tab.evaluate("[replay.camera.azimuth, replay.camera.distance]")
        tab.mouse.move(300, 200)
        tab.mouse.down()
        tab.mouse.move(360, 200)
        tab.mouse.up()
        tab.mouse.wheel(0, 400)
        tab.wait_for_function("d => replay.camera.distance > 1.2 * d", arg=before[1])
        assert tab.evaluate("replay.camera.azimuth") == pytest.approx(before[0] - 24)
        tab.get_by_label("Look from where it began").click()
        again = tab.evaluate("[replay.camera.azimuth, replay.camera.distance]")
        assert again == pytest.approx(before)


@pytest.mark.browser
@needs_chromium
def test_with_a_graphics_card_all_faces_are_drawn(browser, tmp_path):
    """The browser keeps to itself that it has none."""
    path = tmp_path / "x.html"
    export(motion_of("go2").plan, path, format="html", fps=20)
    tab = browser.new_page(viewport={"width": 320, "height": 240})
    tab.add_init_script(
        """const ask = WebGL2RenderingContext.prototype.getExtension;
        WebGL2RenderingContext.prototype.getExtension = function (name) {
          return name === "WEBGL_debug_renderer_info" ? null : ask.call(this, name);
        };"""
    )
    tab.goto(path.as_uri())
    tab.wait_for_function("window.replay")
    faces = "replay.scene.{}.reduce((sum, shape) => sum + shape.count / 3, 0)"
    visuals = link_visuals(load_robot("go2"))
    assert tab.evaluate(faces.format("fine")) == sum(len(v.faces) for v in visuals)
    assert tab.evaluate(faces.format("coarse")) < 12_000
    assert tab.evaluate("replay.scene.gl.getError()") == 0
    tab.close()


@pytest.mark.browser
@needs_chromium
def test_words_from_files_do_nothing_in_a_browser(browser, hostile):
    tab = played(browser, hostile)
    assert tab.title().startswith(HOSTILE)
    assert tab.locator("h1").inner_text().startswith(HOSTILE)
    assert tab.locator("img").count() == 0
    assert tab.faults == []
    tab.close()
