"""The Python of the page on toolpaths runs as it stands, block after block."""

from pathlib import Path

import pytest


def test_the_python_of_the_page_runs(run_page, monkeypatch):
    pytest.importorskip("ezdxf")
    monkeypatch.chdir(Path(__file__).parents[1])
    assert run_page("toolpaths.md") >= 6
