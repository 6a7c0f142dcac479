"""The model of an arm as one array of numbers, as compiled kernels take it."""

import numpy as np

from splinearm.arrays import FloatArray

from .chain import Chain

KIND = 12
"""Column of the kind of the joint: 0 where it turns, 1 where it slides."""


def pack_kernel(chain: Chain) -> FloatArray:
    """Give a chain as one contiguous array O, shape (n + 1, 13).

    Row k is the constant transform F[k] before joint k: its rotation row-major in columns 0 to 8,
    its translation in 9 to 11, and in column 12 the kind of the joint that follows it, 0 where it
    turns and 1 where it slides. The last row is the transform to the tool, with a 0. The array is
    left writeable, since numba would compile every kernel once more for arrays that are not; arrays
    handed to kernels beside it want to be contiguous and writeable for the same reason.
    """
    n = len(chain.turns)
    packed = np.zeros((n + 1, 13))
    packed[:, :9] = chain.fixed[:, :3, :3].reshape(n + 1, 9)
    packed[:, 9:12] = chain.fixed[:, :3, 3]
    packed[:n, KIND] = chain.slides
    return packed
