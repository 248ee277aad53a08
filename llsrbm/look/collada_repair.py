"""Collada files whose textures refer to a surface that does not exist, made readable.

Blender wrote such files for a while: a sampler names "image_001-surface" where the surface beside
it is called "image-surface". pycollada then drops the material and everything drawn with it
(ANYmal B would stand without shanks).
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

_SURFACE = re.compile(r'<newparam\s+sid="([^"]+)">\s*<surface\b')
_SAMPLER = re.compile(r"(<sampler2D>\s*<source>)([^<]+)(</source>)")
_IMAGES = frozenset({".jpg", ".jpeg", ".png", ".tga", ".bmp"})


def readable(path: Path, scratch: Path) -> Path:
    """The file itself, or a repaired copy of it with its textures in a folder below `scratch`."""
    if path.suffix.lower() != ".dae":
        return path
    text = path.read_text(encoding="utf-8", errors="replace")
    surfaces = [(match.start(), match.group(1)) for match in _SURFACE.finditer(text)]
    names = {name for _, name in surfaces}

    def mended(match: re.Match[str]) -> str:
        before = [name for start, name in surfaces if start < match.start()]
        if match.group(2).strip() in names or not before:
            return match.group(0)
        return f"{match.group(1)}{before[-1]}{match.group(3)}"

    repaired = _SAMPLER.sub(mended, text)
    if repaired == text:
        return path
    folder = scratch / f"{path.stem}-{len(list(scratch.iterdir()))}"
    folder.mkdir()
    for image in path.parent.iterdir():
        if image.suffix.lower() in _IMAGES:
            shutil.copy(image, folder)
    (folder / path.name).write_text(repaired, encoding="utf-8")
    return folder / path.name
