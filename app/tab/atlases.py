"""The sweeps whose atlases a server shows: the one that ships, and those of its command line."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path

from llsrbm.atlas.jumps import Atlas
from llsrbm.atlas.table import read_atlas, shipped_atlas
from llsrbm.errors import InputError

SHIPPED = "the one that ships"


class Atlases:
    """Read when they are first asked for, once for all tabs; from any thread.

    Attributes:
        names: to choose from, one at least.
    """

    def __init__(self, folders: Sequence[Path] = ()) -> None:
        """Check and read the folders; the one that ships is read when it is asked for.

        Args:
            folders: of sweeps that are over, or their tables; they come first.

        Raises:
            InputError: one of them is none.
        """
        self._lock = threading.Lock()
        self._read: dict[str, Atlas] = {}
        for folder in folders:
            atlas = read_atlas(folder)
            name = atlas.title
            if name in self._read:
                name = f"{name} ({folder.name})"
            if name in self._read:
                raise InputError(f"--atlas: {folder} is given twice; expected each once")
            self._read[name] = atlas
        self.names: tuple[str, ...] = (*self._read, SHIPPED)

    def named(self, name: str) -> Atlas | None:
        """The atlas with a name, "" the first one; None: there is none.

        Raises:
            InputError: the one that ships is missing or damaged.
        """
        name = name or self.names[0]
        with self._lock:
            if name == SHIPPED and name not in self._read:
                self._read[name] = read_atlas(shipped_atlas())
            return self._read.get(name)
