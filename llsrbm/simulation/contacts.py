"""Contact forces and contact truth, a foot: MuJoCo's own contact sensors, read each step."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_FOUND = 1 << int(mujoco.mjtConDataField.mjCONDATA_FOUND)
_FORCE = 1 << int(mujoco.mjtConDataField.mjCONDATA_FORCE)
_NO_REDUCTION, _NET_FORCE = 0, 3  # of a sensor's contacts; the net force is in the world frame
_FOOT_WIDTH = 4  # numbers a foot: contacts found, force


def add_sensors(spec: mujoco.MjSpec, feet: list[str], trunk: str) -> None:
    """Give a model the sensors that `ContactReader` reads.

    The specification must have no other sensors.

    Args:
        feet: the feet's geoms, in the order of the legs.
        trunk: the body with all other geoms that can touch something.
    """
    for foot in feet:
        spec.add_sensor(
            name=foot,
            type=mujoco.mjtSensor.mjSENS_CONTACT,
            objtype=mujoco.mjtObj.mjOBJ_GEOM,
            objname=foot,
            intprm=[_FOUND | _FORCE, _NET_FORCE, 1],
        )
    spec.add_sensor(
        name="trunk",
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        objname=trunk,
        intprm=[_FOUND, _NO_REDUCTION, 1],
    )


class ContactReader:
    """Collects the contacts of a tick's S steps: L feet.

    A step's contacts are those of the state it starts from, and its forces act until its end.
    """

    def __init__(self, data: mujoco.MjData, legs: int, steps: int) -> None:
        self._sensors = data.sensordata
        self._tick = np.zeros((steps, len(self._sensors)))
        self._feet = self._tick[:, : _FOOT_WIDTH * legs].reshape(steps, legs, _FOOT_WIDTH)
        self._trunk = self._tick[:, _FOOT_WIDTH * legs :]

    def read(self, step: int) -> None:
        """Note the contacts of a step of the tick, after it."""
        self._tick[step] = self._sensors

    def touched(self) -> NDArray[np.bool_]:
        """(S, L): whether each foot touched anything in each step."""
        touched: NDArray[np.bool_] = self._feet[..., 0] > 0
        return touched

    def mean_force(self) -> Array:
        """(L, 3) N, world frame, on the feet."""
        # MuJoCo gives the force of the sensor's geom on what it touches.
        force: Array = self._feet[..., 1:].sum(axis=0) * (-1.0 / len(self._tick))
        return force

    def trunk_touched(self) -> bool:
        """Whether anything but the feet touched."""
        return bool(self._trunk.any())
