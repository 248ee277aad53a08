"""The tabs of a server: sessions while they are connected, states for some minutes more.

A page that loses its connection, or is loaded anew, finds its state again by its token.
"""

import threading
import time
from collections.abc import Callable, Mapping

import viser

from app.tab.atlas import Atlases
from app.tab.session import Session
from app.tab.start.initial_plan import InitialPlans
from app.tab.state import TabState
from app.workers.pool import WorkerPool
from llsrbm.robots import RobotFile

KEPT = 600.0  # s for which the state of a tab without a connection is kept

_RELEASE = 1.0  # s for the session of a connection that is dead to end, when its page is back
_END = 5.0  # s for all sessions to end with the server


class Tabs:
    """Connected tabs and kept states.

    `connect` and `disconnect` are called on viser's event loop, in order; the rest from any thread.
    """

    def __init__(
        self,
        pool: WorkerPool,  # computes for all of them
        initial: InitialPlans,  # plans with which they begin
        robots: Mapping[str, RobotFile],  # name -> file of each robot to choose from
        atlases: Atlases,  # of sweeps to choose from
        *,
        # states that are kept: of all tabs when the network fails; one takes some megabytes
        most_kept: int,
        clock: Callable[[], float] = time.monotonic,  # s
    ) -> None:
        self._pool = pool
        self._initial = initial
        self._robots = robots
        self._atlases = atlases
        self._most_kept = most_kept
        self._clock = clock
        self._lock = threading.Lock()  # for the two below; nothing that lasts is done under it
        self._sessions: dict[int, Session] = {}
        self._kept: dict[str, tuple[float, TabState]] = {}  # token -> until when (s), what

    @property
    def sessions(self) -> tuple[Session, ...]:
        """Sessions of the tabs that are connected, or whose threads have not ended."""
        with self._lock:
            return tuple(self._sessions.values())

    async def connect(self, client: viser.ClientHandle) -> None:
        """Begin a session."""
        session = Session(
            client,
            self._pool,
            self._initial,
            self._robots,
            self._atlases,
            take_kept=self._take_kept,
            ended=self._session_ended,
        )
        with self._lock:
            self._sessions[client.client_id] = session
        session.start()

    async def disconnect(self, client: viser.ClientHandle) -> None:
        """End a session; its thread takes its leave by itself."""
        with self._lock:
            session = self._sessions.get(client.client_id)
        if session is not None:
            session.close()

    def close(self) -> None:
        """End all sessions; what does not end in time ends with the process."""
        sessions, until = self.sessions, time.monotonic() + _END
        for session in sessions:
            session.close()
        for session in sessions:
            session.join(max(0.0, until - time.monotonic()))

    # ---- called by the sessions' threads

    def _take_kept(self, token: str) -> TabState | None:
        """The state that a page left; of a connection that nobody has noticed to be dead, too."""
        with self._lock:
            same = [each for each in self._sessions.values() if each.token == token]
        for session in same:
            if not session.is_own_thread:
                session.close()
                session.join(_RELEASE)
        with self._lock:
            self._drop_old()
            _, state = self._kept.pop(token, (0.0, None))
            for session in same:
                # Busy with a robot, it ends later: its state as it is now goes on here.
                if not session.is_own_thread and session in self._sessions.values():
                    state, session.superseded = session.left, True
        return state

    def _session_ended(self, session: Session) -> None:
        with self._lock:
            token, state = session.token, None if session.superseded else session.left
            self._sessions = {k: v for k, v in self._sessions.items() if v is not session}
            if token is not None and state is not None:
                self._kept.pop(token, None)
                self._kept[token] = self._clock() + KEPT, state
            self._drop_old()

    def _drop_old(self) -> None:
        now = self._clock()
        self._kept = {token: kept for token, kept in self._kept.items() if kept[0] > now}
        while len(self._kept) > self._most_kept:
            del self._kept[next(iter(self._kept))]
