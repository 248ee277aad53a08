"""Robots as data: one TOML file a robot, everything else computed from its URDF."""
