"""Messages that wait for a tab that does not read: bounded, and the tab closed if it takes none.

Two places grow: viser's queue of messages, which is not read while a message is on its way, and the
buffer of the socket. A closed tab reconnects and is sent the present state.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from app.guard.entry import Gate

if TYPE_CHECKING:
    from app.guard.connection import GuardedConnection

_PERIOD = 1.0  # s; a motion of 1 MB takes longer to be planned
_DEPTH = 4  # a message holds its properties, which hold arrays


async def watch(
    connection: GuardedConnection, queue: Callable[[], Any], gate: Gate, period: float = _PERIOD
) -> None:
    """Look after a tab for as long as it is open.

    Args:
        connection: its connection.
        queue: viser's queue of messages for it; None while there is none.
        gate: has the limits.
        period: s.
    """
    limits, transport = gate.limits, connection.transport
    size, taken_at = 0, connection.loop.time()
    while True:
        await asyncio.sleep(period)
        now = connection.loop.time()
        before, size = size, transport.get_write_buffer_size()
        taken_at = max(taken_at, connection.drained_at)
        if size == 0 or size < before:
            taken_at = now
        count, waiting = queued(queue())
        why = None
        if now - taken_at > limits.stalled_s:
            why = f"a tab took nothing for {limits.stalled_s:g} s; closed"
        elif size + waiting > limits.backlog_bytes or count > limits.backlog_messages:
            why = "too much waits for a tab; closed"
        if why is not None:
            gate.note(connection.peer, why)
            transport.abort()  # it would not read a farewell
            return


def queued(queue: Any) -> tuple[int, int]:
    """Messages that wait in a queue of viser's, and their bytes, about."""
    if queue is None or not queue.message_from_id:
        return 0, 0
    with queue.buffer_lock:
        messages = tuple(queue.message_from_id.values())
    return len(messages), sum(weight(vars(message)) for message in messages)


def weight(value: Any, depth: int = _DEPTH) -> int:
    """Bytes of what a message holds, without what Python adds."""
    if isinstance(value, (str, bytes, bytearray)):
        return len(value)
    if isinstance(value, np.ndarray):
        return int(value.nbytes)
    if depth == 0:
        return 0
    if isinstance(value, Mapping):
        return sum(weight(item, depth - 1) for item in value.values())
    if isinstance(value, (list, tuple)):
        return sum(weight(item, depth - 1) for item in value)
    return sum(weight(item, depth - 1) for item in getattr(value, "__dict__", {}).values())
