"""A robot's drives: their table in its file, what they can give, and what they take."""
