"""Damaged and hostile native files, by the thousand: each from a seed, by one kind of damage."""

import io
import json
import os
import pickle
import struct
import warnings
import zipfile
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from llsrbm.analysis.figures import figures_of_plan, figures_of_rollout
from llsrbm.analysis.summaries import plan_summary
from llsrbm.analysis.wording import plan_rows
from llsrbm.errors import Error, FileFormatError, InputError
from llsrbm.formats import export
from llsrbm.look.timeline import timeline
from llsrbm.look.titles import title_of
from llsrbm.motion.plan import Plan
from llsrbm.motion.sampling import resample
from llsrbm.motion.trajectory import description, load
from llsrbm.motion.whole_body import whole_body_motion
from llsrbm.request.design import Design, dump_design, load_design
from llsrbm.request.jump import Jump
from tests.llsrbm.synthetic import TWO_HOPS, TWO_HOPS_DURATIONS, synthetic_plan
from tests.llsrbm.synthetic_rollout import followed, synthetic_rollout

Rng = np.random.Generator


class Seeds:
    """Sound files to damage: a plan, one without loads, a rollout, one of two hops."""

    def __init__(self, folder: Path) -> None:
        self.canary = folder / "canary"
        plan, rollout = synthetic_plan(intervals=3), synthetic_rollout(seed=3)
        plan.save(folder / "plan.npz")
        resample(rollout, rollout.time[::50]).save(folder / "rollout.npz")
        none = dict.fromkeys(("joint_velocity", "joint_torque", "joint_torque_limit"))
        replace(plan, **none).save(folder / "loose.npz")
        self.arrays = []
        hops = followed(
            synthetic_plan(intervals=2, schedule=TWO_HOPS, durations=TWO_HOPS_DURATIONS)
        )
        resample(hops, hops.time[::25]).save(folder / "hops.npz")
        for name in ("plan", "loose", "rollout", "hops"):
            with np.load(folder / f"{name}.npz") as archive:
                self.arrays.append(dict(archive))
        self.files = [packed(arrays) for arrays in self.arrays]

    def file(self, rng: Rng) -> bytes:
        return pick(rng, self.files)

    def some(self, rng: Rng) -> dict[str, np.ndarray]:
        return dict(pick(rng, self.arrays))


def pick(rng, options):
    return options[int(rng.integers(len(options)))]


def packed(arrays, **changes):
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **{**arrays, **changes})
    return buffer.getvalue()


