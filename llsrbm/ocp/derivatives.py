"""First and second derivatives through marked intermediate quantities, exactly.

Outputs g(z, y) hold variables z and intermediates y = f(z, y), each of those before it. With w =
(z, y), W = dw/dz and the Lagrangian L = ybar . f + weights . g of independent z and y,

    W_y = f_z + f_y W_y,     dg/dz = g_w W,
    ybar = g_y^T weights + f_y^T ybar,     H = W^T L_ww W.

All that is written out, f_w, g_w and L_ww, is small and sparse. The chain rule is products of
matrices of numbers, level by level: intermediates of a level need none of each other. So nothing
grows by what hangs on what, and a compiler has little to do.
"""

from collections.abc import Sequence
from typing import Any

import casadi as ca

from llsrbm.abandon import go_on
from llsrbm.ocp.lifting import Lifting


class Derivatives:
    """Those of outputs by the variables of a `Lifting`.

    Arguments are z and the numbers, as MX, or as SX for expressions that are written out whole.
    """

    def __init__(self, name: str, lift: Lifting, numbers: Sequence[ca.SX], outputs: ca.SX) -> None:
        """Differentiate.

        Args:
            name: begins the names of functions.
            lift: has what was marked in the outputs.
            numbers: each of what else the outputs hold.
            outputs: g, (m, 1).
        """
        z, (symbols, definitions) = lift.variables, lift.marked
        y, f = (ca.vertcat(ca.SX(0, 1), *each) for each in (symbols, definitions))
        order, self._levels = _by_level(ca.jacobian_sparsity(f, y))
        y, f = y[order], f[order]
        w, self._count = ca.vertcat(z, y), z.numel()
        ybar, weights = ca.SX.sym("ybar", f.shape[0]), ca.SX.sym("weights", outputs.shape[0])
        slopes = [ca.jacobian(f, w), ca.jacobian(outputs, w)]
        L_ww = ca.hessian(ca.dot(ybar, f) + ca.dot(weights, outputs), w)[0]
        # Half of it, the other half is the transpose; and only what curves.
        curvature = ca.sparsify(ca.triu(L_ww, False) + ca.diag(ca.diag(L_ww)) / 2)
        pattern = curvature.sparsity()
        self._curved = sorted({*pattern.row(), *pattern.get_col()})
        curvature = curvature[self._curved, self._curved]
        self._patterns = [matrix.sparsity() for matrix in (*slopes, curvature)]

        def function(kind: str, arguments: list[ca.SX], results: list[ca.SX]) -> ca.Function:
            go_on()
            return ca.Function(f"{name}_{kind}", arguments, results, {"cse": True})

        self._between = function("y", [z, *numbers], [lift.resolve(y)])
        slopes = [nonzeros(matrix) for matrix in slopes]
        self._slopes = function("w", [z, y, *numbers], [ca.densify(outputs), *slopes])
        inputs = [z, y, *numbers, ybar, weights]
        self._curvature = function("ww", inputs, [nonzeros(curvature)])

    def jacobian(self, z: Any, *numbers: Any) -> tuple[Any, Any]:
        """Outputs (m, 1) and their slopes by the variables (m, n)."""
        values, f_w, g_w = self._local(z, self._between(z, *numbers), *numbers)
        return values, ca.mtimes(self._along(f_w), g_w.T).T

    def hessian(self, z: Any, *numbers_and_weights: Any) -> Any:
        """Second derivatives (n, n) of the outputs' weighed sum; the weights come last."""
        *numbers, weights = numbers_and_weights
        y = self._between(z, *numbers)
        _, f_w, g_w = self._local(z, y, *numbers)
        if not self._curved:
            return type(z)(self._count, self._count)
        ybar = self._adjoint(f_w, ca.densify(ca.mtimes(g_w.T, weights)))
        curvature = self._curvature(z, y, *numbers, ybar, weights)
        along = self._along(f_w)[:, self._curved]
        half = ca.mtimes(ca.mtimes(along, type(z)(self._patterns[2], curvature)), along.T)
        return half + half.T

    def _local(self, z: Any, y: Any, *numbers: Any) -> tuple[Any, Any, Any]:
        values, *slopes = self._slopes(z, y, *numbers)
        f_w, g_w = (type(z)(at, each) for at, each in zip(self._patterns[:2], slopes, strict=True))
        return values, f_w, g_w

    def _along(self, f_w: Any) -> Any:
        """W^T, (n, w): its columns are kept one after the other, so that a level is put behind."""
        along = type(f_w).eye(self._count)
        for start, stop in self._levels:
            level = f_w[start:stop, : self._count + start]
            along = ca.horzcat(along, ca.mtimes(along, level.T))
        return along

    def _adjoint(self, f_w: Any, slope: Any) -> Any:
        """ybar, of the sum's slope by all w, (w, 1)."""
        parts = []
        for start, stop in reversed(self._levels):
            begin = self._count + start
            parts.append(slope[begin:])
            slope = slope[:begin] + ca.mtimes(f_w[start:stop, :begin].T, parts[-1])
        return ca.vertcat(type(slope)(0, 1), *reversed(parts))


def _by_level(needs: ca.Sparsity) -> tuple[list[int], list[tuple[int, int]]]:
    """The order of rows in which none needs one of its level, and from where to where each is."""
    level = [0] * needs.size1()
    for row, column in sorted(zip(needs.row(), needs.get_col(), strict=True)):
        level[row] = max(level[row], level[column] + 1)
    order = sorted(range(len(level)), key=level.__getitem__)
    ends = [sum(one <= k for one in level) for k in range(max(level, default=-1) + 1)]
    return order, list(zip([0, *ends], ends, strict=False))


def nonzeros(matrix: ca.SX) -> ca.SX:
    """(nnz, 1), column by column."""
    return ca.vertcat(*matrix.nonzeros()) if matrix.nnz() else ca.SX(0, 1)
