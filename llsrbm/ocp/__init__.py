"""Optimal control without robots."""
