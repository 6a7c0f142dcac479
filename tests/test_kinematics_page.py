"""The Python of the page on kinematics runs as it stands, block after block."""

import re
from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs" / "kinematics.md"


def test_the_python_of_the_page_runs():
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) > 5
    names: dict[str, object] = {}
    for i, code in enumerate(blocks, start=1):
        exec(compile(code, f"{PAGE.name}, block {i}", "exec"), names)
