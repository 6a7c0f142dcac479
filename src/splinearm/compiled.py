"""The one place where functions on bare arrays are compiled.

Importing this module loads numba (about a quarter of a second), so only kernel modules import it
(``*_kernel.py``), and the doors import those on first use. A kernel compiles when it is first
called, which takes about a second, once: the result lies beside the source, or in the user's
cache folder where that cannot be written. With ``NUMBA_DISABLE_JIT=1`` the same functions run as
plain Python.
"""

import ctypes
import functools
import hashlib
import logging
import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeAlias, TypeVar, cast

import numba
import numpy as np
from numba import types
from numba.core import config, event
from numba.core.ccallback import CFunc
from numba.extending import intrinsic

from splinearm.arrays import FloatArray

_LOG = logging.getLogger(__name__)

_FAST = {"contract", "nsz", "arcp"}
"""What arithmetic may be rewritten: fused multiply-add, the sign of zero, division by a constant.

Never ``reassoc``, which would undo the exact argument reduction of sine and cosine, nor ``nnan``,
which would let a number that is not finite pass its check.
"""

_ROOT = Path(__file__).parent

_SIBLING = re.compile(r"^from \.(\w+) import", re.MULTILINE)

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


def _compiled(function: _Function, *, fastmath: bool | set[str]) -> _Function:
    jit = numba.njit(cache=True, error_model="numpy", fastmath=fastmath)
    compiled: _Function = jit(function)
    _restamp(compiled, function)
    _generalise(compiled)
    return compiled


def _generalise(compiled: Any) -> None:  # noqa: ANN401 - numba's
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


def _restamp(compiled: object, function: Callable[..., Any]) -> None:
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
            waiting += [at.with_name(f"{name}.py") for name in _SIBLING.findall(source)]
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


# Direct calls: a compiled function that Python calls like one written in C, which takes 0.1 us less
# than numba's own way and 0.05 us less an array. It reads the headers of its arrays itself, and
# what does not fit is refused. `PyArrayObject_fields` of numpy's C interface says what lies where.

_TYPE, _DATA, _SHAPE, _DTYPE = 1, 2, 4, 7
"""Words of 8 bytes in the header of an array."""
_DIMENSIONS, _FLAGS = 6, 16
"""Words of 4 bytes in the header of an array."""
_LETTERS, _THREE = 6, 0xFFFFFF
"""Word of 4 bytes in a dtype whose first three are its kind, its letter and its byte order."""
READ, WRITE = 0x101, 0x501
"""Flags of an array that is contiguous and aligned, and of one that may be written to as well."""
MODEL = -1
"""Stands for the array that a direct call is bound to."""


def _knows_headers() -> bool:
    """Say whether arrays lie in memory here as numpy's C interface has it for 64 bits."""
    if object.__basicsize__ != 16 or np.ndarray.__basicsize__ < 72 or sys.byteorder != "little":
        return False
    probe = np.zeros((3, 5))
    probe.flags.writeable = False
    words = (ctypes.c_int64 * 9).from_address(id(probe))
    halves = (ctypes.c_int32 * 18).from_address(id(probe))
    return bool(
        words[_TYPE] == id(np.ndarray)
        and words[_DATA] == probe.ctypes.data
        and list((ctypes.c_int64 * 2).from_address(words[_SHAPE])) == [3, 5]
        and words[_DTYPE] == id(probe.dtype)
        and (ctypes.c_char * 3).from_address(id(probe.dtype) + 4 * _LETTERS).raw == b"fd="
        and halves[_DIMENSIONS] == 2
        and halves[_FLAGS] & WRITE == READ
    )


DIRECT = not config.DISABLE_JIT and _knows_headers()
"""Whether direct calls are compiled; where not, they are plain Python around the same kernels."""

Given: TypeAlias = tuple[Any, Any]
"""What a direct call is bound to, and its arguments: addresses where it is compiled."""

