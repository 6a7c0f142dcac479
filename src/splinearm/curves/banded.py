"""Linear systems whose matrix has its numbers near the diagonal, on bare arrays."""

import functools
from collections.abc import Callable

import numpy as np

from splinearm.arrays import FloatArray

from .basis import IndexArray


def solve(
    first: IndexArray, values: FloatArray, rhs: FloatArray, *, closed: bool = False
) -> FloatArray:
    """Solve A x = b by elimination without pivoting, which collocation matrices allow.

    Args:
        first: Column of each row's first entry, shape (n,), never falling.
        values: Entries of each row, side by side, shape (n, w).
        rhs: Right sides, shape (n, dim).
        closed: Whether columns before the first and beyond the last wrap around.

    Raises:
        numpy.linalg.LinAlgError: If the matrix is singular.
    """
    # total positivity makes elimination without pivoting stable: de Boor and Pinkus, Backward
    # error analysis for totally positive linear systems, Numer. Math. 27 (1977) 485
    n, width = values.shape
    if n <= 4 * width:
        # rows as large as each other: those of derivatives follow the scale of the parameter
        scale = np.abs(values).max(axis=1, keepdims=True)
        if not (scale > 0.0).all():
            raise np.linalg.LinAlgError("singular matrix")
        solved = np.linalg.solve(_dense(first, values / scale), rhs / scale)
        return np.asarray(solved, dtype=np.float64)
    if closed:
        return _solve_bordered(first, values, rhs, width)
    return _eliminate(first, values, rhs)


def _dense(first: IndexArray, values: FloatArray) -> FloatArray:
    n, width = values.shape
    matrix = np.zeros((n, n))
    columns = (first[:, None] + np.arange(width)) % n
    np.add.at(matrix, (np.arange(n)[:, None], columns), values)
    return matrix


def _solve_bordered(
    first: IndexArray, values: FloatArray, rhs: FloatArray, border: int
) -> FloatArray:
    """Solve a closed system: its last columns and rows by a small dense complement."""
    n, width = values.shape
    k = n - border
    columns = (first[:, None] + np.arange(width)) % n
    rows = np.broadcast_to(np.arange(n)[:, None], columns.shape)
    inside = columns < k
    right = np.zeros((n, border))
    np.add.at(right, (rows[~inside], columns[~inside] - k), values[~inside])
    below = np.zeros((border, k))
    low = inside & (rows >= k)
    np.add.at(below, (rows[low] - k, columns[low]), values[low])
    kept = np.where(inside, values, 0.0)[:k]
    solved = _eliminate(first[:k], kept, np.hstack((rhs[:k], right[:k])))
    plain, carried = solved[:, : rhs.shape[1]], solved[:, rhs.shape[1] :]
    corner = np.linalg.solve(right[k:] - below @ carried, rhs[k:] - below @ plain)
    return np.vstack((plain - carried @ corner, corner))


def _eliminate(first: IndexArray, values: FloatArray, rhs: FloatArray) -> FloatArray:
    """Solve a system whose row i has its entries around column i."""
    x = np.array(rhs, dtype=np.float64, order="C")
    rows = np.ascontiguousarray(values, dtype=np.float64)
    if _kernel()(first.astype(np.float64), rows, x):
        raise np.linalg.LinAlgError("singular matrix")
    return x


@functools.cache
def _kernel() -> Callable[..., int]:
    """Give the elimination, compiled for its arguments."""
    from splinearm.compiled import entry, inputs, outputs

    from . import collocation_kernel

    return entry(collocation_kernel.eliminate, *inputs(1, 2), *outputs(2))
