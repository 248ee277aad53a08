"""What a file that is no native one seems to be, and what may be done with it instead."""

from __future__ import annotations

import re
from codecs import getincrementaldecoder

NATIVE = "expected an npz file that `--out`, `Plan.save` or `Rollout.save` wrote"
LOOKED_AT = 4096  # bytes at a file's beginning that tell

_ROBOT_FILE = re.compile(r"^\s*\[(urdf|legs|posture)\]\s*(#.*)?$", re.MULTILINE)


def seems(head: bytes) -> str:
    """A phrase for a file that begins so, with a hint at the command that takes it."""
    if not head:
        return "an empty file"
    if head.startswith(b"PK"):
        return "a zip archive that is cut short or damaged"
    if head.startswith(b"\x93NUMPY"):
        return "a single NumPy array (.npy)"
    if head[:1] == b"\x80" and head[1:2] in (b"\x02", b"\x03", b"\x04", b"\x05"):
        return "a Python pickle, which is never opened: it could run anything"
    return _seems_text(head)


def _seems_text(head: bytes) -> str:
    try:
        text = getincrementaldecoder("utf-8")().decode(head)  # which may end within a letter
    except UnicodeDecodeError:
        return "of no kind that is known here"
    if "\0" in text:
        return "of no kind that is known here"
    if '"llsrbm.design/' in text:
        return "a design, of which `llsrbm plan --design FILE --out PLAN.npz` makes a plan"
    if text.startswith("time [s]"):
        return (
            "a table that `llsrbm export --format csv` wrote; tables cannot be read back, export "
            "from the npz file again"
        )
    if _ROBOT_FILE.search(text):
        return "a robot file, which `llsrbm plan --robot FILE` takes"
    if text.lstrip().startswith(("{", "[")):
        return "a JSON file"
    return "a text file"
