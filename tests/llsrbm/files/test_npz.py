"""Files from strangers: refused in a line or harmless, and nothing in them is run or believed."""

import json
import os
import struct
import time
import tracemalloc
import zipfile

import numpy as np
import pytest

from llsrbm.errors import FileFormatError
from llsrbm.files import npz
from llsrbm.formats import load_any, load_motion
from llsrbm.formats.mujoco.motion import recognises
from llsrbm.motion.trajectory import load
from tests.llsrbm.hostile import (
    DAMAGE,
    SOUND,
    Seeds,
    damaged_design,
    members_of,
    outcome,
    outcome_of_design,
    packed,
    zipped,
)

EACH = 12


@pytest.fixture(scope="module")
def seeds(tmp_path_factory):
    return Seeds(tmp_path_factory.mktemp("seeds"))


@pytest.fixture
def plan(seeds):
    """Name -> array of a sound plan's file."""
    return dict(seeds.arrays[0])


@pytest.fixture
def rollout(seeds):
    return dict(seeds.arrays[2])


def said_of(content, folder, **limits):
    path = folder / "x.npz"
    path.write_bytes(content)
    with pytest.raises(FileFormatError) as caught:
        load(path, **limits)
    assert str(caught.value).isprintable()
    return str(caught.value)


@pytest.mark.filterwarnings("ignore:Duplicate name")
@pytest.mark.parametrize("kind", DAMAGE)
def test_damage_is_a_line_or_harmless(seeds, tmp_path, kind):
    for number in range(EACH):
        path = tmp_path / "damaged.npz"
        path.write_bytes(DAMAGE[kind](seeds, np.random.default_rng([7, number])))
        assert outcome(path, seeds.canary, tmp_path) in SOUND, number


def test_damaged_designs():
    for number in range(100):
        content = damaged_design(np.random.default_rng([7, number]))
        assert outcome_of_design(content) in SOUND, number


HEADER = "{'descr': '<f8', 'fortran_order': False, 'shape': (10, 3), }\n"


@pytest.mark.parametrize(
    "header",
    [
        "{'descr': '<f8', 'fortran_order': False, 'shape': (10, 3), ",  # tokenize.TokenError
        "'''",
        "(" * 5000,  # MemoryError or RecursionError of Python's parser
        "-" * 9999 + "1",
        HEADER.replace("(10, 3)", "(10, 3) if 1 else 2"),
        HEADER.replace("(10, 3)", "(99999999999, 99999999999)"),
        HEADER.replace("(10, 3)", "(10, 4)"),
        HEADER.replace("(10, 3)", "(1, 1, 1, 1, 1, 1, 1, 10, 3)"),
        HEADER.replace("'<f8'", "'|O'"),
        HEADER.replace("'<f8'", "'<U999999999'"),
        HEADER.replace("'<f8'", "'<M8[ns]'"),
        HEADER.replace("'<f8'", "[('a', '<f8')]"),
        "\x00" * 80,
        "",
    ],
)
def test_headers_are_not_evaluated(plan, tmp_path, header):
    raw = header.encode()
    member = b"\x93NUMPY\1\0" + struct.pack("<H", len(raw)) + raw + bytes(240)
    members = [(n, member if n == "com.npy" else c) for n, c in members_of(packed(plan))]
    assert 'key "com"' in said_of(zipped(members), tmp_path)


def test_bytes_beyond_those_of_the_header(plan, tmp_path):
    members = [(n, c + bytes(8 * (n == "com.npy"))) for n, c in members_of(packed(plan))]
    assert 'key "com": damaged' in said_of(zipped(members), tmp_path)


@pytest.mark.parametrize("key", ["schema", "meta", "joint_names"])
@pytest.mark.parametrize("letter", [0xD800, 0xFFFFFFFF])
def test_text_of_numbers_that_are_no_letters(plan, tmp_path, key, letter):
    letters = plan[key].copy().reshape(-1).view(np.uint32)
    letters[1] = letter
    text = letters.view(plan[key].dtype).reshape(plan[key].shape)
    assert f'key "{key}": holds what is no text' in said_of(packed(plan, **{key: text}), tmp_path)


