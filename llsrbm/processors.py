"""Number of processors that this process may use."""

import math
import os
from contextlib import suppress
from pathlib import Path

_QUOTA = Path("/sys/fs/cgroup/cpu.max")  # of a container: microseconds in each period, or "max"


def usable_processors() -> int:
    """At least 1: those that the system, `taskset` and a container's quota leave to it."""
    count = os.cpu_count() or 1
    if hasattr(os, "sched_getaffinity"):  # Linux
        count = len(os.sched_getaffinity(0))
    with suppress(OSError, ValueError, ZeroDivisionError):
        quota, period = _QUOTA.read_text("ascii").split()
        count = min(count, math.ceil(int(quota) / int(period)))
    return max(count, 1)
