"""The URDF of a robot, read once, checked, and changed as its robot file wants it."""

from llsrbm.robots.description.changes import changed
from llsrbm.robots.description.elements import FARTHEST
from llsrbm.robots.description.mesh_paths import installed_shares
from llsrbm.robots.description.parts import Description, Joint, Link, Solid
from llsrbm.robots.description.reading import read_description
from llsrbm.robots.description.rotors import rotor_links, srdf_rotors, transmission_rotors

__all__ = [
    "FARTHEST",
    "Description",
    "Joint",
    "Link",
    "Solid",
    "changed",
    "installed_shares",
    "read_description",
    "rotor_links",
    "srdf_rotors",
    "transmission_rotors",
]
