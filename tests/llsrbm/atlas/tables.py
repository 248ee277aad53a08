"""Made-up tables of sweeps whose borders are known."""

import math
from itertools import product

import numpy as np
import pyarrow.parquet as pq

from llsrbm.sweep.rows import schema, table_of
from tests.llsrbm.sweep.specs import parse_spec

TWISTS = np.radians(np.linspace(-180, 180, 9))
FORWARDS = np.linspace(-0.3, 0.6, 4)
HEIGHTS = (0.0, 0.2)


def row(jump, seed=0, **values):
    """A jump that was planned and landed, unless the values say otherwise."""
    asked = dict.fromkeys(
        ("twist", "forward", "lateral", "height", "roll", "pitch", "speed", "end_speed"), 0.0
    )
    return {
        "jump": jump,
        "robot": "anymal",
        "model": "llsrbm-plus",
        "type": "together",
        **asked,
        "hops": 1,
        "drive_torque": 1.0,
        "drive_speed": 1.0,
        "seed": seed,
        "status": "planned",
        "landed": True,
        "strict": True,
        "flight_s": 0.3,
        "torque_share": 0.5,
        "robot_hash": "a hash",
        **values,
    }


def stopped(name="joint_torque"):
    """The values of a jump that cannot be planned."""
    nothing = dict.fromkeys(("landed", "strict", "flight_s", "torque_share"))
    return {"status": "not planned", "stopped_by": name, **nothing}


def write(path, rows, limits=()):
    made = [{"index": index, **each} for index, each in enumerate(rows)]
    axes = "".join(f"\n[limits]\n{limit} = [1]" for limit in limits)
    spec = parse_spec(f'title = "x"\nrobots = ["anymal"]{axes}', "spec")
    pq.write_table(table_of(made, schema(spec)), path)
    return path


def can(twist, height):
    """The border: 120 degrees on the ground, 60 degrees onto the box."""
    return abs(twist) < math.radians(120 if height == 0 else 60)


def grid(robots=("anymal",)):
    """Rows of a grid that `can` divides, of each robot."""
    jumps = product(robots, HEIGHTS, TWISTS, FORWARDS)
    return [
        row(
            number,
            robot=robot,
            height=height,
            twist=twist,
            forward=forward,
            **({} if can(twist, height) else stopped()),
        )
        for number, (robot, height, twist, forward) in enumerate(jumps)
    ]


def drawn(count=400, seed=1):
    """Rows of a drawn sweep: plannable inside a circle of 0.25 m in forward and lateral."""
    generator = np.random.default_rng(seed)
    places = generator.uniform(-0.4, 0.4, (count, 2))
    return [
        row(
            number,
            forward=x,
            lateral=y,
            **({"torque_share": 1.0 + x} if math.hypot(x, y) < 0.25 else stopped("reach")),
        )
        for number, (x, y) in enumerate(places)
    ]
