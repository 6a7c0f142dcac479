"""The page on faults says what the table says, and its Python runs."""

import re
from pathlib import Path

import pytest
from fault_table import FAULTS, put_into

from splinearm.cli.main import main
from splinearm.sim.line_fault import LineFault

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture
def page():
    return (DOCS / "faults.md").read_text(encoding="utf-8")


def test_the_table_of_the_page_is_that_of_the_tests(page):
    assert put_into(page) == page, "run: PYTHONPATH=src python tests/faults/fault_table.py"


def test_every_fault_has_a_name_of_its_own():
    names = [fault.name for fault in FAULTS]
    assert len(set(names)) == len(names)
    assert len(names) >= 40


@pytest.mark.bus
def test_the_python_of_the_page_runs(run_page, capsys):
    assert run_page("faults.md") == 2
    said = capsys.readouterr().out
    assert "servo 2 (joint2): it reports overload" in said
    assert said.endswith("finished\n")


def test_the_commands_of_the_page_exist(page, capsys):
    for command in sorted(set(re.findall(r"^splinearm ([a-z-]+)", page, re.MULTILINE))):
        with pytest.raises(SystemExit) as left:
            main([command, "--help"])
        assert left.value.code == 0
    for fault in re.findall(r'--fault "([^"]+)"', page):
        LineFault.parse(fault)
