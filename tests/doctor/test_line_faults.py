"""Each fault of the line, of servos and of arm files is found, with its cause and its remedy."""

import re

import pytest
from line_cases import LINE_CASES

from splinearm.doctor.finding import Severity
from splinearm.doctor.look import Effort, diagnose

pytestmark = pytest.mark.bus

LOOK = Effort(pings=90, cycles=0)


@pytest.mark.parametrize("case", LINE_CASES, ids=lambda case: f"{case.code} {case.act}")
def test_a_fault_is_found_with_cause_and_remedy(case, virtual):
    with virtual(case.arm, case.transport, **case.wiring) as (cell, bus):
        with bus.lock:
            case.hurt(bus)
        diagnosis = diagnose(bus.port, case.cell(cell), arm=case.arm, effort=LOOK)
    codes = {finding.code for finding in diagnosis.findings}
    assert codes == {case.code} | case.also, [str(f) for f in diagnosis.findings]
    assert not diagnosis.is_well
    finding = next(f for f in diagnosis.findings if f.code == case.code)
    assert finding.severity is not Severity.HINT
    assert re.search(case.cause, finding.cause), finding.cause
    assert re.search(case.remedy, finding.remedy), finding.remedy
    assert re.match(case.where or re.escape(diagnosis.port), finding.where)
    for each in diagnosis.findings:  # one line each, in our words
        assert not re.search(r"\n|TxRx|COMM_|status packet|Traceback|Error\(", str(each))
