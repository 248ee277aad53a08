"""Violations of a plan, the limits that stop a jump, and the nearest jump that can be planned."""
