"""Specs for tests, and planning that takes no time."""

import math
from contextlib import contextmanager

import distributed
import pyarrow.parquet as pq

from llsrbm.request.tables import parse_table, validated
from llsrbm.sweep import jump, run
from llsrbm.sweep.folder import Folder
from llsrbm.sweep.points import Points
from llsrbm.sweep.rows import NOT_PLANNED, PLANNED, TIMES, origin
from llsrbm.sweep.spec import Spec

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


def parse_spec(text, where):
    """The spec of a text, called `where` in messages."""
    return validated(Spec, parse_table(text, where), where)


def spec(text=GRID):
    return parse_spec(text, "spec.toml")


def planned_at_once(spec, point):
    """In place of planning: figures that follow from the request alone."""
    if point.jump.twist > 1.0:
        return {"status": NOT_PLANNED, "stopped_by": "friction"}, None
    return {"status": PLANNED, "cost": math.cos(point.jump.twist) + point.jump.forward}, None


def without_planning(monkeypatch):
    """Neither planning nor a process of its own for it."""
    monkeypatch.setattr(jump, "_planned", planned_at_once)
    monkeypatch.setattr(jump, "_planner", lambda point: None)
    monkeypatch.setattr(jump, "plan_of", lambda spec, point: None)
    monkeypatch.setattr(jump, "compute", lambda function, *of, limit: function(*of))


@contextmanager
def in_this_process(*_):
    """In place of `connected`: a cluster of two threads, which sees what a test has replaced."""
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0"
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


def rows_of(path):
    """A sweep's rows, times aside."""
    return pq.read_table(path / "jumps.parquet").drop_columns([*TIMES])


def opened(path, text=GRID, of=None):
    points = Points(spec(text))
    return Folder(path, points, of or origin(points.spec))


def filled(path, jumps, text=GRID):
    """The folder with these jumps, computed here."""
    with opened(path, text) as folder:
        for number in jumps:
            point = folder.points[number]
            folder.append(number, jump.rows_of(folder.points.spec, point))


def work(folder, client, **options):
    """All of a folder's jumps."""
    given = {"limit": 60.0, "progress": lambda _: None, "note": lambda _: None, **options}
    return run.run(folder, client, given.pop("of", origin(folder.points.spec)), **given)
