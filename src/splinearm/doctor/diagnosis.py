"""What a look at a port and the arm on it has found, all together."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from .chart import Chart
from .finding import SCHEMA, Finding, Severity
from .pace import Pace
from .pulse import Pulse
from .roll import Roll


@dataclass(slots=True, eq=False)
class Diagnosis:
    """What was looked at, and what was found."""

    port: str
    """The port."""
    arm: str | None = None
    """The arm's file, as the user named it."""
    findings: tuple[Finding, ...] = ()
    """What is wrong, in the order in which it is to be mended."""
    charts: Mapping[int, Chart] = field(default_factory=dict)
    """By id the registers of the servos that could be read."""
    roll: Roll | None = None
    """Who answered."""
    pulses: Mapping[int, Pulse] = field(default_factory=dict)
    """By id how the servos answered pings."""
    pace: Pace | None = None
    """The loop rate that the line allows."""

    @property
    def is_well(self) -> bool:
        """Whether nothing is wrong; hints do not count."""
        return all(finding.severity is Severity.HINT for finding in self.findings)

    def document(self) -> dict[str, Any]:
        """Give it for JSON."""
        pace = self.pace
        return {
            "schema": SCHEMA,
            "port": self.port,
            "arm": self.arm,
            "well": self.is_well,
            "findings": [finding.document() for finding in self.findings],
            "servos": [_servo(self, chart) for chart in self.charts.values()],
            "rate_hz": None
            if pace is None
            else {"predicted": pace.predicted, "measured": pace.measured, "words": pace.words},
        }


def _servo(diagnosis: Diagnosis, chart: Chart) -> dict[str, Any]:
    pulse = diagnosis.pulses.get(chart.servo_id, Pulse())
    values = chart.values
    return {
        "id": chart.servo_id,
        "name": chart.name,
        "model": chart.model.name,
        "firmware": chart.firmware,
        "voltage_v": values["Present Input Voltage"] / 10.0
        if "Present Input Voltage" in values
        else None,
        "temperature_degc": values.get("Present Temperature"),
        "pings": pulse.asked,
        "damaged": pulse.damaged,
        "lost": pulse.silent,
    }
