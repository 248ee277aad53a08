"""The state of a robot from its own sensors: `state_estimator` is what others call."""
