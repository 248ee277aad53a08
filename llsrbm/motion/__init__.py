"""Results of a planner or a simulator, as arrays over time."""
