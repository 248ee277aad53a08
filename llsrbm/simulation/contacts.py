"""Contact forces and contact truth, a foot: MuJoCo's own contact sensors, read each step."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_FOUND = 1 << int(mujoco.mjtConDataField.mjCONDATA_FOUND)
_FORCE = 1 << int(mujoco.mjtConDataField.mjCONDATA_FORCE)
_NO_REDUCTION, _NET_FORCE = 0, 3  # of a sensor's contacts; the net force is in the world frame
_WIDTH = 4  # numbers a geom of a foot: contacts found, force


def add_sensors(
    spec: mujoco.MjSpec, feet: list[list[str]], trunk: str, untouched: Sequence[str] = ()
) -> None:
    """Give a model, which must have no others, the sensors that `ContactReader` reads.

    `feet`: each foot's geoms, as many for all; `trunk`: the body with all other geoms that can
    touch something; `untouched`: bodies in the world that nothing may touch.
    """
    for geom in chain.from_iterable(feet):
        spec.add_sensor(
            name=geom,
            type=mujoco.mjtSensor.mjSENS_CONTACT,
            objtype=mujoco.mjtObj.mjOBJ_GEOM,
            objname=geom,
            intprm=[_FOUND | _FORCE, _NET_FORCE, 1],
        )
    for name, body in (("trunk", trunk), *((body, body) for body in untouched)):
        spec.add_sensor(
            name=name,
            type=mujoco.mjtSensor.mjSENS_CONTACT,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            objname=body,
            intprm=[_FOUND, _NO_REDUCTION, 1],
        )


class ContactReader:
    """Collects the contacts of a tick's S steps, of L feet with `geoms` geoms each, from `data`.

    A step's contacts are those of the state it starts from, and its forces act until its end.
    """

    def __init__(self, data: mujoco.MjData, legs: int, geoms: int, steps: int) -> None:
        self._sensors = data.sensordata
        self._tick = np.zeros((steps, len(self._sensors)))
        width = _WIDTH * legs * geoms
        self._feet = self._tick[:, :width].reshape(steps, legs, geoms, _WIDTH)
        self._feet_rows = self._tick[:, :width]
        self._trunk, self._untouched = self._tick[:, width], self._tick[:, width + 1 :]

    def read(self, step: int) -> None:
        """Note the contacts of a step of the tick, after it."""
        self._tick[step] = self._sensors

    def touched(self) -> NDArray[np.bool_]:
        """(S, L): whether each foot touched anything in each step."""
        touched: NDArray[np.bool_] = np.logical_or.reduce(self._feet[..., 0] > 0, axis=2)
        return touched

    def mean_force(self) -> Array:
        """(L, 3) N, world frame, on the feet."""
        # MuJoCo gives the force of the sensor's geom on what it touches.
        total = np.add.reduce(self._feet_rows, axis=0).reshape(self._feet.shape[1:])
        force: Array = np.add.reduce(total[..., 1:], axis=1) * (-1.0 / len(self._tick))
        return force

    def trunk_touched(self) -> bool:
        """True if anything but the feet touched."""
        return bool(np.logical_or.reduce(self._trunk))

    def untouched_touched(self) -> bool:
        """True if anything touched what nothing may touch."""
        return self._untouched.size > 0 and bool(self._untouched.any())
