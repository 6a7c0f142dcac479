"""What tests of more than one room share."""

import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import settings

# the same examples in every run, so that a change is judged by itself; HYPOTHESIS_PROFILE=default
# draws new ones
settings.register_profile("check", derandomize=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "check"))

DOCS = Path(__file__).parents[1] / "docs"


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
