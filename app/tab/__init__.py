"""A tab: its state, the features that change it, and its session.

Importing the features registers their handlers in `app.tab.acts`.
"""

from app.tab import (
    asking,
    atlas,
    certificate,
    comparison,
    design,
    files,
    planning,
    pushing,
    refining,
    simulating,
)
from app.tab.start import opening, preferences

__all__ = [
    "asking",
    "atlas",
    "certificate",
    "comparison",
    "design",
    "files",
    "opening",
    "planning",
    "preferences",
    "pushing",
    "refining",
    "simulating",
]
