"""Videos and moving pictures, decoded again: how many pictures, how long, what is to be seen."""

import json
import math
import subprocess
import sys
from ctypes.util import find_library
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image, ImageSequence

from llsrbm.errors import Error, InputError
from llsrbm.formats import export
from llsrbm.formats.base import Options
from llsrbm.formats.pictures.drawing import draw, view_of
from llsrbm.formats.pictures.video import durations, pictures
from tests.llsrbm.formats.pictures.shown import motion_of

av = pytest.importorskip("av")

SIZE = (160, 90)
FPS = 8.0


@pytest.fixture(scope="module")
def opengl():
    """OpenGL without a screen."""
    code = "import mujoco.egl; mujoco.egl.GLContext(8, 8)"
    tried = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert tried.returncode == 0, f"no OpenGL; `.ci/drawing` installs it: {tried.stderr}"


needs_opengl = pytest.mark.usefixtures("opengl")


@pytest.fixture(scope="module")
def motion():
    return motion_of("go2")


@pytest.fixture(scope="module")
def video(motion, tmp_path_factory):
    path = tmp_path_factory.mktemp("video") / "x.mp4"
    export(motion.rollout, path, format="mp4", fps=FPS, size=SIZE)
    return path


@pytest.fixture(scope="module")
def animation(motion, tmp_path_factory):
    path = tmp_path_factory.mktemp("gif") / "é"  # any name will do
    export(motion.rollout, path, format="gif", fps=FPS, size=SIZE)
    return path


def decoded(path):
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24").astype(int) for frame in container.decode(video=0)]


def expected_count(rollout):
    return math.ceil(rollout.duration * FPS - 1e-6) + 1


@needs_opengl
class TestVideo:
    def test_what_players_need(self, video, motion):
        with av.open(str(video)) as container:
            stream = container.streams.video[0]
            assert stream.codec_context.name == "h264"
            assert stream.pix_fmt == "yuv420p"
            assert (stream.width, stream.height) == SIZE
            assert stream.average_rate == FPS
            count = expected_count(motion.rollout)
            assert stream.frames == count
            assert container.duration / 1e6 == pytest.approx(count / FPS, abs=0.01)
        data = video.read_bytes()
        assert data.index(b"moov") < data.index(b"mdat")

    def test_it_says_what_it_is(self, video, motion):
        with av.open(str(video)) as container:
            said = container.metadata
        assert said["title"].startswith("Unitree Go2: ")
        assert json.loads(said["comment"])["request"] == motion.plan.jump.as_dict()

    def test_the_robot_moves(self, video):
        frames = decoded(video)
        moving = [np.abs(b - a).max(axis=2) > 40 for a, b in pairwise(frames)]
        assert max(mask.sum() for mask in moving) > 60
        # Standing at the end, and before that somewhere else than at the beginning.
        assert moving[-1].sum() < 10
        assert (np.abs(frames[-1] - frames[0]).max(axis=2) > 40).sum() > 60


@needs_opengl
class TestAnimation:
    def test_pictures_and_their_times(self, animation, motion):
        with Image.open(animation) as image:
            assert image.size == SIZE
            assert image.info["loop"] == 0
            shown = [frame.info["duration"] for frame in ImageSequence.Iterator(image)]
        # Pictures that are alike are one that is shown longer.
        count = expected_count(motion.rollout)
        assert 0.5 * count < len(shown) <= count
        assert sum(shown) == pytest.approx(1000 * count / FPS, abs=10)
        assert animation.stat().st_size < 5e6

    def test_it_says_what_it_is(self, animation, motion):
        with Image.open(animation) as image:
            said = json.loads(image.info["comment"])
        assert said["request"] == motion.plan.jump.as_dict()


def test_hundredths_of_a_second_do_not_drift():
    for fps in (7.0, 25.0, 30.0, 48.0):
        shown = durations(100, fps)
        assert sum(shown) == pytest.approx(1e5 / fps, abs=10)
        assert all(each % 10 == 0 and each >= 20 for each in shown)


