"""The controls for whole designs: examples to start from, files to open and to save."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from html import escape
from typing import Any

import viser

from app.panel.validation import number, put
from app.viser_link.file_drop import accept_drops
from app.viser_link.uploads import take_upload
from llsrbm.design import Design
from llsrbm.formats import readable

_NO_EXAMPLE = "choose ..."
_RATE = "Rate of the file [1/s]"
_USUAL_RATE, _HIGHEST_RATE = 30, 1000


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
            on_upload: told a name and content, whatever it is: see `app.compute.opened_file`.
            on_save: told that the design is wanted as a file.

        The callbacks are called from viser's thread and must return at once.
        """
        self._examples = {design.title: design for design in examples.values()}
        gui = client.gui
        self._example = gui.add_dropdown("Example", (_NO_EXAMPLE, *self._examples))
        self._note = gui.add_html("", visible=False)
        self._open = gui.add_upload_button(
            "Open",
            mime_type=",".join(_suffixes()),
            hint="A design, a plan, a simulation or another tool's motion; or drop it on the page",
        )
        self._rate = gui.add_number(
            _RATE,
            _USUAL_RATE,
            min=1,
            max=_HIGHEST_RATE,
            step=1,
            visible=False,
            hint="For the next file that is opened and does not say its own",
        )
        self._save = gui.add_button(
            "Save design", hint="Everything asked for as one small file to open here again"
        )
        accept_drops(client)

        # Asynchronous, so that they run on the event loop, in order.
        @self._example.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            # Without a client, it was `show` that set the value; a script may send any value.
            value = event.target.value
            if event.client_id is not None and isinstance(value, str) and value in self._examples:
                on_example(self._examples[value])

        @self._open.on_upload
        async def _(event: viser.GuiEvent[Any]) -> None:
            # A script may send any value.
            file = take_upload(event.target)
            if file is not None:
                on_upload(file.name, file.content)

        @self._save.on_click
        async def _(event: viser.GuiEvent[Any]) -> None:
            if event.client_id is not None:
                on_save()

    def read_rate(self) -> float:
        """Frames/s of files that do not say."""
        return number(_RATE, self._rate.value, (1, _HIGHEST_RATE), [])

    def show_rate(self) -> None:
        """Let the rate be changed: a file came that does not say its own."""
        self._rate.visible = True

    def show(self, title: str, note: str = "") -> None:
        """Name the example that is shown, if its title is one's, and say what to look at."""
        put(self._example, title if title in self._examples else _NO_EXAMPLE)
        self.tell(note)

    def tell(self, note: str) -> None:
        """Say something about a file, or nothing."""
        self._note.content = f'<div style="{_NOTE_STYLE}">{escape(note)}</div>'
        self._note.visible = bool(note)


def _suffixes() -> list[str]:
    """Of the files that a browser shall offer to open."""
    motions = {each.suffix for each in readable() if each.suffix}
    return sorted({".json", ".zip"} | motions)


_NOTE_STYLE = "padding: 0 0.9em 0.5em; font-size: 0.85em; line-height: 1.35; opacity: 0.8"
