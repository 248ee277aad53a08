"""A first robot file from a URDF alone: what the URDF says is measured, the rest is guessed."""

from llsrbm.robots.draft.anatomy import Anatomy, read_anatomy
from llsrbm.robots.draft.proposal import Proposal, propose
from llsrbm.robots.draft.text import robot_file_text, urdf_beside

__all__ = ["Anatomy", "Proposal", "propose", "read_anatomy", "robot_file_text", "urdf_beside"]
