"""Repair: from any motion of a robot to the nearest one that it can do."""
