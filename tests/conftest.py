"""What tests of more than one room share."""

import getpass
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import settings
from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import Dispatcher

from splinearm.backends import Station
from splinearm.drivers.base import ArmDriver
from splinearm.joints import JointSetpoint

try:
    import fcntl
except ImportError:  # no files that lock there: workers compile what others compile too
    fcntl = None  # type: ignore[assignment]

# the same examples in every run, so that a change is judged by itself; HYPOTHESIS_PROFILE=default
# draws new ones
settings.register_profile("check", derandomize=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "check"))

DOCS = Path(__file__).parents[1] / "docs"


_FIRST = (("kinematics", "curves", "trajectories"), ("toolpaths", "sim", "drivers", "control"))
"""Rooms whose tests compile most, in two groups that have few kernels in common."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Let files of the two groups take turns, then those that use all rooms, last those with a bus.

    Neighbours of one room compile the same kernels: workers beside each other would wait for each
    other. Servos that live by the clock want processors that are not busy with compiling.
    """
    last = len(_FIRST)
    with_bus = {item.path for item in items if item.get_closest_marker("bus")}
    turns: dict[Path, tuple[int, int]] = {}
    counts = [0] * last
    for file in dict.fromkeys(item.path for item in items):
        group = next((k for k, rooms in enumerate(_FIRST) if file.parent.name in rooms), last)
        if file in with_bus:
            turns[file] = (len(items), last + 1)
        elif group == last:
            turns[file] = (len(items), last)
        else:
            turns[file] = (counts[group], group)
            counts[group] += 1
    items.sort(key=lambda item: turns[item.path])


_compile = Dispatcher.compile
_LOCKS = Path(tempfile.gettempdir()) / f"splinearm-locks-{getpass.getuser()}"
"""Where workers say to each other what they compile; each user's own."""
_at_it = set[str]()
"""Kernels that this worker compiles, with those that they call."""


def _compile_once(kernel: Any, signature: Any) -> Any:
    """Compile a kernel, or wait for the worker that is at it and take what that left on disk."""
    name = f"{kernel.py_func.__module__}.{kernel.py_func.__qualname__}"
    if name in _at_it:
        return _compile(kernel, signature)
    with global_compiler_lock, (_LOCKS / f"{name}.lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        _at_it.add(name)
        tracer = sys.gettrace()
        sys.settrace(None)  # to measure the coverage of the compiler would take a third longer
        try:
            return _compile(kernel, signature)
        finally:
            sys.settrace(tracer)
            _at_it.discard(name)


if fcntl is not None:
    _LOCKS.mkdir(exist_ok=True)
    Dispatcher.compile = _compile_once


@pytest.fixture(scope="session", autouse=True)
def user_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The folder of a user's own files, empty at first: here and in what is started from here."""
    folder = tmp_path_factory.mktemp("home")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SPLINEARM_HOME", str(folder))
        yield folder


class _Interrupted:
    """An arm that lets Ctrl-C be pressed at a setpoint."""

    def __init__(self, driver: ArmDriver, at: int) -> None:
        self.driver, self.at = driver, at

    def __getattr__(self, name: str) -> object:
        return getattr(self.driver, name)

    def write(self, setpoint: JointSetpoint) -> None:
        self.driver.write(setpoint)
        self.at -= 1
        if self.at == 0:
            os.kill(os.getpid(), signal.SIGINT)


@pytest.fixture(scope="session")
def interrupted() -> Callable[[Station, int], Station]:
    """Gives a station as one where Ctrl-C is pressed at the n-th setpoint."""
    return lambda station, at: replace(station, driver=_Interrupted(station.driver, at))


@pytest.fixture(autouse=True)
def untraced(request: pytest.FixtureRequest) -> Iterator[None]:
    """Trace no thread for coverage that begins in a test with a bus, but of the simulation's own.

    Traced servos take four times as long to think, and those who speak to them do not wait.
    """
    if not request.node.get_closest_marker("bus") or request.path.parent.name == "sim":
        yield
        return
    before = threading.gettrace()
    threading.settrace(None)  # type: ignore[arg-type]
    try:
        yield
    finally:
        threading.settrace(before)  # type: ignore[arg-type]


@pytest.fixture
def run_page() -> Callable[[str], int]:
    """Runs the Python of a page as it stands, block after block, and gives how many there are."""

    def run(name: str) -> int:
        text = (DOCS / name).read_text(encoding="utf-8")
        blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
        names: dict[str, object] = {}
        for i, code in enumerate(blocks, start=1):
            exec(compile(code, f"{name}, block {i}", "exec"), names)
        return len(blocks)

    return run


def _python(code: str, *arguments: str, given: str = "", **environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code, *arguments],
        input=given,
        capture_output=True,
        text=True,
        env={**os.environ, **environment},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="session")
def python() -> Callable[..., str]:
    """Runs code in a process of its own, warnings as errors, and gives what it prints."""
    return _python


@pytest.fixture(scope="session")
def compiled_as_plain() -> Callable[..., None]:
    """Runs code with compiled kernels and with plain ones and compares its list ``found``.

    Arrays agree to ``rtol``, and to ``atol`` of their largest number or of 1.
    """

    def check(
        code: str, count: int, *, given: str = "", rtol: float = 0.0, atol: float = 1e-12
    ) -> None:
        code += "\nimport json, numpy\nprint(json.dumps([numpy.ravel(a).tolist() for a in found]))"
        compiled, plain = (
            json.loads(_python(code, given=given, NUMBA_DISABLE_JIT=off)) for off in "01"
        )
        assert len(compiled) == len(plain) == count
        for one, other in zip(compiled, plain, strict=True):
            scale = max(1.0, np.abs(other).max(initial=0.0))
            np.testing.assert_allclose(one, other, rtol=rtol, atol=atol * scale)

    return check


@pytest.fixture(scope="session")
def rs274(
    tmp_path_factory: pytest.TempPathFactory,
) -> Callable[..., "subprocess.CompletedProcess[str]"]:
    """Lets LinuxCNC's interpreter read a program to its end; skips where it is not installed."""
    if shutil.which("rs274") is None:
        pytest.skip("LinuxCNC's rs274 (linuxcnc-uspace) is not installed")
    # the table of tools goes through a file in the home folder, which every start makes anew: one
    # that still reads it is then ended by a bus error, so each worker has a home of its own
    home = tmp_path_factory.mktemp("rs274")

    def read(
        file: Path, tools: str = "T1 P1 D0.25 Z0\n", *, ends: bool = True
    ) -> "subprocess.CompletedProcess[str]":
        (home / "tool.tbl").write_text(tools)
        done = subprocess.run(
            ["rs274", "-t", home / "tool.tbl", "-g", file],
            capture_output=True, text=True, check=False, timeout=60, errors="replace",
            stdin=subprocess.DEVNULL, cwd=file.parent, env={**os.environ, "HOME": str(home)},
        )  # fmt: skip
        said = f"{done.stdout[-400:]}\n{done.stderr[-400:]}"
        assert done.returncode >= 0, f"rs274 was ended by signal {-done.returncode}: {said}"
        assert "PROGRAM_END" in done.stdout or not ends, f"rs274 refuses it: {said}"
        return done

    return read
