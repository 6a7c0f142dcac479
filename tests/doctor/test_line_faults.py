"""Each fault of the line, of servos and of arm files is found, with its cause and its remedy."""

import re

import pytest
from line_cases import LINE_CASES

from splinearm.doctor.finding import Severity
from splinearm.doctor.look import Effort, diagnose

pytestmark = pytest.mark.bus

LOOK = Effort(pings=30, cycles=0)
CLOSE_LOOK = Effort(pings=75, cycles=0)  # of lines on which some answers are bad


@pytest.mark.parametrize("case", LINE_CASES, ids=lambda case: f"{case.code} {case.act}")
def test_a_fault_is_found_with_cause_and_remedy(case, virtual, monkeypatch):
    effort = LOOK
    if case.code in ("L07", "L08"):  # what is lost need not be waited for as on a busy computer
        monkeypatch.setattr("splinearm.doctor.look.PATIENCE", 0.0)
        effort = CLOSE_LOOK
    with virtual(case.arm, case.transport, **case.wiring) as (cell, bus):
        with bus.lock:
            case.hurt(bus)
        diagnosis = diagnose(bus.port, case.cell(cell), arm=case.arm, effort=effort)
    codes = {finding.code for finding in diagnosis.findings}
    assert codes == {case.code} | case.also, [str(f) for f in diagnosis.findings]
    assert not diagnosis.is_well
    finding = next(f for f in diagnosis.findings if f.code == case.code)
    assert finding.severity is not Severity.HINT
    assert re.search(case.cause, finding.cause), finding.cause
    assert re.search(case.remedy, finding.remedy), finding.remedy
    assert re.match(case.where or re.escape(diagnosis.port), finding.where)
    if case.code == "L02":  # nobody is looked for any more once all are found
        assert diagnosis.roll.tried == (1_000_000, 57_600)
    for each in diagnosis.findings:  # one line each, in our words
        assert not re.search(r"\n|TxRx|COMM_|status packet|Traceback|Error\(", str(each))
