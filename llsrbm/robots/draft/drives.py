"""Drives of a first robot file: what URDF and SRDF say of them, and what is assumed of the rest."""

from __future__ import annotations

from typing import Any

import numpy as np

from llsrbm.arrays import Array
from llsrbm.mechanics import GRAVITY
from llsrbm.robots.description import rotor_links, srdf_rotors, transmission_rotors
from llsrbm.robots.draft.anatomy import Anatomy
from llsrbm.robots.drives.table import (
    ARMATURE_PER_TORQUE,
    DAMPING_PER_TORQUE,
    DELAY,
    FRICTION_PER_TORQUE,
)
from llsrbm.robots.urdf import BASE_JOINT

_WEAKEST, _STRONGEST = 0.05, 2.0  # of m g times the leg's length: other torques are no drive's
_TORQUE = 0.4  # of m g times the leg's length, where the URDF has none
_SLOWEST, _FASTEST = 2.0, 100.0  # rad/s, of limits that are meant
_SPEED = 15.0  # rad/s, where the URDF has none
_FAR_APART = 4 * np.pi  # rad between stops: legs' joints turn by less


def limits(
    anatomy: Anatomy, length: float, values: dict[str, Any], guessed: dict[str, str]
) -> None:
    """Torques and speeds: the URDF's where they can be meant."""
    model, leg = anatomy.model, list(anatomy.joint_ids[0])
    at = [model.joints[j].idx_v for j in leg]
    weight = anatomy.mass * GRAVITY * length
    torque, speed = model.effortLimit[at], model.velocityLimit[at]
    meant = (torque > _WEAKEST * weight) & (torque < _STRONGEST * weight)
    # Ankles may be weak; of a leg without one strong joint no limit is meant.
    if not meant.any() or (torque <= 0).any():
        torque = np.where(meant, torque, _TORQUE * weight)
        guessed["limits.torque"] = f"{_TORQUE} of the weight times the leg's length"
    if (speed < _SLOWEST).any() or (speed > _FASTEST).any():
        speed = np.where((speed >= _SLOWEST) & (speed <= _FASTEST), speed, _SPEED)
        guessed["limits.joint_speed"] = f"{_SPEED:g} rad/s where the URDF has none"
    for key, limit in (("torque", model.effortLimit), ("joint_speed", model.velocityLimit)):
        if others := _unlike_the_first_leg(anatomy, limit):
            guessed["limits"] += f"; {key} as of leg {anatomy.names[0]}, the URDF has {others}"
    if far := _far_apart(anatomy):
        guessed["limits"] += f"; the URDF has stops of {far} rad: are they degrees?"
    values["limits.torque"] = [float(f"{t:.4g}") for t in torque]
    values["limits.joint_speed"] = [float(f"{s:.4g}") for s in speed]


def _far_apart(anatomy: Anatomy) -> str:
    """Joints that turn whose stops are turns apart, with them."""
    model, source = anatomy.model, anatomy.source
    found = []
    for name in (model.names[joint] for leg in anatomy.joint_ids for joint in leg):
        limit = source.joints[name].limit
        if limit is None or source.joints[name].slides:
            continue
        if limit.upper - limit.lower > _FAR_APART:
            found.append(f"{name} at {limit.lower:g} and {limit.upper:g}")
    return _some(found)


def _some(found: list[str]) -> str:
    return ", ".join(found[:4]) + (f" and {len(found) - 4} more" if len(found) > 4 else "")


def _unlike_the_first_leg(anatomy: Anatomy, limit: Array) -> str:
    """Joints of other legs whose limit (nv,) is another one than the first leg's, with it."""
    model, (first, *others) = anatomy.model, anatomy.joint_ids
    found = [
        f"{limit[model.joints[joint].idx_v]:g} for {model.names[joint]}"
        for leg in others
        for joint, like in zip(leg, first, strict=True)
        if not np.isclose(limit[model.joints[joint].idx_v], limit[model.joints[like].idx_v])
    ]
    return _some(found)


