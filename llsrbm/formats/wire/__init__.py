"""Files for a robot's own low-level interface, and for those who play or learn from such files."""

from llsrbm.formats.wire.lowcmd import LOWCMD
from llsrbm.formats.wire.odri_csv import ODRI_CSV
from llsrbm.formats.wire.quad_sdk_csv import QUAD_SDK_CSV
from llsrbm.formats.wire.ros2 import ROS2_BAG

__all__ = ["LOWCMD", "ODRI_CSV", "QUAD_SDK_CSV", "ROS2_BAG"]
