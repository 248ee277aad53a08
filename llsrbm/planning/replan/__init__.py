"""Planning again while the robot moves."""
