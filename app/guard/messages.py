"""Messages that make no sense: viser would fail at them, and all that was sent would be logged."""

from __future__ import annotations

import traceback
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import viser
from viser.infra import Message, WebsockMessageHandler

from app.guard.entry import Gate

_VISER = str(Path(viser.__file__).parent)

# A tab may close while a frame is under way; the session ends a moment later.
warnings.filterwarnings("ignore", message="Queued a .* on a closed connection")
# What is said of a message's shape repeats all of it, up to a megabyte.
warnings.filterwarnings("ignore", message=r"\[viser\] .* does not match annotation")


def ignore_nonsense(
    handler: WebsockMessageHandler, gate: Gate, peer_of: Callable[[int], str]
) -> None:
    """Note down once where viser fails at a message; asyncio would print all that was sent.

    Args:
        handler: viser's, of one tab or of all.
        gate: keeps the record.
        peer_of: address behind a client's number.
    """
    handle = handler._handle_incoming_message

    async def handle_briefly(client_id: Any, message: Message) -> None:
        try:
            await handle(client_id, message)
        except Exception as error:
            kind, failure = type(message).__name__, type(error).__name__
            frames = traceback.extract_tb(error.__traceback__)[1:]
            if all(frame.filename.startswith(_VISER) for frame in frames):
                reason = f"a tab sent a {kind} that makes no sense ({failure}); ignored"
                gate.note(peer_of(client_id), reason)
            elif gate.note("", f"{kind} ran into a defect ({failure})"):
                raise  # logged in full once

    handler._handle_incoming_message = handle_briefly  # type: ignore[method-assign]


def is_bad_message(error: Exception) -> bool:
    """Whether a connection ended because what arrived on it is no message of viser's."""
    return any(
        frame.name == "_message_consumer" for frame in traceback.extract_tb(error.__traceback__)
    )