@needs_opengl
@pytest.mark.parametrize("name", ["anymal"])
def test_robots_have_their_colours(name):
    """Of the pictures of a standing robot, where it is, none is plain ground."""
    plan = motion_of(name).plan
    picture = next(iter(pictures(plan, Options(fps=1.0, size=(320, 200))))).astype(int)
    drawing = draw(plan, 1.0)
    at = seen_at(view_of(drawing, 1.6), drawing.solid.body_position[0], (320, 200))
    ground = np.median(picture[-20:].reshape(-1, 3), axis=0)
    off = [np.abs(picture[y, x] - ground).max() for x, y in at.round().astype(int)]
    assert np.median(off) > 40
    spread = picture[60:150, 110:210].reshape(-1, 3)
    assert len(np.unique(spread // 16, axis=0)) > 15


def seen_at(view, points, size):
    """Pixels (n, 2) of points (n, 3) m in a picture of `size`, by a pinhole camera's formula."""
    x, y, back = ((points - view.target) @ view.axes).T
    focal = size[1] / 2 / math.tan(math.radians(36.0) / 2)
    away = view.distance - back
    return np.stack([size[0] / 2 + focal * x / away, size[1] / 2 - focal * y / away], axis=1)


@pytest.mark.parametrize("camera", [None, (-40.0, 20.0, 3.0)])
@pytest.mark.parametrize("name", ["slider"])
def test_the_robot_is_in_the_picture_all_the_time(name, camera):
    drawing = draw(motion_of(name).rollout, 20.0)
    view = view_of(drawing, 16 / 9, camera)
    for k in range(0, len(drawing.solid.time), 5):
        at = seen_at(view, drawing.solid.body_position[k], (160, 90))
        assert (at > 0).all()
        assert (at < [160, 90]).all()
    if camera is None:
        at = seen_at(
            view, np.vstack([*drawing.solid.body_position, *drawing.solid.foot_position]), (160, 90)
        )
        assert np.ptp(at, axis=0).max() > 40  # not small either


class TestMistakes:
    @pytest.mark.parametrize(
        ("name", "options", "said"),
        [
            ("mp4", {"size": (161, 90)}, "even numbers"),
            ("mp4", {"size": (0, 90)}, "32 to 4096 pixels"),
            ("gif", {"size": (160.5, 90)}, "32 to 4096 pixels"),
            ("mp4", {"fps": 1000}, "1 to 240"),
            ("gif", {"fps": 60}, "1 to 50"),
            ("gif", {"camera": (0, 0, -1)}, "a distance > 0"),
        ],
    )
    def test_are_told(self, motion, name, options, said, tmp_path):
        with pytest.raises(InputError, match=said):
            export(motion.plan, tmp_path / "x", format=name, **options)
        assert not list(tmp_path.iterdir())

    @pytest.mark.parametrize("backend", ["egl", "osmesa"])
    def test_no_opengl(self, motion, tmp_path, monkeypatch, backend):
        """As where neither library is installed: importing MuJoCo fails, or a context does."""
        monkeypatch.setenv("MUJOCO_EGL_DEVICE_ID", "99")
        monkeypatch.setenv("MUJOCO_GL", backend)
        if backend == "osmesa" and find_library("OSMesa"):
            pytest.skip("OSMesa is there")
        with pytest.raises(InputError, match="apt install libegl1") as caught:
            export(motion.plan, tmp_path / "x.gif", format="gif", fps=1.0, size=SIZE)
        assert "\n" not in str(caught.value)
        assert not list(tmp_path.iterdir())

    def test_a_drawing_process_that_dies(self, motion, tmp_path, monkeypatch):
        monkeypatch.setenv("PYTHONHOME", str(tmp_path))
        with pytest.raises(Error, match="drawing pictures failed"):
            export(motion.plan, tmp_path / "x.gif", format="gif", fps=1.0, size=SIZE)


def test_a_motion_that_is_none(motion, tmp_path):
    """A solver that diverged may leave anything."""
    wild = motion.plan.com.copy()
    wild[5] = np.nan
    for name in ("html", "gif", "mp4"):
        with pytest.raises(InputError, match="com is not finite"):
            export(replace(motion.plan, com=wild), tmp_path / "x", format=name)
    assert not list(tmp_path.iterdir())
