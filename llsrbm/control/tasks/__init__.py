"""What the whole-body controller wants, a small class each."""

from llsrbm.control.tasks.angular_momentum import AngularMomentum
from llsrbm.control.tasks.base import Motion, Task
from llsrbm.control.tasks.com import CentreOfMass
from llsrbm.control.tasks.feet import SeekingFeet, StandingFeet, SwingFeet
from llsrbm.control.tasks.orientation import BaseOrientation, FootOrientation
from llsrbm.control.tasks.posture import Posture

__all__ = [
    "AngularMomentum",
    "BaseOrientation",
    "CentreOfMass",
    "FootOrientation",
    "Motion",
    "Posture",
    "SeekingFeet",
    "StandingFeet",
    "SwingFeet",
    "Task",
]
