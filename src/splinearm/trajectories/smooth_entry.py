"""The compiled functions of smooth time laws, loaded when they are first wanted."""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple


class Kernels(NamedTuple):
    """The compiled functions."""

    rows_into: Callable[..., None]
    use_into: Callable[..., None]
    begin_into: Callable[..., None]
    improve: Callable[..., bool]


@cache
def kernels() -> Kernels:
    """Load the kernels when they are first wanted."""
    from splinearm.compiled import entry, inputs, numbers, outputs

    from . import smooth_kernel as solver
    from . import smooth_row_kernel as row

    path = inputs(1, 3, 1, 1)
    return Kernels(
        entry(row.rows_into, *path, *inputs(2, 2), *outputs(3, 2)),
        entry(row.use_into, *path, *inputs(2, 2, 1), *numbers(), *outputs(2)),
        entry(solver.begin_into, *inputs(1, 1, 1, 3, 2, 2, 3, 3), *outputs(3, 2, 2)),
        entry(
            solver.improve,
            *inputs(1, 1, 3, 1, 3, 2, 2, 3, 3),
            *numbers(),
            *outputs(1, 2, 2, 2, 1),
        ),
    )
