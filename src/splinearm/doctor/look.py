"""The whole look at a port and the servos on it, step by step."""

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from splinearm.drivers.chain import ServoChain, ServoSpec
from splinearm.drivers.dialect import protocols_of
from splinearm.drivers.health_limit import HealthLimits
from splinearm.errors import PortError

from .advice import setup
from .catalogue import in_order
from .chart import Chart, read_registers
from .computer import Computer
from .diagnosis import Diagnosis
from .finding import Finding
from .line_check import check_pulses, check_roll, held_back, shared_id
from .model_number import model_of
from .pace import check_pace, measured_rate, pace_of, traffic_of
from .place_check import check_places
from .port_check import check_port, check_silent_port, late_answers, unusable
from .port_fact import latency_of
from .pulse import COUNT, PATIENCE, feel_pulses, is_shared
from .roll import Roll, call_everyone, call_roll
from .servo_check import check_errors, check_firmware, check_health, check_manner, mute
from .setting_check import (
    check_limits,
    check_other_limits,
    check_settings,
    named,
    other_model,
    unknown_model,
)
from .stethoscope import Stethoscope, hushed

if TYPE_CHECKING:
    from splinearm.config import Cell

_STOPS = frozenset(("P01", "P02", "P03", "P04", "P07", "P08"))
_BETWEEN = 1e-3  # s: an adapter that does not say its latency hands answers over once a USB frame
_DELAY_UNIT = 2e-6
_MISPLACED = frozenset(("S14", "S15", "S16", "S17"))


@dataclass(frozen=True, slots=True, kw_only=True)
class Effort:
    """How closely to look."""

    pings: int = COUNT
    """How many pings make the statistics of the line."""
    cycles: int = 200
    """How many cycles to measure the loop rate by at most; 0: it is not measured."""
    seconds: float = 60.0
    """After what time no new rate is tried any more, s."""
    is_thorough: bool = True
    """Whether to look for servos that the file does not name, and for ids that two have, also where
    nothing hints at them."""


QUICK = Effort(pings=40, cycles=0, seconds=1.5, is_thorough=False)
"""What takes a moment, for a command that failed."""


def diagnose(
    port: str,
    cell: "Cell | None" = None,
    *,
    arm: str | None = None,
    computer: Computer | None = None,
    effort: Effort | None = None,
) -> Diagnosis:
    """Look at a port and the servos on it. Nothing moves and nothing is written to a servo.

    Args:
        port: The port.
        cell: The arm that should be there; None: whoever answers is looked at by itself.
        arm: How the user named the arm, for remedies.
        computer: Where facts about this computer come from; None: this computer.
        effort: How closely to look; None: as closely as there is a way to.
    """
    computer = Computer() if computer is None else computer
    findings = list(check_port(computer, port))
    diagnosis = Diagnosis(port, arm)
    if not any(finding.code in _STOPS for finding in findings):
        try:
            with hushed():  # findings say it better
                _Look(diagnosis, findings, cell, computer, effort or Effort()).all()
        except PortError as error:
            findings.append(unusable(error))
    diagnosis.findings = in_order(findings)
    return diagnosis


