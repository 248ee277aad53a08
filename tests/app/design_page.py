"""A page of nothing but the design controls, which notes down what they tell."""

import contextlib
import queue

from app.guard.policy import Guard
from app.guard.token import Access
from app.page_template import page
from app.panel.file_controls import FileControls
from app.viser_private import DesignerServer


class DesignPage:
    """Attributes: port; told: what happened; clients, controls: by tab, in order of connection."""

    def __init__(self, guard=None):
        self.told = queue.Queue()
        self.tabs = queue.Queue()
        self.guard = guard or Guard(Access(None), (), loopback=True)
        self.server = DesignerServer("127.0.0.1", 0, self.guard, page)
        self.port = self.server.get_port()
        self.guard.access.port = self.port
        self.server.on_client_connect(self._connected)

    def next(self, timeout=20):
        return self.told.get(timeout=timeout)

    def _connected(self, client):
        slider = client.gui.add_slider("Twist [deg]", -180, 180, 1, 0)

        @slider.on_update
        async def _(event):
            self.told.put(("slider", event.target.value))

        controls = FileControls(
            client,
            lambda act: self.told.put((act.name.lower(),)),
            open_file=lambda name, content: self.told.put(("upload", name, content)),
        )
        controls.add_progress()
        controls.add_export()
        controls.add_tab()

        self.tabs.put((client, controls))


@contextlib.contextmanager
def design_page(guard=None):
    page = DesignPage(guard)
    try:
        yield page
    finally:
        page.server.stop()
