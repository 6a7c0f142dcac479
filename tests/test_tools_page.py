"""The Python of the page on tools runs as it stands, block after block."""

import pytest


@pytest.mark.bus
@pytest.mark.kernel
def test_the_python_of_the_page_runs(run_page, capsys):
    assert run_page("tools.md") == 2
    said = capsys.readouterr().out
    assert "joint1" in said
    assert "jogged to" in said
