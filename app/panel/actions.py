"""A visitor's acts in the panel; values are read from it afterwards.

A browser may skip values while a slider moves, and callbacks come on viser's event loop, so that an
action only says which controls to read. The session's thread reads them as they stand then.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from enum import Enum, auto
from typing import Any

import viser


class Action(Enum):
    """An act."""

    JUMP = auto()  # its controls
    RESET_TUNING = auto()
    SCENARIO = auto()
    SIMULATE = auto()
    SEEDS = auto()
    COMPARE_REPLANNING = auto()
    COMPARE_MODEL = auto()
    WORST = auto()
    CANCEL = auto()
    NEAREST = auto()
    UNDO = auto()
    REDO = auto()
    SHARE = auto()
    VIEW = auto()
    ATLAS = auto()  # its controls
    PIN = auto()
    PIN_CHOSEN = auto()
    UNPIN = auto()
    TAKE_UP = auto()
    SAVE = auto()
    EXPORT = auto()
    STOP_EXPORT = auto()


Act = Callable[[Action], None]
"""Takes an action on viser's event loop; must return at once."""

_Callback = Callable[[viser.GuiEvent[Any]], Coroutine[Any, Any, None]]


def callback(act: Act, action: Action) -> _Callback:
    """A callback for a control.

    Asynchronous, so that it runs on the event loop as soon as the value is there, in order; viser
    would hand a plain function to one of 32 threads.
    """

    async def report(event: viser.GuiEvent[Any]) -> None:
        # Without a client, it was the panel itself that set the value.
        if event.client_id is not None:
            act(action)

    return report
