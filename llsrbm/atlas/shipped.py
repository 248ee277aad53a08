"""Where atlases lie: the one that ships with the project, and sweeps that somebody names."""

from __future__ import annotations

from pathlib import Path

from llsrbm.robots.assets import assets_directory


def shipped_atlas() -> Path:
    """The table that ships, of `assets/sweeps/atlas.toml`."""
    return assets_directory() / "atlas" / "jumps.parquet"
