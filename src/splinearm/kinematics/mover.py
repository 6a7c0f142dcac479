"""The compiled kernels of dynamics, loaded once a process."""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

from splinearm.arrays import FloatArray


class Mover(NamedTuple):
    """The entries of the kernels for many states; see `dynamics_batch_kernel`."""

    inverse_batch: Callable[..., None]
    mass_matrix_batch: Callable[..., None]
    coriolis_batch: Callable[..., None]
    forward_batch: Callable[..., bool]


class Single(NamedTuple):
    """The kernels for one state, bound to a model; see `dynamics_call_kernel`."""

    model: FloatArray
    inverse: Callable[..., bool]
    mass_matrix: Callable[..., bool]
    coriolis: Callable[..., bool]
    forward: Callable[..., bool]

    def __reduce__(self) -> tuple[Callable[..., "Single"], tuple[FloatArray]]:
        return single, (self.model,)


def single(model: FloatArray) -> Single:
    """Load the kernels for one state, compiling them if need be, and bind them to a model."""
    from splinearm.direct import bind

    from . import dynamics_call_kernel as call

    calls = call.inverse_call, call.mass_matrix_call, call.coriolis_call, call.forward_call
    return Single(model, *(bind(each, model) for each in calls))


@cache
def load_mover() -> Mover:
    """Load the kernels, compiling them if need be."""
    from splinearm.compiled import entry, inputs, outputs

    from . import dynamics_batch_kernel as batch

    return Mover(
        entry(batch.inverse_batch_into, *inputs(2, 2, 2, 2), *outputs(2)),
        entry(batch.mass_matrix_batch_into, *inputs(2, 2), *outputs(3)),
        entry(batch.coriolis_batch_into, *inputs(2, 2, 2), *outputs(3)),
        entry(batch.forward_batch_into, *inputs(2, 2, 2, 2), *outputs(2)),
    )
