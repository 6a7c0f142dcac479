"""The commands of the page on toolpaths: from a drawing to an arm that engraves it."""

import re
import shlex
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


@pytest.mark.sim
def test_a_simulated_arm_engraves_the_part_of_the_page(cli, tmp_path):
    pytest.importorskip("ezdxf")
    page = (ROOT / "docs" / "toolpaths.md").read_text(encoding="utf-8")
    block = re.search(r"## On an arm.*?```\n(.*?)```", page, re.DOTALL)
    commands = [shlex.split(line) for line in block[1].splitlines()]
    assert len(commands) == 2
    for command in commands:
        words = [str(ROOT / w) if w.startswith("examples/") else w for w in command[1:]]
        assert cli(*words) == 0, cli.err
    assert "finished (SUCCESSFUL, 0)" in cli.out
    off = re.search(r"tool off its path, measured\s*\S\s*([0-9.]+)\s*\S\s*([0-9.]+)", cli.out)
    assert float(off[2]) < 0.3
    assert (tmp_path / "bracket-engraved.ngc").is_file()
