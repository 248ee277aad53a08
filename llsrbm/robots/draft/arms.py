"""The arms of a URDF: chains in mirrored pairs that end in no foot."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pinocchio as pin

from llsrbm.robots.urdf import bodies_on

_HAND = re.compile(r"hand|palm|gripper", re.IGNORECASE)
_FEWEST, _MOST = 3, 4  # joints of an arm: those of the shoulder and the elbow; wrists are held
_MIRRORED = 0.01  # m, to which shoulders are mirror images
_ALIKE = 0.02  # share by which the masses of two arms may differ
_PARALLEL = 0.99  # cosine, from which on axes are mirror images
_CARRIED, _LEFT = 0.1, 0.25  # shares of the arm's mass and length that an elbow still moves


@dataclass(frozen=True)
class ArmAnatomy:
    """One arm of n joints.

    Attributes:
        joint_ids: (n,) in the model, from the base outwards; hand: the frame at its end.
    """

    name: str
    hand: str
    joint_ids: tuple[int, ...]


def arm_joints(model: pin.Model, spare: list[int]) -> tuple[list[str], ...]:
    """Names of the joints of the left and the right arm, base outwards; none: it has no arms.

    Of mirrored pairs of chains among the joints that move no foot, `spare`, the heaviest. Joints
    that move little mass, or only what is near them, are a wrist's or a gripper's and left out.
    """
    data = model.createData()
    q = pin.neutral(model)
    pin.ccrba(model, data, q, np.zeros(model.nv))
    pin.computeJointJacobians(model, data, q)
    found: list[tuple[float, tuple[list[int], ...]]] = []
    for pair in combinations(spare, 2):
        left, right = sorted(pair, key=lambda j: -data.oYcrb[j].lever[1])
        if model.parents[left] != model.parents[right] or not _mirrored(data, left, right):
            continue
        chains = [_moving(model, data, _chain(model, joint)) for joint in (left, right)]
        size = min(map(len, chains))
        chains = [chain[:size] for chain in chains]
        if size >= _FEWEST and _mirrored_axes(model, data, *chains):
            found.append((float(data.oYcrb[left].mass), tuple(chains)))
    if not found:
        return ()
    heaviest = max(found, key=lambda entry: entry[0])[1]
    return tuple([model.names[joint] for joint in chain] for chain in heaviest)


def arm_anatomy(model: pin.Model, joints: tuple[list[str], ...]) -> tuple[ArmAnatomy, ...]:
    """The arms of those joints in a model whose other spare joints are held."""
    chains = [tuple(model.getJointId(name) for name in arm) for arm in joints]
    return tuple(
        ArmAnatomy(f"{side}_arm", _hand(model, chain[-1]), chain)
        for side, chain in zip(("left", "right"), chains, strict=False)
    )


def _mirrored(data: pin.Data, left: int, right: int) -> bool:
    masses = data.oYcrb[left].mass, data.oYcrb[right].mass
    places = data.oMi[left].translation, data.oMi[right].translation
    return bool(  # the first joints of both may be in the middle
        data.oYcrb[left].lever[1] > _MIRRORED > -_MIRRORED > data.oYcrb[right].lever[1]
        and np.abs(places[0] - places[1] * [1, -1, 1]).max() < _MIRRORED
        and abs(masses[0] - masses[1]) < _ALIKE * masses[0]
    )


def _mirrored_axes(model: pin.Model, data: pin.Data, left: list[int], right: list[int]) -> bool:
    axes, others = (data.J[3:, [model.joints[j].idx_v for j in arm]].T for arm in (left, right))
    return bool((np.abs((axes * [-1, 1, -1] * others).sum(axis=1)) > _PARALLEL).all())


def _chain(model: pin.Model, joint: int) -> list[int]:
    """Joints from there outwards until they part, or turn without stops."""
    chain: list[int] = []
    while len(chain) < _MOST and model.joints[joint].nq == 1:
        chain.append(joint)
        children = [k for k in range(joint + 1, model.njoints) if model.parents[k] == joint]
        if len(children) != 1:
            break
        joint = children[0]
    return chain


def _moving(model: pin.Model, data: pin.Data, chain: list[int]) -> list[int]:
    """The chain without the joints at its end that move little mass, or only what is near them."""
    beyond = [_farthest(model, data, joint) for joint in chain]
    steps = np.linalg.norm(np.diff([data.oMi[j].translation for j in chain], axis=0), axis=1)
    length = steps.sum() + beyond[-1] if chain else 0.0
    while chain and (
        data.oYcrb[chain[-1]].mass < _CARRIED * data.oYcrb[chain[0]].mass
        or beyond[len(chain) - 1] < _LEFT * length
    ):
        chain = chain[:-1]
    return chain


def _farthest(model: pin.Model, data: pin.Data, joint: int) -> float:
    """m from a joint to the CoM of the farthest body that it moves."""
    places = [data.oMi[k].act(model.inertias[k].lever) for k in model.subtrees[joint]]
    return float(np.linalg.norm(np.array(places) - data.oMi[joint].translation, axis=1).max())


def _hand(model: pin.Model, joint: int) -> str:
    """The body at the end of an arm: the first one that is called a hand, else the outermost."""
    bodies = bodies_on(model, joint)
    bodies.sort(key=lambda frame: float(np.linalg.norm(frame.placement.translation)))
    named = [frame for frame in bodies if _HAND.search(frame.name)]
    return str((named or bodies[::-1])[0].name)
