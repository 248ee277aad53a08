"""The controls beside the picture, and what they say of the state."""
