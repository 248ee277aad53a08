"""A tab: its state, the features that change it, and its session.

Importing the features registers their handlers in `app.tab.acts`.
"""

from app.tab import atlas, comparison, design, files, opening, planning, pushing, simulating

__all__ = ["atlas", "comparison", "design", "files", "opening", "planning", "pushing", "simulating"]
