"""Contacts, read each step: force and truth a foot by MuJoCo's sensors, other links by its list."""

from collections.abc import Sequence
from itertools import chain
from typing import NamedTuple

import mujoco
import numpy as np

from llsrbm.arrays import Array, BoolArray

_FOUND = 1 << int(mujoco.mjtConDataField.mjCONDATA_FOUND)
_FORCE = 1 << int(mujoco.mjtConDataField.mjCONDATA_FORCE)
_NO_REDUCTION, _NET_FORCE = 0, 3  # of a sensor's contacts; the net force is in the world frame
_WIDTH = 4  # numbers a geom of a foot: contacts found, force
# First parts of the geoms' names. A contact's two ranks add up to more than one unless it is a foot
# that meets the world.
_WORLD = "world"
_RANK = {_WORLD: 0, "foot": 1, "link": 2}
_FOOT_ON_WORLD = 1


def add_sensors(spec: mujoco.MjSpec, feet: list[list[str]], untouched: Sequence[str] = ()) -> None:
    """Give a model, which must have no others, the sensors that `ContactReader` reads.

    `feet`: each foot's geoms, as many for all; `untouched`: bodies in the world that nothing may
    touch.
    """
    for geom in chain.from_iterable(feet):
        spec.add_sensor(
            name=geom,
            type=mujoco.mjtSensor.mjSENS_CONTACT,
            objtype=mujoco.mjtObj.mjOBJ_GEOM,
            objname=geom,
            intprm=[_FOUND | _FORCE, _NET_FORCE, 1],
        )
    for body in untouched:
        spec.add_sensor(
            name=body,
            type=mujoco.mjtSensor.mjSENS_CONTACT,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            objname=body,
            intprm=[_FOUND, _NO_REDUCTION, 1],
        )


class Touch(NamedTuple):
    """The robot touches something with another link than a foot, or itself."""

    link: str  # of the robot
    other: str  # another link, or "the ground", "the box"
    trunk: bool  # whether the trunk, or what it carries, touches something that is not the robot


class ContactReader:
    """Collects the contacts of a tick's S steps, of L feet with `geoms` geoms each, from `data`.

    A step's contacts are those of the state it starts from, and its forces act until its end.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, legs: int, geoms: int, steps: int
    ) -> None:
        self._data, self._sensors = data, data.sensordata
        self._tick = np.zeros((steps, len(self._sensors)))
        width = _WIDTH * legs * geoms
        self._feet = self._tick[:, :width].reshape(steps, legs, geoms, _WIDTH)
        self._feet_rows = self._tick[:, :width]
        self._untouched = self._tick[:, width:]
        parts = [model.geom(geom).name.split("/") for geom in range(model.ngeom)]
        self._names = [f"the {part[1]}" if part[0] == _WORLD else part[1] for part in parts]
        self._rank = np.array([_RANK[part[0]] for part in parts])
        self._of_base = model.geom_bodyid == model.jnt_bodyid[0]
        self._touching: list[tuple[int, list[list[int]]]] = []

    def read(self, step: int) -> None:
        """Note the contacts of a step of the tick, after it."""
        if step == 0:
            self._touching.clear()
        self._tick[step] = self._sensors
        if self._data.ncon:
            geoms = self._data.contact.geom
            others = np.add.reduce(self._rank.take(geoms), axis=1) > _FOOT_ON_WORLD
            if np.logical_or.reduce(others):
                self._touching.append((step, geoms[others].tolist()))

    def touched(self) -> BoolArray:
        """(S, L): whether each foot touched anything in each step."""
        return np.logical_or.reduce(self._feet[..., 0] > 0, axis=2)

    def mean_force(self) -> Array:
        """(L, 3) N, world frame, on the feet."""
        # MuJoCo gives the force of the sensor's geom on what it touches.
        total = np.add.reduce(self._feet_rows, axis=0).reshape(self._feet.shape[1:])
        return np.add.reduce(total[..., 1:], axis=1) * (-1.0 / len(self._tick))

    def touches(self) -> dict[Touch, int]:
        """Touches by other links than feet, and the first step of the tick that has each."""
        first: dict[Touch, int] = {}
        for step, pairs in self._touching:
            for pair in pairs:
                other, link = sorted(pair, key=lambda geom: self._rank[geom])
                trunk = bool(self._rank[other] == 0 and self._of_base[link])
                first.setdefault(Touch(self._names[link], self._names[other], trunk), step)
        return first

    def untouched_touched(self) -> bool:
        """True if anything touched what nothing may touch."""
        return self._untouched.size > 0 and bool(self._untouched.any())
