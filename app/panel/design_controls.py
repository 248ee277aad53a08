"""The controls for whole designs: examples to start from, files to open and to save."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import viser

from app.guard.validation import number, put
from app.page_template import accept_drops
from app.panel.html import note
from app.viser_private import take_upload
from llsrbm.formats import readable
from llsrbm.request.design import Design

_NO_EXAMPLE = "choose ..."
_RATE = "Rate of the file [1/s]"
_USUAL_RATE, _HIGHEST_RATE = 30, 1000


class DesignControls:
    """Upload, examples and download, in the container that is open.

    Attributes:
        open: the button that opens a file.
        save: the button that saves the design; there after `add_examples`.
    """

    save: viser.GuiButtonHandle

    def __init__(
        self,
        client: viser.ClientHandle,
        examples: Mapping[str, Design],
        choose_example: Callable[[Design], None],
        open_file: Callable[[str, bytes], None],
    ) -> None:
        """The button that opens files.

        Args:
            client: whose tab.
            examples: to choose from by their titles.
            choose_example: called with the one that was chosen.
            open_file: called with a name and content, whatever it is.

        The callbacks are called on viser's event loop and must return at once.
        """
        self._gui = client.gui
        self._examples = {design.title: design for design in examples.values()}
        self._choose_example = choose_example
        self.open = self._gui.add_upload_button(
            "Open",
            mime_type=",".join(_suffixes()),
            hint="A design, a plan, a simulation or another tool's motion; or drop it on the page",
        )
        self._note = self._gui.add_html("", visible=False)
        accept_drops(client)

        # Asynchronous, so that it runs on the event loop, in order.
        @self.open.on_upload
        async def _(event: viser.GuiEvent[Any]) -> None:
            file = take_upload(event.target)
            if file is not None:
                open_file(file.name, file.content)

    def add_examples(self) -> None:
        """Add examples and download to the container that is open."""
        gui = self._gui
        self._example = gui.add_dropdown("Example", (_NO_EXAMPLE, *self._examples))
        self._rate = gui.add_number(
            _RATE,
            _USUAL_RATE,
            min=1,
            max=_HIGHEST_RATE,
            step=1,
            visible=False,
            hint="For the next file that is opened and does not say its own",
        )
        self.save = gui.add_button(
            "Save design", hint="Everything asked for as one small file to open here again"
        )

        @self._example.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            # Without a client, it was `show` that set the value; a script may send any value.
            value = event.target.value
            if event.client_id is not None and isinstance(value, str) and value in self._examples:
                self._choose_example(self._examples[value])

    def read_rate(self) -> float:
        """Frames/s of files that do not say."""
        return number(_RATE, self._rate.value, (1, _HIGHEST_RATE), [])

    def show(self, title: str, text: str, *, rate: bool) -> None:
        """Draw what is known of the design.

        Args:
            title: of the design; the example with this title is shown as chosen.
            text: on the design, or on a file that was opened.
            rate: whether the rate of a file can be changed.
        """
        put(self._example, title if title in self._examples else _NO_EXAMPLE)
        self._note.content = note(text)
        self._note.visible = bool(text)
        self._rate.visible = rate


def _suffixes() -> list[str]:
    """Of the files that a browser shall offer to open."""
    motions = {each.suffix for each in readable() if each.suffix}
    return sorted({".json", ".zip"} | motions)
