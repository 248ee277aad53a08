"""Reading pickles: numbers are read, whichever program wrote them, and no code is run."""

import gzip
import io
import os
import pickle
import zlib
from collections import OrderedDict

import numpy as np
import pytest

from llsrbm.errors import FileFormatError
from llsrbm.files import pickles
from llsrbm.files.pickles import read_pickle

CONTENT = {
    "fps": 30,
    "rows": np.arange(6.0).reshape(2, 3),
    "by column": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
    "of another machine": np.arange(3, dtype=">f4"),
    "whole": np.array([1, 2], dtype=np.int64),
    "one": np.float64(3.5),
    "none": np.zeros((0, 3)),
    "names": ["a", "b"],
    "inner": OrderedDict(more=(1.0, None)),
}


@pytest.fixture
def path(tmp_path):
    return tmp_path / "clip.pkl"


@pytest.mark.parametrize("protocol", range(pickle.HIGHEST_PROTOCOL + 1))
@pytest.mark.parametrize("packed", [bytes, zlib.compress, gzip.compress])
def test_numbers_are_those_that_were_written(path, protocol, packed):
    path.write_bytes(packed(pickle.dumps(CONTENT, protocol=protocol)))
    found = read_pickle(path)
    assert found.keys() == CONTENT.keys()
    for key, value in CONTENT.items():
        if isinstance(value, np.ndarray):
            np.testing.assert_array_equal(found[key], value)
            assert found[key].shape == value.shape
    assert (found["fps"], found["one"], found["names"]) == (30, 3.5, ["a", "b"])
    assert found["inner"] == {"more": [1.0, None]}


class NumpyArrayWrapper:
    """As joblib's: what it holds, then the numbers' bytes behind it in the file."""

    __module__ = "joblib.numpy_pickle"


@pytest.mark.parametrize("alignment", [None, 16])
def test_arrays_of_joblib_are_behind_their_pickles(path, alignment, monkeypatch):
    values = np.arange(12, dtype=np.float32).reshape(4, 3)
    file = io.BytesIO()
    pickler = pickle._Pickler(file, protocol=4)
    monkeypatch.setattr(pickler, "save_global", _global(pickler), raising=False)
    pickler.write(pickle.PROTO + b"\x04")
    pickler.write(pickle.EMPTY_DICT)
    pickler.save("clip")
    pickler.write(pickle.GLOBAL + b"joblib.numpy_pickle\nNumpyArrayWrapper\n")
    pickler.write(pickle.EMPTY_TUPLE + pickle.NEWOBJ)
    state = {"subclass": np.ndarray, "shape": (4, 3), "order": "C", "dtype": values.dtype}
    if alignment:
        state["numpy_array_alignment_bytes"] = alignment
    pickler.save(state)
    pickler.write(pickle.BUILD)
    if alignment:
        padding = alignment - (file.tell() + 1) % alignment
        file.write(bytes([padding]) + b"\xff" * padding)
    file.write(values.tobytes())
    file.write(pickle.SETITEM + pickle.STOP)
    path.write_bytes(file.getvalue())
    np.testing.assert_array_equal(read_pickle(path)["clip"], values)


def _global(pickler):
    """Names as they are, without looking them up."""

    def save(obj, name=None):
        pickler.write(pickle.GLOBAL + f"{obj.__module__}\n{obj.__qualname__}\n".encode())

    return save


class Runs:
    """Runs a command where a pickle is opened without care."""

    def __init__(self, command):
        self.command = command

    def __reduce__(self):
        return os.system, (self.command,)


def test_nothing_is_run(path, tmp_path):
    mark = tmp_path / "ran"
    path.write_bytes(pickle.dumps({"a": Runs(f"touch {mark}")}))
    with pytest.raises(
        FileFormatError, match=r'holds "posix.system"; expected a pickle of numbers'
    ):
        read_pickle(path)
    assert not mark.exists()


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\x80\x04N",
        b"\x80\x04\x8c\x01",
        b"cnumpy\ndtype\n}\x8c\x08__init__Ns\x86b.",  # state for a class of ours
        pickle.dumps(np.arange(3.0))[:-20],
        pickle.dumps(np.array([None, 1])),
        pickle.dumps(np.zeros(2, dtype="M8[s]")),
        pickle.dumps({"a": {1, 2}}),
        pickle.dumps(1j),
    ],
)
def test_what_is_damaged_or_no_numbers_is_refused(path, content):
    path.write_bytes(content)
    with pytest.raises(FileFormatError, match="expected a pickle of numbers"):
        read_pickle(path)


def test_classes_are_as_they_were_after_a_hostile_one(path):
    path.write_bytes(b"cnumpy\nndarray\nN}\x8c\x0c__setstate__Nst\x94.")
    with pytest.raises(FileFormatError):
        read_pickle(path)
    test_numbers_are_those_that_were_written(path, 4, bytes)


def test_what_grows_as_it_is_read_is_refused(path, monkeypatch):
    grows = [0]
    for _ in range(15):
        grows = [grows] * 10
    path.write_bytes(pickle.dumps(grows))
    monkeypatch.setattr(pickles, "_MOST", 10_000)
    with pytest.raises(FileFormatError, match="too many lists"):
        read_pickle(path)
    path.write_bytes(zlib.compress(bytes(pickles.LARGEST + 10)))
    with pytest.raises(FileFormatError, match="more than 64 MB"):
        read_pickle(path)
