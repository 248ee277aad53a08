"""Specs for tests, and planning that takes no time."""

from __future__ import annotations

import math
from contextlib import contextmanager

import distributed
import pyarrow.parquet as pq

from llsrbm.sweep import run, shard
from llsrbm.sweep.rows import NOT_PLANNED, PLANNED, TIMES
from llsrbm.sweep.spec_file import parse_spec

GRID = """
title = "a grid"
robots = ["anymal", "go2"]
[axes]
twist_deg = { from = -90, to = 90, count = 5 }
forward = [0.0, 0.2]
[limits]
friction = [0.3, 0.5]
"""
"""Of 40 jumps."""


def spec(text=GRID):
    return parse_spec(text, "spec.toml")


def planned_at_once(point, spec):
    """In place of planning: figures that follow from the request alone."""
    if point.jump.twist > 1.0:
        return {"status": NOT_PLANNED, "stopped_by": "friction"}, None
    return {"status": PLANNED, "cost": math.cos(point.jump.twist) + point.jump.forward}, None


def without_planning(monkeypatch):
    monkeypatch.setattr(shard, "_planned", planned_at_once)
    monkeypatch.setattr(shard, "_planner", lambda point: None)


def in_this_process(workers):
    """In place of `connected`: a cluster of threads, which sees what a test has replaced."""

    @contextmanager
    def connected(*_):
        with (
            distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=False,
                dashboard_address="127.0.0.1:0",
            ) as cluster,
            distributed.Client(cluster) as client,
        ):
            yield client

    return connected


def rows_of(path):
    """A table's rows, times aside."""
    return pq.read_table(path).drop_columns([*TIMES])


def work(folder, client, monkeypatch=None, jumps_a_shard=None):
    """All of a folder's jumps."""
    if jumps_a_shard is not None:
        monkeypatch.setattr(run._Work, "_size", lambda self: jumps_a_shard)
    origin = shard.origin(folder.points.spec)
    return run.run(folder, client, origin, progress=lambda _: None, told=lambda _: None)
