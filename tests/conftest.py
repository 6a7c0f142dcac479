"""What tests of more than one room share."""

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

# the same examples in every run, so that a change is judged by itself; HYPOTHESIS_PROFILE=default
# draws new ones
settings.register_profile("check", derandomize=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "check"))

DOCS = Path(__file__).parents[1] / "docs"


_FIRST = (("kinematics", "curves", "trajectories"), ("toolpaths", "sim", "drivers", "control"))
"""Rooms whose tests compile most, in two groups that have few kernels in common."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Let files of the two groups take turns, and those that use all rooms come last.

    Neighbours of one room compile the same kernels: workers beside each other would all do that.
    """
    turns: dict[Path, tuple[int, int]] = {}
    counts = [0] * (len(_FIRST) + 1)
    for file in dict.fromkeys(item.path for item in items):
        group = next((k for k, rooms in enumerate(_FIRST) if file.parent.name in rooms), 2)
        turns[file] = (counts[group] if group < len(_FIRST) else len(items), group)
        counts[group] += 1
    items.sort(key=lambda item: turns[item.path])


@pytest.fixture(scope="session", autouse=True)
def user_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """The folder of a user's own files, empty at first: here and in what is started from here."""
    folder = tmp_path_factory.mktemp("home")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SPLINEARM_HOME", str(folder))
        yield folder


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
