"""What is played: a plan, a simulation or a file's motion as frames, and frames as a clip."""
