"""Logs for viewers: Foxglove's and rerun's."""
