"""Atlases: the range of a robot's feasible jumps, as maps of a sweep over two of its axes.

`table` reads a sweep's table as `jumps`, `colours` has the quantities that a map may show, `map`
lays jumps out over two axes and draws the border of feasible ones, `picture` draws it.
"""
