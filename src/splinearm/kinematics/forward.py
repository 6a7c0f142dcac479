"""Which code works out forward kinematics: numpy, or compiled kernels once they are wanted.

Loading numba and the kernels takes about a fifth of a second, and the first time on a machine,
when they are compiled, some seconds. So numpy answers until kernels are asked for: by `load`, by a
call with ``out=``, or by a batch of `HEAVY` joint vectors or more. A single call never starts the
compiler, and so never holds up a control loop. The two ways agree to 1e-14 of the arm's size, not
bit by bit.
"""

from collections.abc import Callable
from types import ModuleType
from typing import Final, NamedTuple

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray

from . import chain
from .chain import Chain

HEAVY = 20_000
"""Size of a batch from which on loading the kernels pays off."""


class _Loaded:
    """The kernels that this process has loaded; None: not yet."""

    single: ModuleType | None = None
    batch: ModuleType | None = None


class Bare(NamedTuple):
    """Forward kinematics of one arm with nothing around it, for the tightest loops.

    The functions take contiguous arrays of float64 and answer False, having written nothing of
    use, where an argument is anything else or a joint position is not finite.
    """

    numbers: FloatArray
    """The arm, packed, shape (n + 1, 13)."""
    fk: Callable[[ArrayInput, FloatArray], bool]
    """``fk(q, T)``: write T_base_tool, shape (4, 4), at joint positions, shape (n,)."""
    jacobian: Callable[[ArrayInput, FloatArray], bool]
    """``jacobian(q, J)``: write the Jacobian in base, shape (6, n), at joint positions."""

    def __reduce__(self) -> tuple[Callable[..., "Bare"], tuple[FloatArray]]:
        return bare, (self.numbers,)


def _not_loaded(_q: ArrayInput, _out: FloatArray) -> bool:
    return False


NOT_LOADED: Final = Bare(np.zeros((0, 13)), _not_loaded, _not_loaded)
"""What stands for the kernels of an arm as long as they are not loaded."""

LOADED = _Loaded()
"""What is loaded; the arm's methods look here at each call."""


def load() -> None:
    """Load the kernels of single calls and of batches, compiling them if need be."""
    bare(np.zeros((2, 13)))
    load_batch()


def bare(O: FloatArray) -> Bare:
    """Give the kernels of single calls bound to one arm, loading them if need be."""
    if len(O) == 0:
        return NOT_LOADED
    from splinearm.direct import bind

    from . import forward_kernel

    LOADED.single = forward_kernel
    return Bare(O, bind(forward_kernel.fk_call, O), bind(forward_kernel.jacobian_call, O))


def load_batch() -> ModuleType:
    """Load the kernels of batches and give their module."""
    if LOADED.batch is None:
        from splinearm.compiled import entry, inputs, outputs

        from . import batch_kernel

        entry(batch_kernel.fk_batch_into, *inputs(2, 2), *outputs(3))
        entry(batch_kernel.frames_batch_into, *inputs(2, 2, 2), *outputs(4))
        entry(batch_kernel.jacobian_batch_into, *inputs(2, 2), *outputs(3))
        LOADED.batch = batch_kernel
    return LOADED.batch


def fk(
    model: Chain, O: FloatArray, single: Bare, q: FloatArray, out: FloatArray | None
) -> FloatArray:
    """Give T_base_tool, shape (..., 4, 4), at joint vectors that are checked, shape (..., n)."""
    shape = (*q.shape[:-1], 4, 4)
    rows = q.reshape(-1, q.shape[-1])
    if q.ndim == 1:
        if single is NOT_LOADED:
            return chain.fk(model, q)
        return _written(single.fk, chain.fk, model, q, answer(out, shape))
    if out is None and _light(rows):
        return chain.fk_batch(model, rows).reshape(shape)
    T = answer(out, shape)
    load_batch().fk_batch_into(O, np.ascontiguousarray(rows), T.reshape(-1, 4, 4))
    return T


def frames(model: Chain, O: FloatArray, q: FloatArray, out: FloatArray | None) -> FloatArray:
    """Give the pose of each link frame, shape (..., n, 4, 4), at joint vectors (..., n)."""
    n = q.shape[-1]
    shape = (*q.shape, 4, 4)
    rows = q.reshape(-1, n)
    if out is None and _light(rows):
        return chain.frames_batch(model, rows).reshape(shape)
    L = np.empty((n, 12))
    L[:, :9] = model.joint_link[:, :3, :3].reshape(n, 9)
    L[:, 9:] = model.joint_link[:, :3, 3]
    Ts = answer(out, shape)
    load_batch().frames_batch_into(O, L, np.ascontiguousarray(rows), Ts.reshape(-1, n, 4, 4))
    return Ts


def jacobian(
    model: Chain, O: FloatArray, single: Bare, q: FloatArray, out: FloatArray | None
) -> FloatArray:
    """Give the Jacobian in base, shape (..., 6, n), at joint vectors, shape (..., n)."""
    n = q.shape[-1]
    shape = (*q.shape[:-1], 6, n)
    rows = q.reshape(-1, n)
    if q.ndim == 1:
        if single is NOT_LOADED:
            return chain.fk_and_jacobian(model, q)[1]
        return _written(single.jacobian, _plain_jacobian, model, q, answer(out, shape))
    if out is None and _light(rows):
        return chain.jacobian_batch(model, rows).reshape(shape)
    J = answer(out, shape)
    load_batch().jacobian_batch_into(O, np.ascontiguousarray(rows), J.reshape(-1, 6, n))
    return J


def _written(
    work: Callable[[ArrayInput, FloatArray], bool],
    plain: Callable[[Chain, FloatArray], FloatArray],
    model: Chain,
    q: FloatArray,
    out: FloatArray,
) -> FloatArray:
    """Write what a kernel finds at a joint vector that it did not take as it came."""
    found = np.empty(out.shape)
    taken = work(np.array(q, dtype=np.float64, order="C"), found)
    out[...] = found if taken else plain(model, q)
    return out


def _plain_jacobian(model: Chain, q: FloatArray) -> FloatArray:
    return chain.fk_and_jacobian(model, q)[1]


def _light(rows: FloatArray) -> bool:
    """Say whether numpy is to work on these."""
    return LOADED.batch is None and len(rows) < HEAVY


def answer(out: FloatArray | None, shape: tuple[int, ...]) -> FloatArray:
    """Give the array to write to after checking the one that came, or a new one."""
    if out is None:
        return np.empty(shape)
    dtype = getattr(out, "dtype", None)
    if type(out) is not np.ndarray or dtype != np.float64:
        kind = f"an array of {dtype}" if dtype is not None else repr(out)
        raise TypeError(f"out: want an array of float64, got {kind}")
    if out.shape != shape:
        raise ValueError(f"out: want shape {shape}, got {out.shape}")
    if not (out.flags.c_contiguous and out.flags.writeable):
        raise ValueError("out: want an array that is contiguous and may be written to")
    return out
