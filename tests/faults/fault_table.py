"""Every fault that is tried, what the arm does, what is said, and what a person does about it.

The table in ``docs/faults.md`` is made of these rows, and the tests carry every one of them out.
"""

from pathlib import Path

from fault_inside import GEAR, INSIDE, POWER
from fault_outside import COMPUTER, LINE, SILENCE, START
from fault_row import Fault as Fault
from fault_row import Outcome as Outcome

SECTIONS = {
    "On the line": LINE,
    "Silence": SILENCE,
    "Power": POWER,
    "Inside a servo": INSIDE,
    "Gears and horns": GEAR,
    "Computer and adapter": COMPUTER,
    "Before the start": START,
}
FAULTS = tuple(fault for rows in SECTIONS.values() for fault in rows)


def table() -> str:
    """Give the rows as Markdown, a table a section."""
    lines: list[str] = []
    for title, rows in SECTIONS.items():
        lines += [
            "",
            f"### {title}",
            "",
            "| fault | the arm | it says | you |",
            "|---|---|---|---|",
        ]
        for fault in rows:
            arm = "; ".join(filter(None, (fault.outcome.value, fault.more)))
            says = f"`{fault.says}`" if fault.says else ""
            lines.append(f"| {fault.name} | {arm} | {says} | {fault.remedy} |")
    return "\n".join(lines[1:])


def put_into(page: str) -> str:
    """Give a page with the table where it belongs."""
    first, last = "fault_table.py -->\n", "\n<!-- end of the table -->"
    before, after = page.index(first) + len(first), page.index(last)
    return page[:before] + "\n" + table() + "\n" + page[after:]


if __name__ == "__main__":
    PAGE = Path(__file__).parents[2] / "docs" / "faults.md"
    PAGE.write_text(put_into(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
