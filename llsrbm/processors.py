"""The part of the machine that this process may use."""

from __future__ import annotations

import os


def usable_processors() -> int:
    """Number of processors that this process may run on, which may be fewer than there are."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
