"""Requests: the jump, its schedule, tuning, scenario and pushes, and design files."""