class TestSizes:
    def test_more_data_than_the_directory_says(self, plan, tmp_path):
        """zipfile's own `read` would unpack all of it."""
        size = 150_000_000
        zeros = ("zeros.npy", bytes(size))
        bomb = bytearray(zipped([*members_of(packed(plan)), zeros], zipfile.ZIP_DEFLATED))
        place = bomb.rfind(b"PK\1\2") + 24
        bomb[place : place + 4] = struct.pack("<L", 200)
        tracemalloc.start()
        said = said_of(bytes(bomb), tmp_path)
        assert tracemalloc.get_traced_memory()[1] < size / 10
        tracemalloc.stop()
        assert "Bad CRC" in said

    def test_the_sum_is_limited(self, plan, tmp_path):
        content = packed(plan)
        assert len(content) < 100_000
        zeros = [(f"{i}.npy", bytes(60_000)) for i in range(2)]
        for too_large in (
            zipped([*members_of(content), *zeros], zipfile.ZIP_DEFLATED),
            bytes(100_001),
        ):
            said = said_of(too_large, tmp_path, largest=100_000)
            assert "at most 100000 are read" in said

    @pytest.mark.parametrize("key", ["qpos", "joint_pos", "com"])
    def test_small_numbers_are_counted_as_they_are_used(self, plan, tmp_path, key):
        """A float64 takes eight times the room of the int8 in the file."""
        frames, dtype = 2_000_000, np.int8
        wide = {key: np.zeros((frames, 19), dtype)}
        arrays = {**plan, **wide} if key == "com" else wide
        if key == "joint_pos":
            arrays |= {"body_pos_w": np.zeros((2, 13, 3)), "joint_names": plan["joint_names"]}
        np.savez_compressed(tmp_path / "x.npz", **arrays)
        assert (tmp_path / "x.npz").stat().st_size < 200_000
        tracemalloc.start()
        with pytest.raises(FileFormatError):
            load_any(tmp_path / "x.npz", "anymal", 50)
        assert tracemalloc.get_traced_memory()[1] < 100e6
        tracemalloc.stop()

    def test_so_is_the_directory(self, plan, tmp_path):
        """Listing 300,000 names takes minutes, whoever lists them."""
        content = bytearray(packed(plan))
        end = content.rfind(b"PK\5\6")
        entry = content[content.rfind(b"PK\1\2") : end]
        names = entry * 300_000
        content[end + 8 : end + 12] = struct.pack("<HH", 60_000, 60_000)
        content[end + 12 : end + 16] = struct.pack("<L", end - content.find(b"PK\1\2") + len(names))
        content[end:end] = names
        path = tmp_path / "x.npz"
        began = time.process_time()
        assert "too many files" in said_of(bytes(content), tmp_path)
        assert npz.keys(path) == frozenset()
        assert not recognises(path)
        with pytest.raises(FileFormatError, match="not a file that can be opened"):
            load_motion(path, "anymal")
        assert time.process_time() - began < 2.0

    def test_pipes_are_not_waited_for(self, tmp_path):
        os.mkfifo(tmp_path / "pipe")
        with pytest.raises(FileFormatError, match="not a regular file"):
            load(tmp_path / "pipe")

    def test_a_key_that_is_there_twice(self, plan, tmp_path):
        members = members_of(packed(plan))
        with pytest.warns(UserWarning, match="Duplicate"):
            content = zipped([*members, members[3]])
        assert "is there twice" in said_of(content, tmp_path)

    @pytest.mark.parametrize("compression", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
    def test_other_compression(self, plan, tmp_path, compression):
        assert "packed as NumPy" in said_of(zipped(members_of(packed(plan)), compression), tmp_path)


class TestArraysThatDisagree:
    @pytest.mark.parametrize(
        ("changes", "said"),
        [
            ({"joint_names": lambda v: np.array(["a"] * len(v))}, "each of them once"),
            ({"joint_names": lambda v: np.array(["", *v[1:]])}, "each of them once"),
            ({"joint_names": lambda v: np.array(["a\x1b[2J", *v[1:]])}, "each of them once"),
            ({"joint_names": lambda v: np.array(["\ud800", *v[1:]])}, "no text"),
            ({"base_mass": lambda v: 0 * v}, "expected masses"),
            ({"leg_mass": lambda v: -v}, "expected masses"),
            ({"time": lambda v: 1e-12 * v}, "strictly increasing"),
            ({"time": lambda v: 100 * v}, "up to 100 s"),
            ({"time": lambda v: v + 1}, "from 0 s on"),
            ({"com": lambda v: 1e200 * v}, "expected at most 1e+30"),
            (
                {
                    "contact_point": lambda v: np.repeat(v, 2, axis=1)[:, :7],
                    "contact_force": lambda v: np.repeat(v, 2, axis=1)[:, :7],
                },
                "as many contacts for each of 4 legs, got 7",
            ),
            (
                dict.fromkeys(
                    ("joint_position", "joint_velocity", "joint_torque", "joint_torque_limit"),
                    lambda v: np.zeros((len(v), 1001)),
                )
                | {"joint_names": lambda _: np.array([f"j{i}" for i in range(1001)])},
                "at most 1000",
            ),
        ],
    )
    def test_of_a_plan(self, plan, tmp_path, changes, said):
        changed = {key: change(plan[key]) for key, change in changes.items()}
        assert said in said_of(packed(plan, **changed), tmp_path)

    def test_without_its_plan(self, rollout, tmp_path):
        alone = {key: value for key, value in rollout.items() if not key.startswith("plan/")}
        assert 'plan/: key "schema" is missing' in said_of(packed(alone), tmp_path)

    @pytest.mark.parametrize(
        ("place", "value", "said"),
        [
            (("outcome", "control_rate_hz"), 0, "control_rate_hz: expected a rate"),
            (("robot_parameters", "mass"), 0, "mass: Input should be greater than 0"),
            (("robot_parameters", "mass"), "heavy", "mass: Input should be a valid number"),
            (("robot_parameters", "legs"), 5, "legs: Input should be"),
            (("robot_parameters", "sliding_joints"), [[1]], "sliding_joints.0: Input should be"),
            (("robot_parameters", "inertia"), [[1.0]], "inertia"),
            (("robot_parameters", "whatever"), 10**400, "whole numbers up to 2^64"),
            (("scenario", "seed"), 10**400, "whole numbers up to 2^64"),
        ],
    )
    def test_in_meta(self, rollout, tmp_path, place, value, said):
        meta = json.loads(str(rollout["meta"]))
        meta[place[0]][place[1]] = value
        assert said in said_of(packed(rollout, meta=np.array(json.dumps(meta))), tmp_path)
