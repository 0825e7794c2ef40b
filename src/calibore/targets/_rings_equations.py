"""Normal equations of a line whose bins have parameters of their own and share those of the line (a bordered block
diagonal): as cheap as the bins alone.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibore.targets._marks import Whole
from calibore.targets._rings_strips import Strip

Array = NDArray[Any]

SINGULAR = 1e-12
"""Relative addition to the diagonal."""


@dataclass(eq=False)
class Equations:
    """Normal equations: blocks of the bins `normal` (b, 3, 3), of bins by line `mixed` (b, 3, q), of the line `common`
    (q, q), and the right-hand sides `right` (b, 3), `right_shared` (q,).
    """

    normal: Array
    mixed: Array
    common: Array
    right: Array
    right_shared: Array

    @classmethod
    def summed(cls, slopes: list[Array], weight: Array, residual: Array, strip: Strip, along: Array) -> "Equations":
        count, size = strip.starts.size, len(slopes)
        block, right = np.empty((count, size, size)), np.empty((count, size))
        for row in range(size):
            weighted = slopes[row] * weight
            right[:, row] = np.add.reduceat(weighted * residual, strip.starts)
            for column in range(row, size):
                block[:, row, column] = np.add.reduceat(weighted * slopes[column], strip.starts)
                block[:, column, row] = block[:, row, column]
        mixed = np.concatenate([block[:, :3, 3:5], block[:, :3, 5:] * along[:, None, :]], axis=2)
        common = np.empty((2 + along.shape[1],) * 2)
        common[:2, :2] = block[:, 3:5, 3:5].sum(axis=0)
        common[:2, 2:] = block[:, 3:5, 5].T @ along
        common[2:, :2] = common[:2, 2:].T
        common[2:, 2:] = along.T @ (block[:, 5, 5][:, None] * along)
        right_shared = np.concatenate([right[:, 3:5].sum(axis=0), along.T @ right[:, 5]])
        return cls(block[:, :3, :3], mixed, common, right[:, :3], right_shared)

    def expect(self, weight_shared: Array, shared: Array, weight_width: Array, width: Array) -> None:
        """Add what was known before: how far the line's parameters and the widths are from it, and how surely."""
        self.common[np.diag_indices(len(shared))] += weight_shared
        self.right_shared += weight_shared * shared
        self.normal[:, 2, 2] += weight_width
        self.right[:, 2] += weight_width * width
        self.normal += SINGULAR * np.einsum("bii->bi", self.normal)[:, :, None] * np.eye(3)

    def solved(self, longest: Array) -> tuple[Array, Array]:
        """Steps of the bins (b, 3) and of the line (q,), whose first parameters move by at most `longest`."""
        self.inverse = np.linalg.inv(self.normal)
        self.carried = self.inverse @ self.mixed
        self.reduced = self.common - np.tensordot(self.mixed, self.carried, axes=([0, 1], [0, 1]))
        pull = self.right_shared - np.tensordot(self.carried, self.right, axes=([0, 1], [0, 1]))
        shared = np.linalg.solve(self.reduced, pull)
        shared[: longest.size] = np.clip(shared[: longest.size], -longest, longest)
        return np.einsum("bij,bj->bi", self.inverse, self.right) - self.carried @ shared, shared

    def leverage(self, slopes: list[Array], bins: Whole) -> Array:
        """Variance (n,) that the fit takes from each pixel's residual: a bin's few dark pixels decide its place."""
        own = np.stack(slopes[:3], axis=1)
        return np.einsum("ni,nij,nj->n", own, self.inverse[bins], own)

    def sigma(self) -> Array:
        """Standard uncertainty (b,) of the places."""
        carried = self.carried[:, 1]
        return np.sqrt(self.inverse[:, 1, 1] + np.einsum("bq,bq->b", carried @ np.linalg.inv(self.reduced), carried))
