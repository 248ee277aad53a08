"""Friction pyramids, as planner and controller use them."""

INSCRIBED = 0.5**0.5
"""Of a cone's coefficient: that of the four-sided pyramid inside it. One with the coefficient
itself reaches out of the cone at its edges, where the ground does not hold."""