def zipped(members, compression=zipfile.ZIP_STORED):
    """An archive of (name, content), with the right checksums."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", compression) as archive:
        for name, content in members:
            archive.writestr(name, content)
    return buffer.getvalue()


def npy(array):
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def members_of(content):
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        return [(name, archive.read(name)) for name in archive.namelist()]


# ---- kinds of damage: (seeds, rng) -> content


def flipped(seeds, rng):
    """Bytes anywhere."""
    content = bytearray(seeds.file(rng))
    for _ in range(rng.integers(1, 6)):
        content[rng.integers(len(content))] = rng.integers(256)
    return bytes(content)


def cut(seeds, rng):
    """Shorter: an end, a beginning or a piece in the middle is missing; or something is added."""
    content = seeds.file(rng)
    a, b = sorted(rng.integers(0, len(content), 2))
    whole = content + rng.bytes(30)
    return pick(rng, [content[:a], content[a:], content[:a] + content[b:], whole, content[:64]])


_PIECES = (
    "[('a', '<f8')]",
    *"()'\"\\#{}[,L\n\t\r\0\x0cé",
    *("'''", "\\x", "0x", "1e9", "-1", "0o", "07", "1_0", "True", "None", "u''", "b'x'"),
    *("[" * 300, "(" * 3000, "-" * 500, "9" * 5000, "9" * 20, "  \n ", "<M8[ns]"),
    *("|O", "|V8", "<f16", ">f8", "__import__('os')", "'<f8', 'extra': 1", "<U0", "<U999999999"),
)


def header_text(seeds, rng):
    """The text that describes an array, with checksums that fit."""
    members = members_of(seeds.file(rng))
    index = int(rng.integers(len(members)))
    name, content = members[index]
    length = int.from_bytes(content[8:10], "little")
    header = content[10 : 10 + length].decode("latin-1")
    for _ in range(rng.integers(1, 4)):
        a = int(rng.integers(len(header)))
        b = a + int(rng.integers(0, 9))
        piece = pick(rng, [*_PIECES, chr(int(rng.integers(1, 256))), header[a:b] * 2])
        header = header[:a] + piece + header[b:]
    raw = header.encode("latin-1", "replace")[:65535]
    if rng.random() < 0.8:
        length = len(raw)
    version = pick(rng, [b"\1\0", b"\1\0", b"\2\0", b"\3\0", b"\4\0"])
    size = struct.pack("<H" if version == b"\1\0" else "<L", length)
    members[index] = name, b"\x93NUMPY" + version + size + raw + content[10 + length :]
    return zipped(members)


def other_values(rng, array):
    """The same shape, other numbers or letters."""
    changed = np.array(array)
    if changed.dtype.kind == "U":
        names = changed.reshape(-1)
        if not names.size:
            return changed
        names[int(rng.integers(names.size))] = pick(rng, ["", "é\n\x1b[31m", names[0], "x" * 300])
        return names.reshape(array.shape)
    if changed.dtype.kind not in "fiu":
        return changed
    numbers = changed.reshape(-1)
    special = [0, -1, 1, 2, 1e-320, 1e9, 1e18]
    if changed.dtype.kind == "f":
        special += [np.nan, np.inf, -np.inf, 1e29, -1e30, 1e38, 1e154, 1e308, 0.5, 1e-12]
    with np.errstate(all="ignore"):
        for _ in range(pick(rng, [0, 1, 1, 3]) if numbers.size else 0):
            numbers[int(rng.integers(numbers.size))] = pick(rng, special)
        if rng.random() < 0.5:
            factors = [0, -1, 1e-300, 1e-12, 1 + 1e-6, 1e6, 1e25, 1e200]
            numbers[:] = numbers * pick(rng, factors)
    return numbers.reshape(array.shape)


def other_arrays(seeds, rng):
    """Arrays of another type, shape or other values."""
    arrays = seeds.some(rng)
    for _ in range(pick(rng, [1, 1, 1, 2])):
        key = pick(rng, [key for key in arrays if key not in ("meta", "schema")])
        value = np.asarray(arrays[key])
        choice = int(rng.integers(9))
        with np.errstate(all="ignore"):
            if choice < 4:
                value = other_values(rng, value)
            elif choice == 4:
                types = ["f2", ">f8", "f4", "i1", "u8", "?", "c16", "S8", "U3", "g", "M8[s]", "i8"]
                kind = pick(rng, types)
                value = np.zeros(value.shape, kind) if rng.random() < 0.5 else cast(value, kind)
            elif choice == 5:
                sizes = [int(rng.integers(0, 4)) if rng.random() < 0.4 else n for n in value.shape]
                value = np.zeros(sizes, value.dtype)
            elif choice == 6:
                value = pick(
                    rng, [value[None], value.reshape(-1), np.asfortranarray(value), value.T]
                )
            elif choice == 7 and value.ndim:
                axis = int(rng.integers(value.ndim))
                value = np.repeat(value, pick(rng, [0, 2, 3]), axis=axis)
            else:
                numbers = [np.array(1.0), np.zeros(0), np.zeros((0, 7)), np.zeros((1,) * 9)]
                texts = [np.array("text"), np.array(["\ud800"]), np.full(value.shape, "a" * 40)]
                value = pick(rng, [*numbers, *texts, np.zeros(3, [("a", "f8"), ("b", "i4")])])
        arrays[key] = value
    if rng.random() < 0.1:
        arrays.pop(pick(rng, list(arrays)))
    return packed(arrays)


def cast(value, kind):
    try:
        return value.astype(kind)
    except (ValueError, TypeError):
        return np.zeros(value.shape, kind)


JSON_VALUES = (
    *("null", "true", "-1", "0", "1e400", "1e-320", "NaN", "-Infinity", "[]", "{}", "[[]]"),
    *("9" * 400, "9" * 5000, '"text"', '"' + "x" * 3000 + '"', '"\\ud800"', '"NaN"'),
    *('"\\u0000\\n\\u001b[2J"', "[" * 100 + "]" * 100, "[" * 3000 + "]" * 3000, "[1, 2]"),
    *(
        '{"a": ' * 150 + "1" + "}" * 150,
        '{"a": 1, "a": 2}',
        '"/etc/passwd"',
        '"/dev/zero"',
        f"{2**64 + 1}",
    ),
)


def other_meta(seeds, rng):
    """The JSON at `meta`: other values of any kind anywhere, keys left out, text damaged."""
    arrays = seeds.some(rng)
    meta = json.loads(str(arrays["meta"]))
    holes = {}
    for _ in range(pick(rng, [1, 1, 1, 2, 3])):
        table = meta
        while True:
            if isinstance(table, list):
                keys = range(len(table))
            else:
                keys = [key for key in table if key not in holes]
            if not keys:
                break
            key = pick(rng, list(keys))
            if isinstance(table[key], dict | list) and table[key] and rng.random() < 0.7:
                table = table[key]
                continue
            if rng.random() < 0.15 and isinstance(table, dict):
                del table[key]
            else:
                mark = f"hole {len(holes)}"
                holes[mark] = pick(rng, JSON_VALUES)
                table[key] = mark
            break
    text = json.dumps(meta)
    for mark, value in holes.items():
        text = text.replace(f'"{mark}"', value)
    if rng.random() < 0.1:
        at = int(rng.integers(len(text)))
        text = text[:at] + pick(rng, ["", "{", '"', "\0", "\ud800", text]) + text[at + 1 :]
    if rng.random() < 0.05:
        return packed(
            arrays, schema=np.array(pick(rng, ["llsrbm.plan/9", "llsrbm.rollout/77", "x"]))
        )
    return packed(arrays, meta=np.array(text))


class Payload:
    """Runs when it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.mkdir, (str(self.path),)


