"""Planning: from the design, by way of its robot, to its plan that is shown, or the nearest."""
