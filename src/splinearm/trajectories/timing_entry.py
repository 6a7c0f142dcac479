"""The compiled functions of timing, loaded when they are first wanted."""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple


class Kernels(NamedTuple):
    """The entries of `row_kernel` and `reachability_kernel`."""

    joint_rows: Callable[..., None]
    fastest: Callable[..., int]
    most_used: Callable[..., float]


class TorqueKernels(NamedTuple):
    """The entries of `torque_kernel`."""

    motion: Callable[..., None]
    lines: Callable[..., None]
    use: Callable[..., None]


@cache
def kernels() -> Kernels:
    """Load the kernels of every law, compiling them if need be."""
    from splinearm.compiled import entry, inputs, outputs

    from . import reachability_kernel as reachability
    from . import row_kernel as row

    return Kernels(
        entry(row.joint_rows_into, *inputs(1, 3, 1, 2), *outputs(1, 3)),
        entry(reachability.fastest_into, *inputs(3, 3, 3, 1, 1), *outputs(1)),
        entry(reachability.most_used, *inputs(3, 3, 3, 1)),
    )


@cache
def torque_kernels() -> TorqueKernels:
    """Load the kernels of laws that torques limit, compiling them if need be."""
    from splinearm.compiled import entry, inputs, outputs

    from . import torque_kernel as torque

    return TorqueKernels(
        entry(torque.motion_into, *inputs(1, 3, 1, 1, 1), *outputs(4)),
        entry(torque.torque_lines_into, *inputs(4, 2, 1, 2, 1), *outputs(3, 4, 1)),
        entry(torque.torque_use_into, *inputs(3, 3, 2), *outputs(2)),
    )
