"""Sweeps: thousands of jumps of a spec, planned and simulated by Dask, in one table.

`spec` says which jumps, `points` counts and orders them, `shard` works some of them off in a
worker, `rows` is what the table says of one, `run` hands shards out, `table` and `trajectories`
keep what comes back, `estimate` says beforehand what it will take.
"""