def pickled(seeds, rng):
    """What would leave a canary behind if anything unpickled it."""
    payload = Payload(seeds.canary)
    arrays = seeds.some(rng)
    objects = np.array([payload, None], dtype=object)
    key = pick(rng, [*arrays, "novelty"])
    choice = int(rng.integers(4))
    if choice == 0:
        return packed(arrays, **{key: objects})
    if choice == 1:
        return pickle.dumps(pick(rng, [payload, {"com": payload}]), int(rng.integers(0, 6)))
    if choice == 2:
        return npy(objects)
    members = [(name, c) for name, c in members_of(packed(arrays)) if name != f"{key}.npy"]
    name = pick(rng, [f"{key}.npy", key, f"{key}.pkl"])
    return zipped([*members, (name, pickle.dumps(payload))])


def archives(seeds, rng):
    """Archives that lie about sizes, names and what is in them, or hold far too much."""
    content = seeds.file(rng)
    members = members_of(content)
    index = int(rng.integers(len(members)))
    name, array = members[index]
    choice = int(rng.integers(9))
    if choice == 0:  # twice, with other numbers
        return zipped([*members, (name, array[:-8] + bytes(8))])
    if choice == 1:
        unusual = [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA, zipfile.ZIP_DEFLATED]
        return zipped(members, pick(rng, unusual))
    if choice == 2:  # sizes in local header and directory
        damaged = bytearray(zipped(members, zipfile.ZIP_DEFLATED))
        at, offset = pick(rng, [(b"PK\1\2", 24), (b"PK\1\2", 20), (b"PK\3\4", 22), (b"PK\3\4", 18)])
        place = damaged.find(at) + offset
        damaged[place : place + 4] = struct.pack("<L", pick(rng, [0, 1, 5000, 2**31, 2**32 - 1]))
        return bytes(damaged)
    if choice == 3:  # more than it says
        bomb = bytearray(zipped([*members, ("x.npy", bytes(60_000_000))], zipfile.ZIP_DEFLATED))
        place = bomb.rfind(b"PK\1\2") + 24
        bomb[place : place + 4] = struct.pack("<L", 200)
        return bytes(bomb)
    if choice == 4:
        strange = ["../x.npy", "/etc/x.npy", "a\\b.npy", "x" * 60000 + ".npy", "é\n.npy", "x/"]
        return zipped([*members, (pick(rng, strange), pick(rng, [array, b"", content]))])
    if choice == 5:
        return zipped([("plan.npz", content)])
    if choice == 6:
        return zipped([(f"{i}.npy", b"") for i in range(2000)] + members)
    if choice == 7:  # encrypted, as it says
        damaged = bytearray(content)
        for signature, offset in ((b"PK\1\2", 8), (b"PK\3\4", 6)):
            damaged[damaged.find(signature) + offset] |= 1
        return bytes(damaged)
    # An array that says that it is huge.
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {(10**6, 10**6)}, }}\n"
    huge = b"\x93NUMPY\1\0" + struct.pack("<H", len(header)) + header.encode() + array[-64:]
    return zipped([(n, huge if n == name else c) for n, c in members])


