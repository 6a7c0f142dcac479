"""``splinearm doctor [PORT] [--arm ARM]``: what is wrong before anything moves."""

import argparse
import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from splinearm.config import Cell
    from splinearm.doctor.computer import Computer
    from splinearm.doctor.diagnosis import Diagnosis
    from splinearm.doctor.finding import Finding

_CODES = """It never moves anything and never writes to a servo: it reads.

exit codes:
    0  nothing is wrong (hints may be there)
    1  something is wrong: each finding has a code, a cause and what mends it
    2  it could not look: the arm's file cannot be used, or which port is not clear

Each code has a paragraph in docs/troubleshooting.md."""


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "doctor",
        help="say what is wrong with port, line, servos and computer",
        description="Look at this computer, a port and the servos on it, and say what is wrong and "
        "what mends it.",
        epilog=_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "port",
        nargs="?",
        default=None,
        help="the serial port (default: the arm file's, or the only adapter that is there)",
    )
    parser.add_argument("--arm", default=None, help="the arm that should be there: file or name")
    parser.add_argument("--json", action="store_true", help="print it for programs")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Look and tell."""
    from splinearm.doctor.catalogue import in_order
    from splinearm.doctor.computer_check import check_comfort, check_software

    computer = this_computer()
    findings = list(check_software(computer))
    diagnosis = None
    if not any(finding.code in ("C01", "C02") for finding in findings):
        cell = _cell(args.arm)
        port = _port(args.port, cell, computer)
        if port is None:
            findings.append(_no_port())
        else:
            diagnosis = _look(port, cell, args, computer)
            findings += diagnosis.findings
        findings += check_comfort(computer)
    ordered = in_order(findings)
    well = all(finding.severity == "hint" for finding in ordered)
    if args.json:
        print(json.dumps(_document(diagnosis, ordered, well=well), indent=2))
    else:
        _show(diagnosis, ordered)
    return 0 if well else 1


def this_computer() -> "Computer":
    """Give where facts about this computer come from."""
    from splinearm.doctor.computer import Computer

    return Computer()


def _cell(arm: str | None) -> "Cell | None":
    from splinearm.backends import require_chain
    from splinearm.config import load_cell
    from splinearm.config.calibration import calibrated

    if arm is None:
        return None
    cell = load_cell(arm)
    require_chain(cell)
    return calibrated(cell)


def _port(port: str | None, cell: "Cell | None", computer: "Computer") -> str | None:
    """Give the port that is meant; None: there is none.

    Raises:
        ConfigError: If it may be one of several.
    """
    from splinearm.doctor.port_fact import ports
    from splinearm.errors import ConfigError

    if port is not None:
        return port
    there = ports(computer)
    usual = None if cell is None or cell.chain is None else cell.chain.usual_port
    if usual is not None and (computer.device(usual) is not None or len(there) != 1):
        return usual
    if len(there) > 1:
        names = ", ".join(there)
        raise ConfigError("PORT", "", f"there is more than one adapter; name one: {names}")
    return there[0] if there else None


def _no_port() -> "Finding":
    from splinearm.doctor.catalogue import found

    cause = "no port was named, and no adapter is plugged in"
    return found("P01", "this computer", cause, "plug the adapter in and switch its power on")


def _look(
    port: str, cell: "Cell | None", args: argparse.Namespace, computer: "Computer"
) -> "Diagnosis":
    from splinearm.doctor.look import diagnose

    if args.json:
        return diagnose(port, cell, arm=args.arm, computer=computer)
    from .output import console

    with console.status(f"looking at {port}; nothing moves and nothing is written ..."):
        return diagnose(port, cell, arm=args.arm, computer=computer)


def _document(
    diagnosis: "Diagnosis | None", findings: "tuple[Finding, ...]", *, well: bool
) -> dict[str, Any]:
    from splinearm.doctor.finding import SCHEMA

    document: dict[str, Any] = {"schema": SCHEMA, "port": None, "arm": None}
    if diagnosis is not None:
        document |= diagnosis.document()
    return document | {"well": well, "findings": [finding.document() for finding in findings]}


def _show(diagnosis: "Diagnosis | None", findings: "tuple[Finding, ...]") -> None:
    """Print what there is and what is wrong; without rich as plain lines."""
    try:
        from .output import console
    except ImportError:
        for finding in findings:
            print(finding)
        return
    if diagnosis is not None:
        _show_servos(diagnosis)
    if not findings:
        console.print("nothing is wrong")
        return
    _show_findings(findings)


def _show_servos(diagnosis: "Diagnosis") -> None:
    from .output import console, table

    columns = ("id", "servo", "model", "firmware", "V", "degC", "pings", "damaged", "lost")
    rows = [
        tuple("-" if value is None else str(value) for value in servo.values())
        for servo in diagnosis.document()["servos"]
    ]
    if rows:
        console.print(table(columns, rows, title=f"servos on {diagnosis.port}"))
    if diagnosis.pace is not None:
        console.print(f"loop: {diagnosis.pace.words}", markup=False, soft_wrap=True)


def _show_findings(findings: "tuple[Finding, ...]") -> None:
    from .output import console, table

    rows = [(f.code, f.severity.value, f.where, f"{f.what}: {f.cause}") for f in findings]
    console.print(table(("code", "", "where", "what is wrong"), rows))
    console.print("what to do, in this order:")
    # commands are not wrapped, so that they can be copied; what helps many servos is said once
    for line in dict.fromkeys(f"  {f.code}  {f.remedy}" for f in findings):
        console.print(line, markup=False, highlight=False, soft_wrap=True)
    console.print("each code has a paragraph in docs/troubleshooting.md")