class _Look:
    """One look at a line, step by step."""

    def __init__(
        self,
        diagnosis: Diagnosis,
        findings: list[Finding],
        cell: "Cell | None",
        computer: Computer,
        effort: Effort,
    ) -> None:
        self._diagnosis = diagnosis
        self._findings = findings
        self._cell = cell
        self._chain: ServoChain | None = None if cell is None else cell.chain
        self._computer = computer
        self._effort = effort
        self._until = time.monotonic() + effort.seconds
        self._port = diagnosis.port
        self._mend = setup(self._port, diagnosis.arm)
        self._specs: dict[int, ServoSpec] = {}
        if self._chain is not None:
            self._specs = {servo.servo_id: servo for servo in self._chain.servos}

    def all(self) -> None:
        """Look at everything."""
        roll = self._roll()
        protocols = {i: reply.protocol for i, reply in roll.present.items()}
        if self._chain is not None:
            protocols |= protocols_of(self._chain)
        with Stethoscope(self._port, roll.baud, protocols=protocols) as bus:
            shared = self._shared(bus, roll)
            known = [i for i in roll.present if i not in shared]
            self._findings += self._of_roll(roll, shared)
            self._read(bus, roll, known)
            self._pulses(bus, (*known, *(i for i in roll.garbled if i not in shared)))
            self._findings += self._of_servos()
            self._pace(bus, roll, known)

    def _roll(self) -> Roll:
        if self._chain is None:
            roll = call_everyone(self._port)
        else:
            roll = call_roll(
                self._port, self._chain, until=self._until, thorough=self._effort.is_thorough
            )
        self._diagnosis.roll = roll
        return roll

    def _shared(self, bus: Stethoscope, roll: Roll) -> set[int]:
        """Find ids that two servos have."""
        suspects = list(roll.garbled)
        if self._effort.is_thorough or roll.silent:
            suspects += [i for i in roll.present if i not in suspects]
        shared: set[int] = set()
        for servo_id in suspects:
            reply = roll.present.get(servo_id)
            model = None if reply is None else model_of(reply.model_number)
            if model is None and servo_id in self._specs:
                model = self._specs[servo_id].servo_model
            place = None if model is None else model.table.get("Present Position")
            if place is not None and is_shared(bus, servo_id, place):
                shared.add(servo_id)
        return shared

    def _of_roll(self, roll: Roll, shared: set[int]) -> Iterator[Finding]:
        """Say who is missing; of two with one id one is."""
        silent = list(roll.silent)
        for servo_id in sorted(shared):
            twin = silent[:1]
            silent = silent[1:]
            yield shared_id(self._where(servo_id), twin, self._mend)
        left = replace(roll, silent=tuple(silent))
        yield from check_roll(self._port, left, self._chain, self._diagnosis.arm)
        if not (roll.present or roll.garbled or roll.strangers or roll.crowded):
            yield from check_silent_port(self._computer, self._port)

    def _read(self, bus: Stethoscope, roll: Roll, ids: list[int]) -> None:
        """Read the registers of everyone, and see that each is of the model that it should be."""
        charts: dict[int, Chart] = {}
        for servo_id in ids:
            reply, servo = roll.present[servo_id], self._specs.get(servo_id)
            other = None if servo is None else other_model(servo, reply)
            if other is not None:
                self._findings.append(other)
            model = model_of(reply.model_number)
            if model is None:
                if other is None:
                    self._findings.append(unknown_model(self._where(servo_id), reply))
                continue
            values = read_registers(bus, servo_id, model, servo if other is None else None)
            if values is None:
                self._findings.append(mute(self._where(servo_id)))
                continue
            charts[servo_id] = Chart(
                servo_id=servo_id,
                name="" if servo is None else servo.name,
                model=model,
                firmware=reply.firmware,
                values=values,
            )
        self._diagnosis.charts = charts

    def _pulses(self, bus: Stethoscope, ids: tuple[int, ...]) -> None:
        """Count how well they answer."""
        if not ids:
            return
        patience = PATIENCE if self._effort.is_thorough else 0.0
        pulses = feel_pulses(bus, ids, count=self._effort.pings, patience=patience)
        self._diagnosis.pulses = pulses
        names = {servo_id: self._where(servo_id) for servo_id in ids}
        self._findings += check_pulses(self._port, pulses, names)

    def _of_servos(self) -> Iterator[Finding]:
        charts, arm = self._diagnosis.charts, self._diagnosis.arm
        for chart in charts.values():
            servo = self._specs.get(chart.servo_id)
            yield from check_errors(chart, self._port, arm)
            yield from check_firmware(chart)
            delay = chart.values.get("Return Delay Time", 0)  # as it is, unless the file says more
            health = HealthLimits()
            if servo is not None and chart.model is servo.servo_model:
                delay = servo.settings.get("Return Delay Time", delay)
                health = servo.health
            yield from check_health(chart, health)
            yield from check_manner(chart, delay, self._mend)
        if self._cell is not None and self._chain is not None:
            yield from self._of_settings(self._cell, self._chain)

    def _of_settings(self, cell: "Cell", chain: ServoChain) -> Iterator[Finding]:
        """Compare with the arm's file; where the mounting differs, places mean nothing."""
        charts = dict(self._diagnosis.charts)
        leaders = chain.leaders_of(cell.arm.joint_names)
        for servo in chain.servos:
            chart = named(charts, servo)
            if chart is None:
                continue
            findings = list(check_settings(chart, servo, self._mend))
            if servo in leaders:
                joint = leaders.index(servo)
                findings += check_limits(chart, servo, cell.arm.limits, joint, self._mend)
            else:
                findings += check_other_limits(chart, servo, self._mend)
            if any(finding.code in _MISPLACED for finding in findings):
                del charts[servo.servo_id]
            yield from findings
        yield from check_places(cell, charts)

    def _pace(self, bus: Stethoscope, roll: Roll, known: list[int]) -> None:
        """Say which loop rate follows, and whether something holds answers back unseen."""
        charts = self._diagnosis.charts
        delays = {
            i: chart.values.get("Return Delay Time", 0) * _DELAY_UNIT for i, chart in charts.items()
        }
        latency = self._latency(roll, delays)
        if self._cell is None or self._chain is None:
            return
        names = self._cell.arm.joint_names
        leaders = self._chain.leaders_of(names)
        if any(servo.servo_id not in known for servo in leaders):
            return
        try:
            traffic = traffic_of(self._chain, names, roll.present)
        except ValueError:  # servos that no arm can be made of
            return
        # it may learn to ask otherwise
        rate = measured_rate(bus, traffic, cycles=self._effort.cycles)
        pace = pace_of(traffic, roll.baud, delays, latency)
        self._diagnosis.pace = replace(pace, measured=rate)
        self._findings += check_pace(self._diagnosis.pace, self._port)

    def _latency(self, roll: Roll, delays: Mapping[int, float]) -> float:
        """Give at ticks of what time answers are handed over, s."""
        device = None if self._port.startswith("unix:") else self._computer.device(self._port)
        said = None if device is None else latency_of(self._computer, device)
        protocols = {i: reply.protocol for i, reply in roll.present.items()}
        felt = held_back(dict(self._diagnosis.pulses), roll.baud, protocols, dict(delays))
        if said is None and felt:
            self._findings.append(late_answers(self._port, felt))
            return felt
        if said is None:
            is_usb = device is not None and not device.path.startswith("/dev/pts/")
            return _BETWEEN if is_usb else 0.0
        return said

    def _where(self, servo_id: int) -> str:
        servo = self._specs.get(servo_id)
        return f"servo {servo_id}" + (f" ({servo.name})" if servo is not None else "")
