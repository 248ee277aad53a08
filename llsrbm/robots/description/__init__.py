"""The URDF of a robot, read once, checked, and changed as its robot file wants it."""

from llsrbm.robots.description.changes import changed
from llsrbm.robots.description.mesh_paths import installed_shares
from llsrbm.robots.description.parts import Description, Joint, Link, Solid
from llsrbm.robots.description.reading import read_description

__all__ = [
    "Description",
    "Joint",
    "Link",
    "Solid",
    "changed",
    "installed_shares",
    "read_description",
]
