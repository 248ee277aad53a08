"""Files as nobody should send them: made by chance from good ones, the same for the same seed."""

from __future__ import annotations

import copy
import io
import json
import random
import tempfile
import zipfile
from pathlib import Path

import numpy as np

from llsrbm.ocp.horizon import Iterate
from llsrbm.request.design import Design, dump_design
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout

JUMP = Jump(robot="anymal", twist=1.2, forward=0.1, height=0.1)

ODD = (
    None, True, 0, -1, 1e308, -1e308, 1e-308, 2**70, "", "x" * 5000, "/etc/passwd", "../../x.toml",
    "/dev/zero", "anymal", "nosuch", "\x00", "NaN", "Infinity", [], {}, [[[]]], {"a": {"b": []}},
)  # fmt: skip
NUMBERS = (0.0, -1.0, 1e308, -1e308, 1e-308, 1e6, np.nan, np.inf, -np.inf)
DTYPES = ("f2", "f4", "u1", "i8", "c16", "?", "U3", "S3", "M8[s]", ">f8")


class Damaged:
    """Attributes: good, (name, content) of what is damaged."""

    def __init__(self):
        plan = synthetic_plan(JUMP)
        object.__setattr__(plan, "solution", Iterate(np.arange(9.0), np.arange(5.0)))
        rollout = synthetic_rollout(plan)
        with tempfile.TemporaryDirectory() as folder:
            self.good = []
            for name, trajectory in (("plan.npz", plan), ("rollout.npz", rollout)):
                trajectory.save(Path(folder) / name)
                self.good.append((name, (Path(folder) / name).read_bytes()))
        design = Design(JUMP, Tuning(limits={"friction": 0.4}), Scenario(seed=7), "title", "note")
        self.good.append(("mine.jump.json", dump_design(design).encode()))
        rows = np.tile(np.arange(19.0), (40, 1))
        table = "\n".join(",".join(map(str, row)) for row in rows)
        self.good.append(("table.csv", table.encode()))
        self._arrays = [_arrays(content) for _, content in self.good[:2]]

    def file(self, seed):
        """(name, content)."""
        rng = random.Random(seed)
        way = rng.choice(
            (self._bytes, self._array, self._array, self._meta, self._meta, self._keys, self._json,
             self._zip)
        )  # fmt: skip
        return way(rng)

    def _bytes(self, rng):
        name, content = rng.choice(self.good)
        content = bytearray(content)
        match rng.randrange(5):
            case 0:
                del content[rng.randrange(len(content)) :]
            case 1:
                for _ in range(rng.choice((1, 1, 3, 30, 300))):
                    content[rng.randrange(len(content))] = rng.randrange(256)
            case 2:
                at = rng.randrange(len(content))
                content[at:at] = rng.randbytes(rng.choice((1, 10, 1000)))
            case 3:
                content = rng.randbytes(rng.choice((0, 1, 4, 100, 10_000)))
                content = rng.choice((b"", b"PK\x03\x04", b"{", b"\x93NUMPY\x01\x00")) + content
            case 4:
                start, end = sorted(rng.randrange(len(content)) for _ in range(2))
                del content[start:end]
        other = rng.choice(
            (name, name, "a.npz", "a.json", "a.csv", "a.jump.json", "a", "\n/../a.npz")
        )
        return other, bytes(content)

    def _array(self, rng):
        arrays = dict(rng.choice(self._arrays))
        for _ in range(rng.choice((1, 1, 2))):
            key = rng.choice([key for key in arrays if "meta" not in key and "schema" not in key])
            arrays[key] = _changed(arrays[key], rng)
        return "array.npz", _npz(arrays)

    def _meta(self, rng):
        arrays = dict(rng.choice(self._arrays))
        key = rng.choice([key for key in arrays if key.endswith("meta")])
        meta = json.loads(str(arrays[key]))
        for _ in range(rng.choice((1, 1, 2, 5))):
            _change_somewhere(meta, rng)
        arrays[key] = np.array(json.dumps(meta))
        return "meta.npz", _npz(arrays)

    def _keys(self, rng):
        arrays = dict(rng.choice(self._arrays))
        keys = list(arrays)
        match rng.randrange(5):
            case 0:
                del arrays[rng.choice(keys)]
            case 1:
                a, b = rng.choice(keys), rng.choice(keys)
                arrays[a], arrays[b] = arrays[b], arrays[a]
            case 2:
                key = rng.choice([key for key in keys if key.endswith("schema")])
                arrays[key] = np.array(
                    rng.choice(
                        ("", "llsrbm.plan/1", "llsrbm.plan/2", "llsrbm.rollout/1", "x" * 999)
                    )
                )
            case 3:
                arrays[rng.choice(keys)] = np.array([{"pickled": 1}], dtype=object)
            case 4:
                arrays = {key: a for key, a in arrays.items() if rng.random() < 0.7}
        return "keys.npz", _npz(arrays)

    def _json(self, rng):
        table = json.loads(self.good[2][1])
        for _ in range(rng.choice((1, 2, 5))):
            _change_somewhere(table, rng)
        text = json.dumps(table)
        if rng.random() < 0.1:
            text = "[" * 100_000
        if rng.random() < 0.1:
            text = json.dumps({"LoopMode": "Wrap", "FrameDuration": 0.01, "Frames": table})
        return rng.choice(("a.json", "a.jump.json")), text.encode()

    def _zip(self, rng):
        """Archives that are not as they say, and very large ones."""
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w", rng.choice((0, 8, 12, 14))) as archive:
            match rng.randrange(4):
                case 0:
                    archive.writestr("schema.npy", bytes(rng.choice((0, 1000, 90_000_000))))
                case 1:
                    archive.writestr("schema.npy", _npy(np.array("llsrbm.rollout/1")))
                    archive.writestr("time.npy", _npy(np.zeros(0))[:-8] + rng.randbytes(80))
                case 2:
                    for _ in range(2000):
                        archive.writestr(f"{rng.random()}.npy", b"")
                case 3:
                    for name, content in self.good:
                        archive.writestr(f"../{name}", content)
        return "zip.npz", buffer.getvalue()


