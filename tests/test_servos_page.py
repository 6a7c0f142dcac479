"""The Python of the page on arms of servos runs as it stands, block after block."""

import pytest


@pytest.mark.bus
def test_the_python_of_the_page_runs(run_page, capsys):
    assert run_page("servos.md") == 6
    said = capsys.readouterr().out
    assert "FINISHED SUCCESSFUL" in said
    assert "recovered: servo 1" in said
    assert said.count("FINISHED") == 2
    assert "gripper: " in said
