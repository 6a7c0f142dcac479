"""docs/troubleshooting.md: its table is made of the faults that the tests inject.

``python tests/doctor/test_page.py`` writes the table anew.
"""

import re
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from computer_cases import COMPUTER_CASES, SILENT_CASES
from line_cases import LINE_CASES

from splinearm.doctor.catalogue import AILMENTS, found, in_order
from splinearm.doctor.finding import Severity

PAGE = Path(__file__).parents[2] / "docs" / "troubleshooting.md"
BEGIN, END = "<!-- faults: begin -->\n", "<!-- faults: end -->\n"
OTHERS = {
    "P08": "the port vanishes while it is looked at",
    "C08": "a loop of 300 Hz on a line that allows 641 Hz",
}
"""What is injected elsewhere: ``test_healthy`` and ``test_pace``."""


def injected() -> dict[str, list[str]]:
    """Give by code what the tests do."""
    acts: dict[str, list[str]] = {}
    for case in (*COMPUTER_CASES, *SILENT_CASES, *LINE_CASES):
        acts.setdefault(case.code, []).append(case.act)
    for code, act in OTHERS.items():
        acts.setdefault(code, []).append(act)
    return acts


def anchor(title: str) -> str:
    """Give what a page's reader makes of a title."""
    return re.sub(r"[^a-z0-9 -]", "", title.lower()).replace(" ", "-")


def table() -> str:
    """Give the table, the first to be mended first."""
    lines = [
        "| code | what is wrong | what mends it | injected in the tests |",
        "|---|---|---|---|",
    ]
    acts = injected()
    ordered = in_order([found(a.code, "", "", "") for a in AILMENTS])
    by_code = {ailment.code: ailment for ailment in AILMENTS}
    for finding in ordered:
        ailment = by_code[finding.code]
        link = f"[{ailment.code}](#{anchor(f'{ailment.code} {ailment.what}')})"
        told = "; ".join(acts[ailment.code])
        lines.append(
            f"| {link} | {ailment.what} ({ailment.severity}) | {ailment.remedy} | {told} |"
        )
    return "\n".join(lines) + "\n"


def test_the_table_is_that_of_the_faults_in_the_tests():
    text = PAGE.read_text(encoding="utf-8")
    assert text.split(BEGIN)[1].split(END)[0] == table()


def test_every_code_is_injected():
    assert set(injected()) == {ailment.code for ailment in AILMENTS}
    assert len({ailment.code for ailment in AILMENTS}) == len(AILMENTS)


def test_every_code_has_its_paragraph():
    text = PAGE.read_text(encoding="utf-8")
    pieces = re.split(r"^### (.+)\n", text, flags=re.MULTILINE)
    paragraphs = dict(zip(pieces[1::2], pieces[2::2], strict=True))
    assert set(paragraphs) == {f"{ailment.code} {ailment.what}" for ailment in AILMENTS}
    for title, paragraph in paragraphs.items():
        words = paragraph.partition("\n## ")[0].split()
        assert len(words) >= 25, title


def test_errors_come_first_and_hints_last_each_in_the_order_of_the_catalogue():
    codes = ["C06", "S04", "L04", "C02", "L05"]
    hint = found("L02", "", "", "", severity=Severity.HINT)
    ordered = in_order([hint, *(found(code, "", "", "") for code in codes)])
    assert [finding.code for finding in ordered] == ["C02", "L05", "L04", "S04", "L02", "C06"]


if __name__ == "__main__":
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    PAGE.write_text(before + BEGIN + table() + END + rest.partition(END)[2], encoding="utf-8")
