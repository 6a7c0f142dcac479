"""An arm on the bench: its servos looked at while a hand turns the joints, then set."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import isinf
from typing import TYPE_CHECKING

from splinearm.backends import require_chain
from splinearm.config import Cell
from splinearm.config.calibration_table import ServoCalibration
from splinearm.drivers.ability import range_registers
from splinearm.drivers.asking import read_all
from splinearm.drivers.chain import ServoSpec
from splinearm.drivers.crew import Crew
from splinearm.drivers.model import ServoModel
from splinearm.drivers.startup import is_coupled
from splinearm.errors import BusError, CalibrationError, ConfigError
from splinearm.units import DEG

from .calibration_line import CalibrationLine
from .calibration_placement import (
    Placement,
    Seen,
    place,
    place_apart,
    place_together,
    whole_turn,
)
from .calibration_zero import Turned
from .sweep import Pairing, Sweep
from .task import Change

if TYPE_CHECKING:
    from splinearm.drivers.dynamixel import DynamixelBus

_PATIENCE = 1.0
"""A cable that is moved may fail for so long before that is told, s."""

_READINGS, _APART, _STILL = 24, 0.01, 6
"""An arm at rest is read so often, so far apart (s), and may wander by so many ticks meanwhile."""

_FORESEEN = 3.0 * DEG
"""By how much a position may be off what was foreseen once the registers are written, rad: a hand
may still move the joint."""

_STIFF = 2.0 * DEG
"""So far the positions of two servos at one joint may be apart from a straight line, rad."""


class CalibrationBench:
    """Servos of some joints, perhaps a gripper's too; nothing is written before ``write``."""

    def __init__(
        self, bus: "DynamixelBus", cell: Cell, joints: Sequence[str] | None = None
    ) -> None:
        """Choose the servos; nothing is asked of them yet.

        Args:
            bus: The bus, at the arm's rate.
            cell: The arm, as its file says.
            joints: Names of joints, or of a gripper's servo; None: all.

        Raises:
            ConfigError: If the arm has no servos, or there is no such joint.
        """
        chain = require_chain(cell)
        crew = Crew.of(chain, cell.arm.joint_names)
        gripper = chain.gripper
        known = [*cell.arm.joint_names, *([] if gripper is None else [gripper.name])]
        names = known if joints is None else list(joints)
        for name in names:
            if name not in known:
                raise ConfigError("--joint", "", f"{name!r} is not one of {', '.join(known)}")
        self._bus, self._limits = bus, cell.arm.limits
        self.joints = tuple(name for name in cell.arm.joint_names if name in names)
        """The joints to be calibrated, base to flange."""
        self.leaders = {s.joint or "": s for s in crew.leaders if s.joint in self.joints}
        """By joint the servo that says where it is."""
        shadows = [s for s in crew.followers + crew.coupled if s.joint in self.joints]
        self.shadows = tuple(shadows)
        """Servos that help a leader."""
        self.gripper = gripper if gripper is not None and gripper.name in names else None
        """The gripper's servo, if it is to be calibrated."""
        own = [] if self.gripper is None else [self.gripper]
        self.servos = (*self.leaders.values(), *shadows, *own)
        """All of them."""
        self.sweeps = {s.servo_id: Sweep(s.servo_model) for s in self.servos}
        """By id where each was turned to."""
        self._pairings = {s.servo_id: Pairing(s.servo_model) for s in shadows}
        self.line = CalibrationLine(bus, cell, self.servos)
        """What is spoken to them."""
        self._silent_since: float | None = None

    def survey(self) -> None:
        """See that the servos are there and well, and read their EEPROM.

        Raises:
            BusError: If a servo does not answer, is of another model, or reports a hardware error.
        """
        self.line.survey()

    def poll(self) -> bool:
        """Read where all are, and take that into account; a moved cable may fail for a second.

        Returns:
            Whether they answered.

        Raises:
            BusError: If a servo does not answer for longer.
        """
        try:
            ticks = read_all(self._bus, self.servos, "Present Position")
        except BusError:
            now = time.monotonic()
            if self._silent_since is None:
                self._silent_since = now
            if now - self._silent_since > _PATIENCE:
                raise
            return False
        self._silent_since = None
        for servo_id, value in ticks.items():
            self.sweeps[servo_id].add(value)
        for servo in self.shadows:
            leader = self.leaders[servo.joint or ""]
            pair = (self.sweeps[leader.servo_id].now, self.sweeps[servo.servo_id].now)
            self._pairings[servo.servo_id].add(*pair)
        return True

    def catch_up(self) -> None:
        """Read where all are now, however often it takes.

        Raises:
            BusError: If a servo does not answer for a second.
        """
        while not self.poll():
            time.sleep(_APART)

    def begin_anew(self) -> None:
        """Forget where the joints were turned to; begin where they are."""
        for sweep in self.sweeps.values():
            sweep.begin_anew()
        self._pairings = {s.servo_id: Pairing(s.servo_model) for s in self.shadows}

    def sweep_of(self, joint: str) -> Sweep:
        """Give where a joint, or the gripper, was turned to."""
        if self.gripper is not None and joint == self.gripper.name:
            return self.sweeps[self.gripper.servo_id]
        return self.sweeps[self.leaders[joint].servo_id]

    def model_of(self, joint: str) -> ServoModel:
        """Give the model of the servo that says where a joint, or the gripper, is."""
        if self.gripper is not None and joint == self.gripper.name:
            return self.gripper.servo_model
        return self.leaders[joint].servo_model

    def turned(self, joint: str, sign: int) -> Turned:
        """Give what was seen of the travel of a joint."""
        sweep, i = self.sweep_of(joint), self._limits.names.index(joint)
        return Turned(
            joint=joint,
            model=self.leaders[joint].servo_model,
            low=sweep.low,
            high=sweep.high,
            sign=sign,
            q_min=float(self._limits.q_min[i]),
            q_max=float(self._limits.q_max[i]),
        )

    def missing(self, joint: str) -> float:
        """Give by how much a joint was turned less than its limits span, rad; 0 if endless."""
        short = self.turned(joint, 1).short
        return 0.0 if isinf(short) else max(short, 0.0)

    def is_too_far(self, name: str) -> bool:
        """Say whether a joint, or the gripper, was turned farther than its servo can tell."""
        sweep, endless = self.sweep_of(name), False
        if name in self.joints:
            endless = isinf(self.turned(name, 1).short)
        return sweep.torn or (sweep.travel > self.model_of(name).pulses and not endless)

    def rest(self, pause: float = _APART) -> dict[int, float] | None:
        """Read the arm at rest: give by id the mean count, ticks; None: it moves."""
        counts: dict[int, list[int]] = {servo.servo_id: [] for servo in self.servos}
        for _ in range(_READINGS):
            self.catch_up()
            for servo_id, sweep in self.sweeps.items():
                counts[servo_id].append(sweep.now)
            time.sleep(pause)
        if any(max(values) - min(values) > _STILL for values in counts.values()):
            return None
        return {servo_id: sum(values) / len(values) for servo_id, values in counts.items()}

    def place(self, joint: str, zero: float, sign: int) -> tuple[Placement, ...]:
        """Give what the servos of a joint are to be set to: its leader, then its shadows.

        Args:
            joint: The joint.
            zero: The leader's count at joint zero, ticks.
            sign: 1: its count grows with the joint; -1: it falls.

        Raises:
            CalibrationError: If they cannot be used as they are mounted or were moved.
        """
        leader = self._seen(self.leaders[joint], zero, sign)
        own = [servo for servo in self.shadows if servo.joint == joint]
        seen = [self._seen_shadow(servo, zero, sign) for servo in own]
        coupled = [shadow for shadow in seen if is_coupled(shadow.spec)]
        followers = tuple(place(shadow) for shadow in seen if shadow not in coupled)
        together = place_together(leader, coupled) if coupled else None
        if together is None:
            return (place(leader), *map(place_apart, coupled), *followers)
        return (*together, *followers)

    def place_gripper(self, open_count: float, closed_count: float) -> tuple[Placement, int, int]:
        """Give what the gripper's servo is to be set to, and where it then is open and closed.

        Raises:
            CalibrationError: If it cannot be used as it is mounted or was moved.
        """
        assert self.gripper is not None  # noqa: S101 - who asks has one
        low, high = sorted((open_count, closed_count))
        model = self.gripper.servo_model
        if high - low < model.pulses / 72:
            raise CalibrationError(self.gripper.name, "is open where it is closed: move it between")
        sweep = self.sweeps[self.gripper.servo_id]
        seen = Seen(
            spec=self.gripper,
            registers=self.line.registers[self.gripper.servo_id],
            low=sweep.low,
            high=sweep.high,
            torn=sweep.torn,
            zero=low,
            sign=1,
            q_min=0.0,
            q_max=(high - low) / model.pulses_per_rad,
        )
        placement = place(seen)
        placement = replace(placement, settings=self._roomy(placement))
        ends = [placement.zero_ticks + round(end - low) for end in (open_count, closed_count)]
        return placement, ends[0], ends[1]

    def _roomy(self, placement: Placement) -> dict[str, int]:
        """Give a gripper's settings with its limits as they are, if they let it open and close."""
        have, settings = self.line.registers[placement.spec.servo_id], dict(placement.settings)
        low, high = range_registers(placement.spec.servo_model)
        if low in settings and have[low] <= settings[low] and settings[high] <= have[high]:
            settings[low], settings[high] = have[low], have[high]
        elif low in settings:
            settings[low], settings[high] = whole_turn(placement.spec.servo_model)
        return settings

    def changes(self, placement: Placement) -> tuple[Change, ...]:
        """Give the registers that do not hold yet what they are to hold."""
        have, table = self.line.registers[placement.spec.servo_id], placement.spec.servo_model.table
        return tuple(
            Change(table[name], have[name], value)
            for name, value in placement.settings.items()
            if have[name] != value
        )

    def write(self, placement: Placement) -> None:
        """Write the registers of a servo, read them back, and see that its position is as foreseen.

        What is right already is not written.

        Raises:
            BusError: If the servo does not answer or refuses.
            CalibrationError: If its position is another than foreseen.
        """
        servo, bus = placement.spec, self._bus
        table = servo.servo_model.table
        self.catch_up()
        count = self.sweeps[servo.servo_id].now
        self.line.fill(servo, self.changes(placement))
        off = placement.differs(bus.read(servo.servo_id, table["Present Position"]), count)
        off /= servo.servo_model.pulses_per_rad
        if abs(off) > _FORESEEN:
            raise CalibrationError(
                f"servo {servo.name!r}",
                f"stands {off / DEG:.1f} deg from where it was to be once it was set; hold the "
                "joint still and calibrate it anew",
            )

    def _seen(self, servo: ServoSpec, zero: float, sign: int) -> Seen:
        sweep, i = self.sweeps[servo.servo_id], self._limits.names.index(servo.joint or "")
        return Seen(
            spec=servo,
            registers=self.line.registers[servo.servo_id],
            low=sweep.low,
            high=sweep.high,
            torn=sweep.torn,
            zero=zero,
            sign=sign,
            q_min=float(self._limits.q_min[i]),
            q_max=float(self._limits.q_max[i]),
        )

    def _seen_shadow(self, servo: ServoSpec, zero: float, sign: int) -> Seen:
        """Give what was seen of a shadow: where it was while its leader was elsewhere."""
        line = self._pairings[servo.servo_id].line()
        if line is None:
            raise CalibrationError(
                f"joint {servo.joint!r}", "was hardly turned: its two servos cannot be compared"
            )
        ratio, offset, worst = line
        if worst / servo.servo_model.pulses_per_rad > _STIFF:
            raise CalibrationError(
                f"servo {servo.name!r}",
                f"does not turn as its leader does: they differ by up to "
                f"{worst / servo.servo_model.pulses_per_rad / DEG:.1f} deg; is a horn loose?",
            )
        return self._seen(servo, ratio * zero + offset, ratio * sign)


def as_calibration(
    placement: Placement, zero_by: str = "", ends: tuple[int, int] | None = None
) -> ServoCalibration:
    """Give what a calibration says of a servo; ``ends`` is where a gripper is open and closed."""
    spec = placement.spec
    settings: Mapping[str, int] = placement.settings
    if ends is not None:
        return ServoCalibration(
            name=spec.name,
            servo_id=spec.servo_id,
            model=spec.model,
            open_ticks=ends[0],
            closed_ticks=ends[1],
            settings=settings,
        )
    return ServoCalibration(
        name=spec.name,
        servo_id=spec.servo_id,
        model=spec.model,
        zero_ticks=placement.zero_ticks,
        zero_by=zero_by,
        travel=placement.travel,
        settings=settings,
    )
