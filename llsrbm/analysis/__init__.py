"""What plans ask of the whole robot, computed with Pinocchio: nothing here knows the planner."""
