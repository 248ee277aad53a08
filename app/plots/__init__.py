"""The charts: signals of the motions that are shown, over time."""