if DIRECT:

    @intrinsic  # type: ignore[untyped-decorator] # its types are not read
    def _pointer(_typing: Any, address: Any) -> Any:  # noqa: ANN401 - numba's
        """Give an address as `carray` takes it."""

        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:  # noqa: ANN401
            return builder.inttoptr(values[0], context.get_value_type(signature.return_type))

        return types.voidptr(address), generate

    def _inner(function: _Function) -> _Function:
        """Give what kernels alone call: kept on disk as part of them, not by itself."""
        compiled: _Function = numba.njit(function)
        _generalise(compiled)
        return compiled

    _bool = types.ExternalFunction("PyBool_FromLong", types.intp(types.intp))

    @_inner
    def _header(given: Given, i: int, dimensions: int, flags: int) -> int:
        """Give where the header of an array lies, or 0 if it is not as wanted.

        What the model is, an array of float64, its arguments have to be.
        """
        model, arguments = given
        at = model if i == MODEL else numba.carray(_pointer(arguments), (i + 1,), np.int64)[i]
        words, halves = (
            numba.carray(_pointer(at), (9,), np.int64),
            numba.carray(_pointer(at), (18,), np.int32),
        )
        like = numba.carray(_pointer(model), (9,), np.int64)
        if words[_TYPE] != like[_TYPE]:
            return 0
        # an array that was pickled brings a dtype of its own
        dtype = numba.carray(_pointer(words[_DTYPE]), (7,), np.int32)[_LETTERS]
        wanted = numba.carray(_pointer(like[_DTYPE]), (7,), np.int32)[_LETTERS]
        if (dtype ^ wanted) & _THREE != 0:
            return 0
        fits = halves[_DIMENSIONS] == dimensions and halves[_FLAGS] & flags == flags
        return at if fits else 0

    @_inner
    def vector(given: Given, i: int, flags: int = READ) -> FloatArray:
        """Give an argument that is a contiguous vector; one of length 0 if it is not."""
        at = _header(given, i, 1, flags)
        if at == 0:
            none: FloatArray = numba.carray(_pointer(at), (0,), np.float64)
            return none
        words = numba.carray(_pointer(at), (9,), np.int64)
        shape = numba.carray(_pointer(words[_SHAPE]), (1,), np.int64)
        found: FloatArray = numba.carray(_pointer(words[_DATA]), (shape[0],), np.float64)
        return found

    @_inner
    def matrix(given: Given, i: int, flags: int = READ) -> FloatArray:
        """Give an argument that is a contiguous matrix; one of shape (0, 0) if it is not."""
        at = _header(given, i, 2, flags)
        if at == 0:
            none: FloatArray = numba.carray(_pointer(at), (0, 0), np.float64)
            return none
        words = numba.carray(_pointer(at), (9,), np.int64)
        shape = numba.carray(_pointer(words[_SHAPE]), (2,), np.int64)
        found: FloatArray = numba.carray(_pointer(words[_DATA]), (shape[0], shape[1]), np.float64)
        return found

    @_inner
    def answer(done: int) -> int:
        """Give True or False as a direct call returns it."""
        said: int = _bool(types.intp(done))
        return said

else:

    def _plain(given: Given, i: int, dimensions: int, flags: int) -> FloatArray:
        array = given[0] if i == MODEL else given[1][i]
        fits = (
            type(array) is np.ndarray
            and array.dtype == np.float64
            and array.ndim == dimensions
            and array.flags.c_contiguous
            and (array.flags.writeable or flags == READ)
        )
        return array if fits else np.empty((0,) * dimensions)

    def vector(given: Given, i: int, flags: int = READ) -> FloatArray:
        """Give an argument that is a contiguous vector; one of length 0 if it is not."""
        return _plain(given, i, 1, flags)

    def matrix(given: Given, i: int, flags: int = READ) -> FloatArray:
        """Give an argument that is a contiguous matrix; one of shape (0, 0) if it is not."""
        return _plain(given, i, 2, flags)

    def answer(done: int) -> int:
        """Give True or False as a direct call returns it."""
        return bool(done)


class _Method(ctypes.Structure):
    """How CPython wants a function of C described: `PyMethodDef`."""

    _fields_ = (
        ("name", ctypes.c_char_p),
        ("address", ctypes.c_void_p),
        ("flags", ctypes.c_int),
        ("doc", ctypes.c_char_p),
    )


_METH_FASTCALL = 0x80


@functools.cache
def _method(function: Callable[[Any, Any, int], int]) -> _Method:
    """Compile a direct call, once a process; its description stays."""
    compiled = CFunc(
        function,
        ((types.intp, types.intp, types.intp), types.intp),
        locals={},
        options={"error_model": "numpy"},
    )
    compiled.enable_caching()
    _restamp(compiled, function)
    compiled.compile()
    name = function.__name__.encode()
    return _Method(name, compiled.address, _METH_FASTCALL, None)


def bind(function: Callable[[Any, Any, int], int], model: FloatArray) -> Callable[..., bool]:
    """Give a direct call for one model, to be called with arrays alone; it answers True or False.

    Args:
        function: A function of module level, ``function(model, arguments, count)``, that takes
            what it is given by `vector` and `matrix`, of ``(model, arguments)``, and answers by
            `answer`. It must not raise, and wants to look at ``count`` first.
        model: What it is bound to, an array; it is copied.
    """
    model = np.array(model, dtype=np.float64, order="C")
    if not DIRECT:
        return lambda *arguments: bool(function(model, arguments, len(arguments)))
    make = ctypes.pythonapi.PyCFunction_NewEx
    make.restype = ctypes.py_object
    make.argtypes = (ctypes.c_void_p, ctypes.py_object, ctypes.c_void_p)
    return cast(Callable[..., bool], make(ctypes.addressof(_method(function)), model, None))
