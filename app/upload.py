"""Designs that a browser sends: small, and of robots that the page has."""

from __future__ import annotations

import viser

from app.viser_private import run_javascript
from llsrbm import models
from llsrbm.design import LARGEST, Design, load_design
from llsrbm.errors import InputError
from llsrbm.robots import names

# A file that is too large to be a design is cut after the first byte too many, before viser's page
# reads it: nobody waits for 100 MB that will be refused.
_CUT_UPLOADS = f"""
if (!window.llsrbmCutsUploads) {{
  window.llsrbmCutsUploads = true;
  window.addEventListener("change", (event) => {{
    const input = event.target;
    const file = input instanceof HTMLInputElement && input.type === "file" && input.files[0];
    if (!file || file.size <= {LARGEST + 1}) return;
    const cut = new DataTransfer();
    cut.items.add(new File([file.slice(0, {LARGEST + 1})], file.name, {{ type: file.type }}));
    input.files = cut.files;
  }}, true);
}}
"""


def cut_uploads(client: viser.ClientHandle) -> None:
    """Have a tab send no more of a file than is needed to refuse it."""
    run_javascript(client, _CUT_UPLOADS)


def uploaded_design(name: str, content: bytes) -> Design:
    """The design in an uploaded file.

    Args:
        name: of the file, as the browser has it.
        content: of the file.

    Raises:
        InputError: it is no design, or one of a robot or model that is not on the page.
    """
    design = load_design(content, name=name)
    # A robot file's path works on the command line; a visitor shall not open files of this machine.
    for key, value, valid in (
        ("robot", design.jump.robot, names()),
        ("model", design.jump.model, models.names()),
    ):
        if value not in valid:
            raise InputError(
                f"{name}: jump.{key}: expected one of {', '.join(valid)}, got {value!r:.80}"
            )
    return design
