"""Opening files of any format, and files that are none any more."""

import zipfile

import numpy as np
import pytest

import llsrbm
from llsrbm.errors import Error, FileFormatError, InputError
from llsrbm.formats import export, readable
from llsrbm.motion.whole_body import whole_body_motion
from tests.llsrbm.formats.jumps import planned, simulated

FOREIGN = {"unitree-csv": "csv", "motion-npz": "npz", "mujoco": "zip"}


@pytest.fixture(scope="module", params=["npz", *FOREIGN])
def whole(request, tmp_path_factory):
    """A format and a short file of it."""
    path = tmp_path_factory.mktemp("whole") / f"jump.{FOREIGN.get(request.param, 'npz')}"
    export(planned("anymal"), path, format=request.param, **_few(request.param))
    return request.param, path


def _few(name):
    return {} if name == "npz" else {"fps": 10}


def test_formats_that_can_be_opened():
    assert {"npz", *FOREIGN} <= {each.name for each in readable()}


@pytest.mark.parametrize("made", [planned, simulated])
def test_native_files_know_their_robot(tmp_path, made):
    made("go2").save(tmp_path / "x.npz")
    motion = llsrbm.load_motion(tmp_path / "x.npz")
    truth = whole_body_motion(made("go2"), 60)
    assert motion.robot.name == "go2"
    assert motion.origin == truth.origin
    np.testing.assert_array_equal(motion.qpos, truth.qpos)
    assert llsrbm.load_motion(tmp_path / "x.npz", fps=25).fps == 25


def test_the_format_is_seen(whole):
    name, path = whole
    seen = llsrbm.load_motion(path)
    told = llsrbm.load_motion(str(path), format=name)
    np.testing.assert_array_equal(seen.qpos, told.qpos)
    assert seen.origin == ("plan" if name == "npz" else name)


def test_no_such_format_file_or_robot(whole, tmp_path):
    _, path = whole
    with pytest.raises(InputError, match='no format "bvh"'):
        llsrbm.load_motion(path, format="bvh")
    with pytest.raises(InputError, match='format "csv" is written and not opened'):
        llsrbm.load_motion(path, format="csv")
    with pytest.raises(InputError, match='"spot"'):
        llsrbm.load_motion(path, robot="spot")
    with pytest.raises(FileFormatError, match="cannot be read: No such file"):
        llsrbm.load_motion(tmp_path / "none.csv")
    with pytest.raises(FileFormatError, match="not a file that can be opened"):
        llsrbm.load_motion(tmp_path)


def test_files_of_no_format(tmp_path):
    (tmp_path / "x.bvh").write_text("HIERARCHY")
    np.savez(tmp_path / "x.npz", a=np.zeros(3))
    with zipfile.ZipFile(tmp_path / "x.zip", "w") as archive:
        archive.writestr("readme.txt", "nothing")
    for name in ("x.bvh", "x.zip"):
        with pytest.raises(FileFormatError, match="not a file that can be opened; expected npz"):
            llsrbm.load_motion(tmp_path / name)
    said = "not a file that can be opened, as it has the keys a; expected npz .* with qpos"
    with pytest.raises(FileFormatError, match=said):
        llsrbm.load_motion(tmp_path / "x.npz")


def opened_or_refused(path, **arguments):
    """Whether it could be opened; whatever is wrong is said in one line."""
    try:
        motion = llsrbm.load_motion(path, **arguments)
    except Error as error:
        assert isinstance(error, InputError)
        assert str(error)
        assert "\n" not in str(error)
        return False
    assert np.isfinite(motion.qpos).all()
    assert np.isfinite(motion.angular_momentum).all()
    return True


def test_files_with_wrong_bytes(whole, tmp_path):
    name, path = whole
    content = path.read_bytes()
    damaged = tmp_path / path.name
    refused = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        wrong = bytearray(content)
        for _ in range(rng.integers(1, 5)):
            # The headers of an archive, most of which stand at its end, as often as the rest.
            last = len(wrong) if rng.random() < 0.5 else min(len(wrong), 1500)
            wrong[-rng.integers(1, last + 1)] = rng.integers(256)
        damaged.write_bytes(wrong)
        refused += not opened_or_refused(damaged, format=name, fps=10)
    assert refused > 5
