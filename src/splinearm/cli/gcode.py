"""``splinearm gcode check FILE``: what an NC program means, and whether a controller takes it."""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from .gcode_verify import add_words, verified
from .ways_report import ways_document, ways_facts

if TYPE_CHECKING:
    from splinearm.toolpaths.cutter import Cutter
    from splinearm.toolpaths.gcode_lint import Finding
    from splinearm.toolpaths.gcode_machine import NcMachine
    from splinearm.toolpaths.summary import Summary


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "gcode",
        help="look at an NC program",
        description="Read an NC program with its meaning, as LinuxCNC does.",
    )
    verbs = parser.add_subparsers(title="commands", dest="verb", metavar="COMMAND", required=True)
    check = verbs.add_parser(
        "check",
        help="say what a program means and whether a controller takes it",
        description="Read a program to its end: its extent, lengths, feeds and tools. With "
        "--dialect also say what that controller does not take, with --part whether it cuts what "
        "it should. Exit code 1 if there is anything wrong.",
    )
    check.add_argument("file", type=Path, help="the program")
    check.add_argument(
        "--dialect", default=None, metavar="NAME", help="the controller: linuxcnc or grbl"
    )
    check.add_argument(
        "--tools", type=Path, default=None, metavar="FILE", help="table of cutters (TOML)"
    )
    check.add_argument("--inches", action="store_true", help="begin in inches, not in mm")
    check.add_argument(
        "--block-delete", action="store_true", help="leave out lines that begin with /"
    )
    check.add_argument("--json", action="store_true", help="print JSON")
    add_words(check)
    check.set_defaults(run=run_check)


def run_check(args: argparse.Namespace) -> int:
    """Read the program and print what it amounts to."""
    from splinearm.errors import ConfigError
    from splinearm.toolpaths.gcode_dialect import dialect_of
    from splinearm.toolpaths.gcode_flow import read_program
    from splinearm.toolpaths.gcode_interpreter import run_gcode
    from splinearm.toolpaths.gcode_lint import lint
    from splinearm.toolpaths.summary import summarise

    try:
        dialect = None if args.dialect is None else dialect_of(args.dialect)
    except ValueError as error:
        raise ConfigError("--dialect", "", str(error)) from error
    cutters = _cutters(args)
    machine = _machine(args, cutters)
    actions = run_gcode(args.file, machine)
    findings: list[Finding] = []
    if dialect is not None:
        text = args.file.read_text(encoding="utf-8", errors="replace")
        findings = lint(read_program(text, str(args.file)), text, dialect)
    summary = summarise(actions)
    found = verified(args, machine, cutters)
    if args.json:
        document = _document(summary, findings)
        document["verification"] = None if found is None else found.document()
        print(json.dumps(document, indent=2))
    else:
        _print(args.file, summary, findings, args.dialect)
        if found is not None:
            print(found.text())
    return 1 if findings or not (found is None or found.ok) else 0


def _cutters(args: argparse.Namespace) -> "dict[int, Cutter]":
    from splinearm.config.tool_table import load_tools

    return {} if args.tools is None else load_tools(args.tools)


def _machine(args: argparse.Namespace, cutters: "dict[int, Cutter]") -> "NcMachine":
    from splinearm.toolpaths.gcode_machine import NcMachine, NcTool

    return NcMachine(
        tools={number: NcTool(diameter=tool.diameter) for number, tool in cutters.items()},
        inches=args.inches,
        block_delete=args.block_delete,
    )


def _print(
    file: Path, summary: "Summary", findings: "Sequence[Finding]", dialect: str | None
) -> None:
    from .output import console, table

    rows = [[name, value] for name, value in _facts(summary).items()]
    console.print(table(("", str(file)), rows))
    for finding in findings:
        console.print(f"{file}: {finding}", highlight=False, markup=False)
    if dialect is not None and not findings:
        console.print(f"{dialect} takes all of it")


def _facts(summary: "Summary") -> dict[str, str]:
    facts = {
        **ways_facts(summary),
        "cutting": f"{summary.cutting_length * 1e3:.1f} mm, {summary.cutting_time:.1f} s at least",
        "rapid": f"{summary.rapid_length * 1e3:.1f} mm",
    }
    if summary.slowest is not None and summary.quickest is not None:
        slow, quick = (feed * 60e3 for feed in (summary.slowest, summary.quickest))
        facts["feed"] = (
            f"{slow:.6g} to {quick:.6g} mm/min" if slow != quick else f"{slow:.6g} mm/min"
        )
    if summary.dwell_time:
        facts["rests"] = f"{summary.dwell_time:.1f} s"
    if summary.tools:
        facts["tools"] = ", ".join(map(str, summary.tools))
    return facts


def _document(summary: "Summary", findings: "Sequence[Finding]") -> dict[str, object]:
    """Give what a program reads: lengths in m, times in s, feeds in m/s."""
    return {
        **ways_document(summary),
        "dwell_time": summary.dwell_time,
        "tools": list(summary.tools),
        "findings": [
            {"line": each.line, "word": each.word, "reason": each.reason} for each in findings
        ],
    }
