"""What a planner or a simulator produced, as arrays over time."""
