"""The page's side of opening files: dropped anywhere, and none sent that is too large."""

from __future__ import annotations

from pathlib import Path

import viser

from app.guard.limits import MAX_UPLOAD
from app.viser_private import run_javascript

_SCRIPT = Path(__file__).parent / "static" / "file_drop.js"


def accept_drops(client: viser.ClientHandle) -> None:
    """Have a tab open what is dropped on it through its upload button, the only one."""
    script = _SCRIPT.read_text(encoding="utf-8")
    run_javascript(client, f"window.llsrbmLargestFile = {MAX_UPLOAD};\n{script}")
