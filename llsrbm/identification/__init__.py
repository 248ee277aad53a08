"""Drives from a log of joints in the air: rotors, friction, damping, delay.

log = read_log(Path("hung.csv"), robot)
found = identify(robot, log)
found.joints["FL_calf_joint"].armature, found.delay
"""

from llsrbm.identification.fit import Identified, JointDrive, identify
from llsrbm.identification.log import Log, read_log

__all__ = ["Identified", "JointDrive", "Log", "identify", "read_log"]
