"""One tab's session: events in, effects out, and what has changed is drawn.

Two threads have to do with a tab:

- viser's event loop, one for all tabs, on which callbacks of controls and of the page run, and
  connections come and go. It only puts into `inbox`.
- The session's own thread, one for each tab. It alone has the state, reads and sets controls,
  draws, submits to the pool and loads robots. The pool passes results by putting into `inbox`.

A browser may skip values while a slider moves, so a callback only says what was done (`Act`); the
thread reads the controls as they stand then.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Mapping
from typing import Any

import viser

from app.link import AtlasClicked, ClipTaken, PageLink, PageReady
from app.panel.acts import Act
from app.panel.status import Status, Verdict
from app.picture.foothold_handles import FootholdMoved
from app.picture.landing_handles import HandleMoved
from app.tab.acts import Step, event_of, update
from app.tab.atlas import Atlases
from app.tab.effects import Effect, Notify, Outside, Queue, RobotLoaded, loaded
from app.tab.files import FileChosen
from app.tab.inbox import End, Inbox
from app.tab.planning.robot import draw_robot
from app.tab.rendering import Rendering
from app.tab.start.initial_plan import InitialPlans
from app.tab.start.opening import TabOpened, first_state, left, resume
from app.tab.state import TabState
from app.viser_private import run_javascript
from app.workers.opened_file import uploaded_design
from app.workers.pool import WorkerPool
from llsrbm.errors import InputError
from llsrbm.robots import RobotFile

# Until a tab begins without its page's scripts, which answer when they are shown, s.
_PAGE_ANSWERS = 1.5

_log = logging.getLogger(__name__)


class Session:
    """A tab's state and its thread."""

    def __init__(
        self,
        client: viser.ClientHandle,  # the tab
        pool: WorkerPool,  # plans and simulates for all tabs
        initial: InitialPlans,  # plans that are there from the beginning
        robots: Mapping[str, RobotFile],  # name -> file of each robot to choose from
        atlases: Atlases,  # of sweeps to choose from
        *,
        # gives the state that a page with this token left; called by the session's thread
        take_kept: Callable[[str], TabState | None] = lambda _: None,
        # called by the session's thread as the last thing it does
        ended: Callable[[Session], None] = lambda _: None,
    ) -> None:
        self._client = client
        self._pool = pool
        self._initial = initial
        self._atlases = atlases
        self._take_kept = take_kept
        self._ended = ended
        self._inbox = Inbox()
        self._thread = threading.Thread(
            target=self._run, name=f"session-{client.client_id}", daemon=True
        )
        # by which the page is known again when it comes back; None: unknown
        self.token: str | None = None
        self.superseded = False  # another session goes on with its state
        self.failed = False  # a defect has ended it
        self.state = first_state(robots, initial.note)
        self._outside: Outside | None = None
        self._rendering: Rendering | None = None

    @property
    def left(self) -> TabState | None:
        """The state to keep once its thread has ended; None of one that has led to a defect."""
        return left(self.state) if self.state.page and not self.failed else None

    @property
    def is_own_thread(self) -> bool:
        """Whether the caller is the session itself."""
        return threading.current_thread() is self._thread

    # ---- from any thread

    def start(self) -> None:
        """Build the page and begin to plan."""
        self._thread.start()

    def close(self) -> None:
        """The tab has gone, or the server ends; returns at once."""
        self._inbox.put(End.END)

    def join(self, limit: float) -> bool:
        """Wait for the thread's end, s at most; whether it has ended."""
        if self._thread.is_alive() and not self.is_own_thread:
            self._thread.join(limit)
        return not self._thread.is_alive()

    # ---- the thread

    def _run(self) -> None:
        try:
            if self._build():
                while self._step():
                    pass
        except Exception:  # noqa: BLE001  # whatever it is, the page says so
            self.failed = True
            _log.exception("the session of tab %d has failed", self._client.client_id)
            self._show_failure()
        finally:
            if self._outside is not None:
                for queue in Queue:
                    self._outside.forget(queue)
            self._ended(self)

    def _show_failure(self) -> None:
        """In place of controls that do nothing any more, a button that reloads the page."""
        gui = self._client.gui
        gui.reset()
        line = "by a defect of the designer. The terminal has the details."
        gui.add_html(Status(Verdict.FAILED, line).html)

        @gui.add_button("Reload").on_click
        async def _(_: viser.GuiEvent[Any]) -> None:
            run_javascript(self._client, "window.location.reload()")

    def _build(self) -> bool:
        """Draw what every tab begins with, then its own; False: it has gone meanwhile."""
        client, put = self._client, self._inbox.put
        link = PageLink(client, put)  # first: the page answers while the rest is built and sent
        self._outside = Outside(client, self._pool, link, self._inbox)
        self._rendering = Rendering(
            client,
            link,
            self.state,
            self._atlases,
            put=put,
            open_file=lambda name, content: put(FileChosen(name, content)),
        )
        name = self.state.design.jump.robot
        if self._initial.file is None and self._initial.plan(name) is not None:
            # Its meshes take longest to send.
            robot = loaded(name)
            if isinstance(robot, RobotLoaded):
                self._take(draw_robot(self.state, robot))
        self._rendering.draw(self.state)
        page = self._inbox.wait_for_page(_PAGE_ANSWERS)
        if self._inbox.ended:
            return False
        self._begin(page)
        return True

    def _begin(self, page: PageReady | None) -> None:
        if page is None or not self._resume(page):
            self._take(update(self.state, self._opened(page)))
        if page is not None:
            self._meet(page)

    def _resume(self, page: PageReady) -> bool:
        """Go on where the page was; False: nothing is known of it."""
        self.token = page.tab
        kept = None if page.tab is None else self._take_kept(page.tab)
        if kept is None:
            return False
        self._take(resume(kept, page, self.state.tickets))
        self._open_shared(page)
        return True

    def _opened(self, page: PageReady | None) -> TabOpened:
        complaints: list[str] = []
        design = None
        for text, name in (
            (page and page.shared, "the link"),
            (page and page.kept, "the design that this browser kept"),
        ):
            if text and design is None:
                try:
                    design = uploaded_design(name, text.encode(errors="replace"))
                except InputError as error:
                    complaints.append(str(error))
        plan = self._initial.plan(self.state.design.jump.robot)
        # A link was chosen for what it holds.
        file = None if page is not None and page.shared is not None else self._initial.file
        time, playing = (0.0, False) if page is None else (page.time, page.playing)
        return TabOpened(design, plan, file, tuple(complaints), time, playing)

    def _meet(self, page: PageReady) -> None:
        if page.missing:
            names = ", ".join(page.missing)
            body = f"Its viewer lacks {names}; expected that of viser {viser.__version__}."
            self._do(Notify("This page cannot play", body))
        self._take(update(self.state, page))

    def _step(self) -> bool:
        """Take what has happened, draw what has changed; False at the end."""
        assert self._rendering is not None
        drawn_first: list[Effect] = []
        for item in self._inbox.take():
            if item is End.END:
                return False
            event = self._event_of(item)
            if event is None:
                continue
            self.state, effects = update(self.state, event)
            drawn_first += self._do_now(effects)
        self._rendering.draw(self.state)
        for effect in drawn_first:
            self._do(effect)
        return True

    def _take(self, step: Step) -> None:
        assert self._rendering is not None
        self.state, effects = step
        later = self._do_now(effects)
        self._rendering.draw(self.state)
        for effect in later:
            self._do(effect)

    def _event_of(self, item: Any) -> Any:
        """The event that an item means; None: there is nothing to update."""
        assert self._rendering is not None
        assert self._outside is not None
        match item:
            case Act():
                return event_of(item, self.state, self._rendering.panel)
            case HandleMoved():
                return self._rendering.handles.read(item)
            case FootholdMoved():
                return self._rendering.footholds.read(item)
            case ClipTaken():
                self._outside.link.take(item)
                return None
            case PageReady():  # its address has got another design, or it was slow to answer
                self._greet_late(item)
                return None
            case AtlasClicked():
                return self._rendering.atlas.opened(item)
        return item

    def _greet_late(self, page: PageReady) -> None:
        if self.state.page:
            self._open_shared(page)
        elif not self._resume(page):
            # It has begun without the page's designs; a visitor may have gone on from there.
            untouched = not self.state.history.back and self._initial.file is None
            if page.shared is not None:
                self._open_shared(page)
            elif page.kept is not None and untouched:
                self._take(update(self.state, self._opened(page)))
        self._meet(page)

    def _open_shared(self, page: PageReady) -> None:
        if page.shared is not None:
            try:
                design = uploaded_design("the link", page.shared.encode(errors="replace"))
            except InputError as error:
                self._do(Notify("Not opened", str(error)))
            else:
                self._inbox.put(design)

    # ---- effects

    def _do_now(self, effects: tuple[Effect, ...]) -> list[Effect]:
        """Do what need not wait for the picture; the rest."""
        for effect in effects:
            if not effect.after_drawing:
                self._do(effect)
        return [effect for effect in effects if effect.after_drawing]

    def _do(self, effect: Effect) -> None:
        assert self._outside is not None
        effect.do(self._outside)
