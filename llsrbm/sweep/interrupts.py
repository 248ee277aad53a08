"""Dask loads this in the workers of a local cluster: Ctrl-C reaches them too, in one terminal."""

import signal
from typing import Any


def dask_setup(_worker: Any) -> None:
    """Leave the signal to the command, which ends its workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
