"""A limb's links as expressions of its joints' angles and its numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from llsrbm.planning.whole_body.limbs import LimbKind


class Numbered:
    """Expressions of a vector of numbers by their names."""

    def __init__(self, sizes: Mapping[str, int]) -> None:
        self.all = ca.SX.sym("n", sum(sizes.values()))
        self._at: dict[str, Any] = {}
        at = 0
        for name, size in sizes.items():
            self._at[name] = self.all[at : at + size]
            at += size

    def __call__(self, name: str, joint: int | None = None) -> Any:
        """Numbers of that name, of a joint's those of its place in the chain."""
        return self._at[name if joint is None else f"{name} {joint}"]


class Chain:
    """Expressions of a limb's links; `n` are its numbers."""

    def __init__(self, kind: LimbKind) -> None:
        self.kind, self.n = kind, Numbered(kind.given)

    def axis(self, i: int) -> Any:
        """(3,) of a joint."""
        axis = ca.SX(3, 1)
        for k in self.kind.joints[i].along:
            axis[k] = self.n("axis", i)[k]
        return axis

    def turn(self, i: int, angle: Any) -> Any:
        """(3, 3) from the axes of a link to its parent's."""
        joint = self.kind.joints[i]
        if joint.slides:
            return ca.SX.eye(3)
        axis = self.axis(i)
        across = ca.SX(3, 3)
        for row, column, k in ((2, 1, 0), (0, 2, 1), (1, 0, 2)):
            if k in joint.along:
                across[row, column] = axis[k]
                across[column, row] = -axis[k]
        # Of an axis of one component its square is one.
        along = ca.SX(3, 3)
        if len(joint.along) == 1:
            along[joint.along[0], joint.along[0]] = 1
        else:
            along = ca.sparsify(ca.mtimes(axis, axis.T))
        s, c = ca.sin(angle), ca.cos(angle)
        return ca.sparsify(along + c * ca.sparsify(ca.SX.eye(3) - along) + s * across)

    def arm(self, i: int, position: Any) -> Any:
        """(3,) m from the parent's joint to a link's, parent's axes."""
        arm = self.n("arm", i)
        return arm + self.axis(i) * position[i] if self.kind.joints[i].slides else arm


def split(variables: ca.SX, sizes: Mapping[str, int]) -> dict[str, Any]:
    """A vector's parts by their names."""
    ends = np.cumsum([0, *sizes.values()]).tolist()
    return dict(zip(sizes, ca.vertsplit(variables, ends), strict=True))
