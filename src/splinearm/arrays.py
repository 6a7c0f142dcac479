"""The one check that arrays pass when they enter a value type."""

from collections.abc import Sequence
from math import isfinite
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

FloatArray: TypeAlias = npt.NDArray[np.float64]
"""An array of float64."""

ArrayInput: TypeAlias = npt.ArrayLike
"""What a user may pass where an array is wanted."""

_FEW = 32


def frozen_array(
    values: npt.ArrayLike,
    shape: Sequence[int | None],
    name: str,
    *,
    finite: bool = True,
) -> FloatArray:
    """Give a read-only contiguous float64 copy of ``values``, its shape and numbers checked.

    Args:
        values: Anything numpy can turn into an array of real numbers.
        shape: The wanted shape; ``None`` stands for any length along that axis.
        name: What the array is called in the error.
        finite: Whether infinities are refused. NaN is refused in either case.

    Raises:
        ValueError: If the numbers are not real, not of that shape, NaN, or not finite.
    """
    try:
        array = np.array(values, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: want an array of numbers, got {values!r}") from error
    if array.shape != shape and (
        array.ndim != len(shape)
        or any(want not in (None, have) for want, have in zip(shape, array.shape, strict=True))
    ):
        wanted = ", ".join("any" if size is None else str(size) for size in shape)
        raise ValueError(f"{name}: want shape ({wanted}), got {array.shape}")
    if not _is_finite(array) and (finite or np.isnan(array).any()):
        raise ValueError(f"{name}: want finite numbers, got {array.tolist()}")
    array.setflags(write=False)
    return array


def _is_finite(array: FloatArray) -> bool:
    """Tell whether all numbers are finite; of few numbers sooner than numpy does."""
    if array.size <= _FEW:
        return all(map(isfinite, array.ravel().tolist()))
    return bool(np.isfinite(array).all())
