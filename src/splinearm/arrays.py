"""The one check that arrays pass when they enter a value type."""

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

FloatArray: TypeAlias = npt.NDArray[np.float64]
"""An array of float64."""

ArrayInput: TypeAlias = npt.ArrayLike
"""What a user may pass where an array is wanted."""


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
    if array.ndim != len(shape) or any(
        want not in (None, have) for want, have in zip(shape, array.shape, strict=True)
    ):
        wanted = ", ".join("any" if size is None else str(size) for size in shape)
        raise ValueError(f"{name}: want shape ({wanted}), got {array.shape}")
    if np.isnan(array).any() or (finite and not np.isfinite(array).all()):
        raise ValueError(f"{name}: want finite numbers, got {array.tolist()}")
    array.flags.writeable = False
    return array
