"""The picture: robots, ground and overlays of what the state holds."""
