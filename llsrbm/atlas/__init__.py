"""Atlases: what a sweep's jumps say of what a robot can do, as maps over two of its axes.

`jumps` reads a sweep's table, `colours` says what a map may show, `map` lays jumps out over two
axes and draws the border of what can be done, `picture` draws maps with matplotlib.
"""
