"""Sweeps: thousands of jumps of a spec, planned and simulated by Dask, in one table.

`spec` says which jumps (its file: `spec_file`, its ranges: `axes`), `points` counts and orders
them, `shard` works some of them off in a worker, `rows` is what the table says of one, with
`figures` of its plan, `run` hands shards out, `table` and `trajectories` keep what comes back,
`estimate` says beforehand what it will take.
"""
