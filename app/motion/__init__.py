"""Motions that are played: a plan, a simulation or a file's as frames, and frames as a clip."""
