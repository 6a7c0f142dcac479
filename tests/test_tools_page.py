"""The Python of the page on tools runs as it stands, block after block."""

from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"


@pytest.mark.bus
def test_the_python_of_the_page_runs(run_page, capsys):
    assert run_page("tools.md") == 2
    said = capsys.readouterr().out
    assert "joint1" in said
    assert "jogged to" in said


def test_the_page_shows_the_screens_of_the_commands():
    page = (DOCS / "tools.md").read_text(encoding="utf-8")
    screens = sorted((DOCS / "screens").glob("*.txt"))
    assert [file.stem for file in screens] == ["jog", "monitor", "teach"]
    for file in screens:
        assert f"```\n{file.read_text(encoding='utf-8').rstrip()}\n```" in page, file.name
