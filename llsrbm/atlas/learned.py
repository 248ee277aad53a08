"""The built-in atlas: all jumps in the robots' tables of solved jumps (`llsrbm robot learn`)."""

from __future__ import annotations

import numpy as np

from llsrbm.atlas.jumps import AMOUNTS, DRIVES, NOTHING, Atlas, Jumps
from llsrbm.planning.whole_body.learned import Outcomes
from llsrbm.planning.whole_body.learned_file import outcomes_of
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.robots import load_robot, names
from llsrbm.sweep.rows import robot_hash

TITLE = "Tables of solved jumps"


def learned_atlas() -> Atlas:
    """Jumps of every robot that comes with a table, numbered robot by robot."""
    groups: list[Jumps] = []
    for name in names():
        outcomes = outcomes_of(load_robot(name))
        if outcomes is not None:
            groups.append(_jumps(name, outcomes, sum(map(len, groups))))
    return Atlas(TITLE, tuple(groups))


def _jumps(robot: str, found: Outcomes, first: int) -> Jumps:
    """A robot's; nothing of them was simulated."""
    solved, plain = len(found.requests), Jump(robot=robot)
    values = np.vstack([found.requests, found.refused])
    unknown = np.full(len(values), np.nan)
    requested = {name: np.full(len(values), float(getattr(plain, name))) for name in AMOUNTS}
    requested |= dict(zip(COMPONENTS, values.T, strict=True))
    requested |= dict.fromkeys(DRIVES, np.ones(len(values)))
    causes, counts = np.unique(found.stopped_by, return_counts=True)
    stops = (NOTHING, *causes[np.argsort(-counts, kind="stable")].tolist())
    flight, torque_share = unknown.copy(), unknown.copy()
    flight[:solved], torque_share[:solved] = found.flight, found.torque_share
    return Jumps(
        robot,
        plain.model,
        plain.type,
        numbers=first + np.arange(len(values)),
        requested=requested,
        planned=(np.arange(len(values)) < solved).astype(float),
        landed=unknown,
        strict=unknown,
        flight=flight,
        torque_share=torque_share,
        stops=stops,
        stop=np.array([0] * solved + [stops.index(name) for name in found.stopped_by]),
        robot_hash=robot_hash(robot),
    )
