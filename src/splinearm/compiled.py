"""The one place where functions on bare arrays are compiled (``direct`` makes calls of them).

Importing this module loads numba (about a quarter of a second), so only kernel modules import it
(``*_kernel.py``), and the doors import those on first use. A kernel compiles when it is first
called, which takes about a second, once: the result lies beside the source, or in the user's
cache folder where that cannot be written. With ``NUMBA_DISABLE_JIT=1`` the same functions run as
plain Python.
"""

import functools
import hashlib
import logging
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba import types
from numba.core import config, event, options

_LOG = logging.getLogger(__name__)

_FAST = {"contract", "nsz", "arcp"}
"""What arithmetic may be rewritten: fused multiply-add, the sign of zero, division by a constant.

Never ``reassoc``, which would undo the exact argument reduction of sine and cosine, nor ``nnan``,
which would let a number that is not finite pass its check.
"""

_UNCOUNTED = {"_nrt": False} if hasattr(options.DefaultOptions, "_nrt") else {}
"""Makes no code for the life of arrays."""

_ROOT = Path(__file__).parent

_SIBLING = re.compile(r"^from \.(\w+) import", re.MULTILINE)

_SIBLINGS = re.compile(r"^from \. import (.+)$", re.MULTILINE)

_NEIGHBOUR = re.compile(r"^from splinearm\.([\w.]+) import", re.MULTILINE)

_Function = TypeVar("_Function", bound=Callable[..., Any])


def kernel(function: _Function) -> _Function:
    """Give ``function`` compiled on first call; its arithmetic is what stands in the source.

    It takes arrays of float64 and numbers, divides as numpy does (by zero: inf or nan, no error)
    and does not check indices.
    """
    return _compiled(function, fastmath=False)


def fast_kernel(function: _Function) -> _Function:
    """Give ``function`` compiled on first call, with fused multiply-add and the like allowed."""
    return _compiled(function, fastmath=_FAST)


def bare_kernel(function: _Function) -> _Function:
    """Give ``function`` compiled like by `fast_kernel`; it makes no arrays and counts none.

    A count of who uses an array costs as much as ten divisions, and is kept wherever one is put
    into a tuple or handed on.
    """
    return _compiled(function, fastmath=_FAST, **_UNCOUNTED)


def inner_kernel(function: _Function) -> _Function:
    """Give ``function`` compiled like by `bare_kernel`, and always into the kernel that calls it.

    Handed to another kernel an array is nine numbers, so that a call with half a dozen of them
    costs as much as a hundred additions. It is for what is called in one place, or is short.
    """
    return _compiled(function, fastmath=_FAST, forceinline=True, **_UNCOUNTED)


def _compiled(function: _Function, *, fastmath: bool | set[str], **more: bool) -> _Function:
    jit = numba.njit(cache=True, error_model="numpy", fastmath=fastmath, **more)
    compiled: _Function = jit(function)
    restamp(compiled, function)
    generalise(compiled)
    return compiled


def generalise(compiled: Any) -> None:  # noqa: ANN401 - numba's
    """Let a kernel that another calls with a constant be compiled for any number, and that once.

    By itself numba compiles it for each constant anew, and once more for what is none.
    """
    wanted = getattr(compiled, "get_call_template", None)
    if wanted is None:  # plain Python
        return

    def template(arguments: Any, keywords: Any) -> Any:  # noqa: ANN401
        plain = {name: types.unliteral(kind) for name, kind in keywords.items()}
        return wanted(tuple(types.unliteral(kind) for kind in arguments), plain)

    compiled.get_call_template = template


def restamp(compiled: object, function: Callable[..., Any]) -> None:
    """Let what is kept on disk of a kernel go stale with any file that it was compiled from."""
    index = getattr(getattr(compiled, "_cache", None), "_cache_file", None)
    if index is not None:
        # numba stamps a cached kernel with its own file only: a kernel compiled against yesterday's
        # version of a function in another file would be taken for fresh
        index._source_stamp = _stamp(Path(function.__code__.co_filename))  # noqa: SLF001


@functools.cache
def _stamp(file: Path) -> str:
    """Give a word that changes when a file changes or one that it imports from, at any depth."""
    files, waiting = set[Path](), [file]
    while waiting:
        at = waiting.pop()
        if at not in files and at.exists():
            files.add(at)
            source = at.read_text(encoding="utf-8")
            siblings = _SIBLING.findall(source)
            for several in _SIBLINGS.findall(source):
                siblings += [name.split()[0] for name in several.split(",") if name.strip()]
            waiting += [at.with_name(f"{name}.py") for name in siblings]
            names = [name.replace(".", "/") for name in _NEIGHBOUR.findall(source)]
            waiting += [_ROOT / f"{name}.py" for name in names]
    stats = [(str(f), f.stat().st_mtime_ns, f.stat().st_size) for f in sorted(files)]
    return hashlib.sha256(repr((stats, numba.__version__)).encode()).hexdigest()


class _FirstCompile(event.Listener):  # type: ignore[misc] # its types are not read
    """Says once a process that kernels are being compiled."""

    def __init__(self) -> None:
        self.said = False

    def on_start(self, event: event.Event) -> None:
        function = event.data["dispatcher"].py_func
        if not function.__module__.startswith("splinearm."):
            return
        if not self.said:
            self.said = True
            _LOG.info("compiling numeric kernels, once; later runs load them from disk")
        _LOG.debug("compiling %s.%s", function.__module__, function.__name__)

    def on_end(self, event: event.Event) -> None:
        """Nothing to say."""


event.register("numba:compile", _FirstCompile())


def inputs(*dimensions: int) -> tuple[Any, ...]:
    """Give the types of contiguous arrays that a kernel only reads, with so many axes each.

    Arrays that may be written to pass as such too, so that one compiled kernel takes both.
    """
    return tuple(types.Array(types.float64, d, "C", readonly=True) for d in dimensions)


def outputs(*dimensions: int) -> tuple[Any, ...]:
    """Give the types of contiguous arrays that a kernel writes to, with so many axes each."""
    return tuple(types.Array(types.float64, d, "C") for d in dimensions)


def numbers(count: int = 1) -> tuple[Any, ...]:
    """Give the types of so many plain numbers."""
    return (types.float64,) * count


def entry(function: _Function, *arguments: Any) -> _Function:  # noqa: ANN401 - numba's types
    """Give a kernel compiled at once, for arguments of these types and no others.

    Anything else is then refused with a TypeError instead of being compiled for. Kernels do not
    call entries: they call what stands behind them.
    """
    if config.DISABLE_JIT:
        return _strict(function, arguments)
    function.compile(arguments)  # type: ignore[attr-defined]
    function.disable_compile()  # type: ignore[attr-defined]
    return function


def _strict(function: _Function, wanted: Sequence[Any]) -> _Function:
    """Give a plain function that takes the same arguments as if it were compiled for them."""

    @functools.wraps(function)
    def checked(*arguments: object) -> object:
        for value, kind in zip(arguments, wanted, strict=True):
            if kind is types.float64:
                if not isinstance(value, int | float):
                    raise TypeError(f"No matching definition: want a number, got {value!r}")
            elif (
                type(value) is not np.ndarray
                or value.dtype != np.float64
                or value.ndim != kind.ndim
                or not value.flags.c_contiguous
                or (kind.mutable and not value.flags.writeable)
            ):
                raise TypeError(f"No matching definition: want {kind}, got {value!r}")
        return function(*arguments)

    return cast(_Function, checked)
