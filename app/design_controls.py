"""The controls for whole designs: examples to start from, files to open and to save."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from html import escape
from typing import Any

import viser

from app.checked import put
from app.upload import cut_uploads
from llsrbm.design import Design

_NO_EXAMPLE = "choose ..."


class DesignControls:
    """Examples, upload and download, added to the folder that is open."""

    def __init__(
        self,
        client: viser.ClientHandle,
        examples: Mapping[str, Design],
        *,
        on_example: Callable[[Design], None],
        on_upload: Callable[[str, bytes], None],
        on_save: Callable[[], None],
    ) -> None:
        """No example chosen.

        Args:
            client: whose tab.
            examples: to choose from by their titles.
            on_example: told which one was chosen.
            on_upload: told a file's name and content, whatever it is: see `app.upload`.
            on_save: told that the design is wanted as a file.

        The callbacks are called from viser's thread and must return at once.
        """
        self._examples = {design.title: design for design in examples.values()}
        gui = client.gui
        self._example = gui.add_dropdown("Example", (_NO_EXAMPLE, *self._examples))
        self._note = gui.add_html("", visible=False)
        self._open = gui.add_upload_button(
            "Open design", mime_type=".json,application/json", hint="A file saved with Save design"
        )
        self._save = gui.add_button(
            "Save design", hint="Everything asked for as one small file to open here again"
        )
        cut_uploads(client)

        # Asynchronous, so that they run on the event loop, in order.
        @self._example.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            # Without a client, it was `show` that set the value; a script may send any value.
            value = event.target.value
            if event.client_id is not None and isinstance(value, str) and value in self._examples:
                on_example(self._examples[value])

        @self._open.on_upload
        async def _(event: viser.GuiEvent[Any]) -> None:
            file = event.target.value
            if isinstance(file, viser.UploadedFile):
                on_upload(file.name, file.content)

        @self._save.on_click
        async def _(event: viser.GuiEvent[Any]) -> None:
            if event.client_id is not None:
                on_save()

    def show(self, title: str, note: str = "") -> None:
        """Name the example that is shown, if its title is one's, and say what to look at."""
        put(self._example, title if title in self._examples else _NO_EXAMPLE)
        self._note.content = f'<div style="{_NOTE_STYLE}">{escape(note)}</div>'
        self._note.visible = bool(note)


_NOTE_STYLE = "padding: 0 0.9em 0.5em; font-size: 0.85em; line-height: 1.35; opacity: 0.8"
