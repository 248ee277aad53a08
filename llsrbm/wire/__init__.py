"""To a robot's own wire: its messages, a simulator that speaks them, a player of plans."""
