"""Sweeps: thousands of jumps of a spec, planned and simulated by Dask, in one table.

`spec` describes the jumps, `points` counts and orders them, `jump` computes the rows of one in
a process beside each worker, `rows` declares the table's columns, `run` hands the jumps out,
`folder` keeps their rows, `dataset` makes trainers' files of the strict ones.
"""
