"""Everything that can be plotted: the one list."""

from __future__ import annotations

from collections.abc import Mapping

from app.plots.declared_signals import declared_signals
from app.plots.derived_signals import derived_signals
from app.plots.signal import Signal

SIGNALS: Mapping[str, Signal] = {
    signal.key: signal for signal in (*declared_signals(), *derived_signals())
}
"""Key -> signal, in the order of menus; what is derived replaces what is declared."""
