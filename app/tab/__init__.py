"""A tab: its state, the features that change it, and its session.

Importing the features registers their handlers in `app.tab.acts`.
"""

from app.tab import (
    atlas,
    comparing,
    comparison,
    design,
    files,
    inspection,
    plotting,
    pushing,
    repairing,
    robot_simulator,
    routing,
    shaping,
    simulating,
)
from app.tab.planning import answers, largest, refining, requests, robot
from app.tab.start import opening, preferences

__all__ = [
    "answers",
    "atlas",
    "comparing",
    "comparison",
    "design",
    "files",
    "inspection",
    "largest",
    "opening",
    "plotting",
    "preferences",
    "pushing",
    "refining",
    "repairing",
    "requests",
    "robot",
    "robot_simulator",
    "routing",
    "shaping",
    "simulating",
]