def table(anatomy: Anatomy, values: dict[str, Any]) -> dict[str, str]:
    """Add [drives] to `values`, after `limits`; key -> where its numbers are from.

    Zeros of `<dynamics>` say nothing, as those of `<limit>`, nor does what would stop the drives.
    """
    rotors, place = transmission_rotors(anatomy.source), "the URDF's transmissions"
    if not rotors:
        rotors, place = srdf_rotors(anatomy.source)
    stated: dict[str, tuple[dict[str, float], str]] = {
        "armature": (rotors, f"{place}: rotors times their gears squared"),
        "friction": (_dynamics(anatomy, "friction"), "the URDF's <dynamics>"),
        "damping": (_dynamics(anatomy, "damping"), "the URDF's <dynamics>"),
    }
    model, sources = anatomy.model, {}
    leg = [np.array(values[f"limits.{key}"]) for key in ("torque", "joint_speed")]
    limbs = [("drives", anatomy.joint_ids[0], leg)]
    for arm in anatomy.arms[:1]:
        at = [model.joints[j].idx_v for j in arm.joint_ids]
        limbs.append(
            ("drives.arms", arm.joint_ids, [model.effortLimit[at], model.velocityLimit[at]])
        )
    published = set(stated)
    for limb, joints, (torque, speed) in limbs:
        names = [model.names[j] for j in joints]
        for key, (assumed, rule) in _assumed(torque, speed).items():
            numbers, source = stated[key]
            most = {"friction": torque, "damping": torque / speed}.get(key, np.inf + torque)
            beyond = {
                name: numbers[name]
                for name, limit in zip(names, most, strict=True)
                if numbers.get(name, 0.0) >= limit
            }
            meant = {name: number for name, number in numbers.items() if name not in beyond}
            missing = [name for name in names if name not in meant]
            found = [meant.get(name, other) for name, other in zip(names, assumed, strict=True)]
            values[f"{limb}.{key}"] = [float(f"{number:.4g}") for number in found]
            if missing:
                published.discard(key)
            if missing == names:
                source = f"assumed: {rule}"
            elif missing:
                source += f"; assumed of {', '.join(missing)}: {rule}"
            if beyond:
                listed = ", ".join(f"{number:g} for {name}" for name, number in beyond.items())
                source += f"; the URDF has {listed}, which takes all of the drive's torque"
            sources[f"{limb}.{key}"] = source
            if limb == "drives" and (others := _others(anatomy, numbers)):
                sources[f"{limb}.{key}"] += f"; as of leg {anatomy.names[0]}, it has {others}"
        sources[f"{limb}.armature"] += _rotors(rotor_links(anatomy.source), names)
    values["drives.delay"], sources["drives.delay"] = DELAY, "s; assumed: a bus at 1 kHz"
    values |= {f"drives.known.{key}": "published" for key in stated if key in published}
    return sources


def _assumed(torque: Array, speed: Array) -> dict[str, tuple[Array, str]]:
    """Key -> numbers of joints with these limits of torque and speed, and the rule in words."""
    return {
        "armature": (ARMATURE_PER_TORQUE * torque, f"{ARMATURE_PER_TORQUE:g} kg m2 a Nm of torque"),
        "friction": (FRICTION_PER_TORQUE * torque, f"{FRICTION_PER_TORQUE:.0%} of the torque"),
        "damping": (
            DAMPING_PER_TORQUE * torque / speed,
            f"{DAMPING_PER_TORQUE:.0%} of the torque at the largest speed",
        ),
    }


def _dynamics(anatomy: Anatomy, key: str) -> dict[str, float]:
    """Joint -> number of its `<dynamics>`, where that is more than zero."""
    numbers = {name: getattr(of.dynamics, key) for name, of in anatomy.source.joints.items()}
    return {name: number for name, number in numbers.items() if number > 0}


def _others(anatomy: Anatomy, numbers: dict[str, float]) -> str:
    """Joints of other legs whose number is another one than the first leg's, with it."""
    names = anatomy.model.names
    every = np.array([numbers.get(name, 0.0) for name in names[BASE_JOINT + 1 :]])
    return _unlike_the_first_leg(anatomy, np.append(np.zeros(6), every))


def _rotors(inertias: dict[str, float], names: list[str]) -> str:
    """The URDF's rotors of these joints, of which it does not know the gears."""
    if not {*names} <= {*inertias}:
        return ""
    listed = ", ".join(f"{inertias[name]:.4g}" for name in names)
    return f"; the URDF's rotors before their gears: {listed} kg m2"
