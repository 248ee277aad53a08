"""A motion at the knots as the vector of all variables: the reverse of `knots.unpack`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llsrbm.planning.problem.layout import SHIFT, Layout, Role

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Sampled:
    """A motion at N + 1 knots, in the solver's units (`Layout`): P phases, L legs, c corners.

    Attributes:
        durations: (P,) s.
        position, velocity: (N+1, 3); quat: (N+1, 4); momentum, rotation_rate: (N+1, 3).
        feet: (N+1, L, d) x; feet_velocity: (N+1, L, d), of the interval before, at lift-off of the
            first one.
        force: (N+1, L, c, 3); landing_force: (L, c, 3), of feet that meet the ground.
        shift: (2,) m.
    """

    durations: Array
    position: Array
    velocity: Array
    quat: Array
    momentum: Array
    rotation_rate: Array
    feet: Array
    feet_velocity: Array
    force: Array
    landing_force: Array
    shift: Array


def pack(layout: Layout, motion: Sampled) -> Array:
    """All variables, in the layout's order; steps of forces are zero."""
    w = np.zeros(layout.size_total)
    feet, rate, durations = motion.feet, motion.feet_velocity, motion.durations
    for k, role in enumerate(layout.roles):
        following = min(k + 1, layout.total)

        def of(name: str, values: Array, role: Role = role) -> Array:
            return np.ravel(values[list(layout.legs_of(name, role))])

        values = {
            "position": motion.position[k],
            "velocity": motion.velocity[k],
            "quat": motion.quat[k],
            "momentum": motion.momentum[k],
            "rotation_rate": motion.rotation_rate[k],
            "duration": durations[role.phase],
            "next_duration": durations[min(role.phase + 1, layout.phases - 1)],
            "force": of("force", motion.force[k]),
            "next_force": of("next_force", motion.landing_force),
            "feet": of("feet", feet[k]),
            "feet_velocity": of("feet_velocity", rate[k]),
            "feet_step": of("feet_step", rate[following] - rate[k]),
            "next_feet": of("next_feet", feet[following]),
            "next_feet_velocity": of("next_feet_velocity", rate[following]),
            SHIFT: motion.shift,
        }
        for name, place in layout.variables(k).items():
            w[place] = values.get(name, 0.0)
    return w