DAMAGE: dict[str, Callable[[Seeds, Rng], bytes]] = {
    each.__name__: each
    for each in (*(flipped, cut, header_text, other_arrays), *(other_meta, pickled, archives))
}


def use(trajectory, folder: Path) -> None:
    """What is done with a file that opens; raises whatever goes wrong."""
    if isinstance(trajectory, Plan):
        timeline(trajectory)
        figures_of_plan(trajectory)
        plan_summary(trajectory)
        plan_rows(trajectory)
        title_of(trajectory.jump, trajectory.tuning)
    else:
        timeline(trajectory.plan, trajectory)
        figures_of_rollout(trajectory)
        title_of(trajectory.jump, None, trajectory.scenario)
    with suppress(InputError):  # no such robot, or other joints
        whole_body_motion(trajectory, 5.0, 0.2)
    json.dumps(description(trajectory), allow_nan=False).encode()
    export(trajectory, folder / "again.npz")
    export(trajectory, folder / "again.csv", format="csv", fps=5.0)


# ---- what becomes of a file

SOUND = ("refused", "opened", "opened, not used")


def outcome(path, canary, folder):
    """In one word what happened to a file."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            trajectory = load(path)
    except FileFormatError as error:
        return "refused" if one_line(error) else f"refused in a message like this: {error!r}"
    if canary.exists():
        return "RAN CODE"
    try:
        with np.errstate(all="ignore"):
            use(trajectory, folder)
    except Error as error:
        return "opened, not used" if one_line(error) else f"a message like this: {error!r}"
    return "opened"


def outcome_of_design(content):
    try:
        load_design(content)
    except FileFormatError as error:
        return "refused" if one_line(error) else f"refused in a message like this: {error!r}"
    return "opened"


def one_line(error):
    said = str(error)
    return said.isprintable() and len(said) < 1500


def damaged_design(rng):
    """A design's file with other values, other bytes or less of it."""
    text = dump_design(Design(Jump(twist=1.0, forward=0.1)))
    for _ in range(rng.integers(1, 4)):
        a = int(rng.integers(len(text)))
        b = a + int(rng.integers(0, 12))
        text = text[:a] + pick(rng, [*JSON_VALUES, "", "{", '"', ":", text[a:b] * 2]) + text[b:]
    content = bytearray(text.encode("utf-8", "surrogatepass"))
    if rng.random() < 0.3:
        content[rng.integers(len(content))] = rng.integers(256)
    return bytes(content[: rng.integers(len(content))] if rng.random() < 0.2 else content)
