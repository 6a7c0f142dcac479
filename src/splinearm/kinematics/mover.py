"""The compiled kernels of dynamics, loaded once a process."""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple


class Mover(NamedTuple):
    """The entries of the dynamics kernels; see `dynamics_kernel` and `dynamics_batch_kernel`."""

    inverse: Callable[..., bool]
    inverse_batch: Callable[..., None]
    mass_matrix_batch: Callable[..., None]
    coriolis_batch: Callable[..., None]
    forward_batch: Callable[..., bool]


@cache
def load_mover() -> Mover:
    """Load the kernels, compiling them if need be."""
    from splinearm.compiled import entry, inputs, outputs

    from . import dynamics_batch_kernel as batch
    from . import dynamics_kernel as single

    return Mover(
        entry(single.inverse_call, *inputs(2, 1, 1, 1), *outputs(1)),
        entry(batch.inverse_batch_into, *inputs(2, 2, 2, 2), *outputs(2)),
        entry(batch.mass_matrix_batch_into, *inputs(2, 2), *outputs(3)),
        entry(batch.coriolis_batch_into, *inputs(2, 2, 2), *outputs(3)),
        entry(batch.forward_batch_into, *inputs(2, 2, 2, 2), *outputs(2)),
    )
