"""The last design, kept by the browser, so that a reload shows it again."""

from __future__ import annotations

import viser

from app.compute.offered import uploaded_design
from llsrbm.design import Design, dump_design
from llsrbm.errors import InputError

_KEY = "llsrbm.design"
_NAME = "the design that this browser kept"


def remember(client: viser.ClientHandle, design: Design) -> None:
    """Have the browser keep a design in place of the one before; less than 1 kB goes to the tab.

    A browser that keeps nothing says nothing.
    """
    client.local_storage.set_item(_KEY, dump_design(design))


def recall(client: viser.ClientHandle, timeout: float, complaints: list[str]) -> Design | None:
    """The design that the browser kept, or None; blocks, so it is nothing for viser's threads.

    Args:
        client: the tab.
        timeout: s to wait for its answer at most.
        complaints: gets a line where something was kept that is no design of this page.
    """
    try:
        kept = client.local_storage.get_item(_KEY, timeout=timeout)
    except (RuntimeError, TimeoutError):  # it forbids it, has gone, or does not answer
        return None
    if not isinstance(kept, str):  # nothing, or whatever a script sent
        return None
    try:
        return uploaded_design(_NAME, kept.encode(errors="replace"))
    except InputError as error:
        complaints.append(str(error))
        return None
