"""Replays of many motions in one folder: what they have in common is there once.

    FOLDER/NAME.html           a motion: how it moves, and what of its scene is its own
    FOLDER/shared/player.js    viser's client and our scripts
    FOLDER/shared/KEY.js       meshes of a robot

A page is taken apart as `app.replay` makes it, and put together again by static/shared_player.js
when it is opened, without a server: scripts beside a page on disk may be read, other files not.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import zstandard

from llsrbm.errors import Error

SHARED, PLAYER = "shared", "player.js"
_STATIC = Path(__file__).parent / "static"
_SCRIPT = re.compile(r"<script(?P<attributes>[^>]*)>(?P<text>.*?)</script>", re.DOTALL)
_DATA = re.compile(r'(data-[a-z]+)="([^"]*)"')  # viser's client is packed into such ones
_SCENE = re.compile(r'window\.__VISER_EMBED_DATA__="(?P<data>[^"]*)"')
_LARGE = 4000  # bytes of a mesh that other motions have, too
_KEY_LETTERS = 12
# Beside what a page in one file may do, it reads the scripts beside it.
_SCRIPTS_BESIDE = "script-src 'self' file: "


class SharedPages:
    """A folder of pages; each is added as `app.replay` makes it, as one file."""

    def __init__(self, folder: Path) -> None:
        """Make the folder and what is shared."""
        self._folder = folder
        (folder / SHARED).mkdir(parents=True, exist_ok=True)
        self._player = ""  # as it was written

    def add(self, name: str, page: str) -> None:
        """Write the page `NAME.html`. Raises `Error`: it is not built as replays are."""
        taken = _TakenApart.of(page)
        player = f"window.llsrbmScripts = {_json(taken.scripts)};\n"
        if player != self._player:
            if self._player:
                raise Error(f"{name}: its player is not that of the page before")
            own = (_STATIC / "shared_player.js").read_text("utf-8")
            (self._folder / SHARED / PLAYER).write_text(player + own, encoding="utf-8")
            self._player = player
        scene = _Scene.of(taken.scene)
        key = hashlib.sha256(scene.meshes).hexdigest()[:_KEY_LETTERS]
        meshes = self._folder / SHARED / f"{key}.js"
        if not meshes.exists():
            meshes.write_text(f'window.llsrbmMeshes = "{_packed(scene.meshes)}";\n', "utf-8")
        motion = {
            "facts": _packed(taken.facts.encode()),
            "own": _packed(scene.own),
            "pieces": scene.pieces,
        }
        scripts = (
            f"<script>window.llsrbmMotion = {_json(motion)};</script>"
            f'<script src="{SHARED}/{key}.js"></script>'
            f'<script src="{SHARED}/{PLAYER}"></script>'
        )
        text = taken.rest.replace("</body>", f"{scripts}</body>", 1)
        text = text.replace("script-src ", _SCRIPTS_BESIDE, 1)
        (self._folder / f"{name}.html").write_text(text, encoding="utf-8")


@dataclass(frozen=True)
class _TakenApart:
    """A page: its own facts and scene, its scripts in order, and the rest of it."""

    facts: str
    scene: str
    scripts: list[dict[str, Any]]
    rest: str

    @classmethod
    def of(cls, page: str) -> _TakenApart:
        facts, scene, scripts = "", "", []
        for found in _SCRIPT.finditer(page):
            attributes, text = found["attributes"], found["text"]
            if 'id="facts"' in attributes:
                facts = text
            elif embedded := _SCENE.match(text):
                scene = embedded["data"]
            else:
                scripts.append({"text": text, "attributes": dict(_DATA.findall(attributes))})
        if not facts or not scene:
            raise Error("a replay has no place for its motion; expected viser's page as it is")
        return cls(facts, scene, scripts, _SCRIPT.sub("", page))


@dataclass(frozen=True)
class _Scene:
    """viser's messages, packed, cut into what is a motion's own and meshes that others have, too.

    `pieces`: in order, one of each in turn: bytes of `own`, then where in `meshes` to go on.
    """

    own: bytes
    meshes: bytes
    pieces: list[tuple[int, int, int]]

    @classmethod
    def of(cls, embedded: str) -> _Scene:
        raw = base64.b64decode(embedded)
        size = int.from_bytes(raw[:8], "little")
        whole = zstandard.ZstdDecompressor().decompress(raw[8:], max_output_size=size)
        length = int.from_bytes(whole[:8], "little")
        messages = msgspec.msgpack.decode(whole[8 : 8 + length])["messages"]
        own, meshes, places = bytearray(), bytearray(), dict[bytes, int]()
        pieces, at = [], 0
        for mesh in _meshes(messages):
            start = whole.index(mesh, at)
            if mesh not in places:
                places[mesh] = len(meshes)
                meshes += mesh
            pieces.append((start - at, places[mesh], places[mesh] + len(mesh)))
            own += whole[at:start]
            at = start + len(mesh)
        pieces.append((len(whole) - at, 0, 0))
        return cls(bytes(own + whole[at:]), bytes(meshes), pieces)


def _meshes(value: object) -> Iterator[bytes]:
    """The large byte strings in plain data, in order."""
    if isinstance(value, bytes) and len(value) >= _LARGE:
        yield value
    elif isinstance(value, dict | list | tuple):
        for each in value.values() if isinstance(value, dict) else value:
            yield from _meshes(each)


def _packed(content: bytes) -> str:
    return base64.b64encode(gzip.compress(content, 9, mtime=0)).decode("ascii")


def _json(value: object) -> str:
    """JSON that may stand in a script's element: nothing in it ends the element."""
    return json.dumps(value, separators=(",", ":")).replace("<", "\\u003c")