def _arrays(content):
    with np.load(io.BytesIO(content)) as archive:
        return {key: archive[key] for key in archive.files}


def _npz(arrays):
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def _npy(array):
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def _changed(array, rng):
    array = array.copy()
    match rng.randrange(8):
        case 0 if array.dtype.kind == "f" and array.size:
            array.flat[rng.randrange(array.size)] = rng.choice(NUMBERS)
        case 1 if array.dtype.kind == "f":
            array[...] = rng.choice(NUMBERS)
        case 2 if array.dtype.kind == "f":
            array = array * rng.choice((-1.0, 0.0, 1e3, 1e9, 1e-9))
        case 3 if array.ndim:
            array = array[: rng.randrange(len(array) + 1)]
        case 4 if array.ndim:
            array = np.concatenate([array, array])
        case 5:
            array = np.zeros((rng.choice((0, 1, 2, 5_000_000)),), dtype="u1")
        case 6:
            array = array.T[..., None]
        case 7 if array.dtype.kind in "fi":
            with np.errstate(all="ignore"):
                array = array.astype(rng.choice(DTYPES))
    return array


def _change_somewhere(table, rng):
    """Put an odd value at a random place of nested dictionaries and lists, or take one away."""
    place = table
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        if not keys:
            return
        key = rng.choice(keys)
        inner = place[key]
        if isinstance(inner, dict | list) and inner and rng.random() < 0.8:
            place = inner
            continue
        if isinstance(place, dict) and rng.random() < 0.2:
            del place[key]
        else:
            place[key] = copy.deepcopy(rng.choice(ODD))
        return
