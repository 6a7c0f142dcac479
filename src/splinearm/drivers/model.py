"""Servo models: what a model can do and how its numbers are to be read."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from math import radians
from types import MappingProxyType
from typing import Any, NamedTuple

from splinearm.units import RPM

from .registers import ControlTable, load_table


class Stall(NamedTuple):
    """What a motor gives when it is held."""

    voltage: float
    """Supply, V."""
    torque: float
    """Torque, N m."""
    current: float
    """Current, A."""


class NoLoad(NamedTuple):
    """What a motor gives when nothing holds it."""

    voltage: float
    """Supply, V."""
    speed: float
    """Speed, rad/s."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ServoModel:
    """One servo model, as its manual describes it."""

    name: str
    """Name, as in "XM430-W350"."""
    number: int
    """What the servo answers to a ping."""
    protocols: tuple[int, ...]
    """Protocols it can speak, its default first."""
    pulses: int
    """Steps of the position register over ``span``."""
    span: float
    """The angle that ``pulses`` steps make, rad."""
    centre: int
    """Step at mid travel."""
    modes: tuple[int, ...]
    """Operating modes it has."""
    has_current: bool
    """Whether it measures current; if not, the same place holds a load in per mill."""
    fast_read_firmware: int
    """First firmware with fast sync and bulk read; 0: none has it."""
    gear: float
    """Turns of the motor to one of the horn."""
    mass: float
    """Mass, kg."""
    stall: tuple[Stall, ...]
    """Stall figures, by voltage; empty if none are published."""
    no_load: tuple[NoLoad, ...]
    """No-load figures, by voltage."""
    baud_codes: Mapping[int, int]
    """Baud rate of each value of the Baud Rate register."""
    error_bits: Mapping[int, str]
    """Name of each bit of Hardware Error Status (Protocol 1.0: of the error byte)."""
    note: str = ""
    """What else is good to know."""

    @property
    def table(self) -> ControlTable:
        """Its control table."""
        return load_table(self.name)

    @property
    def pulses_per_rad(self) -> float:
        """Steps of the position register to one radian."""
        return self.pulses / self.span

    def has_fast_read(self, firmware: int) -> bool:
        """Whether a servo with that firmware answers fast sync and fast bulk reads."""
        return 0 < self.fast_read_firmware <= firmware

    def hardware_errors(self, status: int) -> tuple[str, ...]:
        """Name the faults that a Hardware Error Status reports; bits unknown by their value."""
        return tuple(
            self.error_bits.get(1 << bit, f"bit 0x{1 << bit:02X}")
            for bit in range(8)
            if status & 1 << bit
        )

    def baud_code(self, baud: int) -> int:
        """Give the value of the Baud Rate register for a baud rate.

        Raises:
            ValueError: If the model does not have that rate.
        """
        for code, rate in self.baud_codes.items():
            if rate == baud:
                return code
        rates = ", ".join(str(rate) for rate in sorted(self.baud_codes.values()))
        raise ValueError(f"baud: want one of {rates} for {self.name}, got {baud}")


def servo_model(name: str) -> ServoModel:
    """Give the model of that name ("XM430-W350"; upper or lower case).

    Raises:
        ValueError: If it is not known, with those that are.
    """
    try:
        return _models()[name.upper()]
    except KeyError:
        known = ", ".join(_models())
        raise ValueError(f"no servo model {name!r}; there are {known}") from None


def servo_model_by_number(number: int) -> ServoModel:
    """Give the model that answers a ping with that number.

    Raises:
        ValueError: If it is not known.
    """
    for model in _models().values():
        if model.number == number:
            return model
    known = ", ".join(f"{model.number} ({model.name})" for model in _models().values())
    raise ValueError(f"no servo model with number {number}; there are {known}")


def servo_models() -> tuple[ServoModel, ...]:
    """Give every known model."""
    return tuple(_models().values())


@cache
def _models() -> Mapping[str, ServoModel]:
    """Read every model from the data beside this file."""
    folder = files("splinearm.drivers") / "models"
    models = tomllib.loads((folder / "models.toml").read_text(encoding="utf-8"))
    families = tomllib.loads((folder / "families.toml").read_text(encoding="utf-8"))
    read = (_model(name.upper(), facts, families) for name, facts in models.items())
    return MappingProxyType({model.name: model for model in read})


def _model(name: str, facts: Mapping[str, Any], families: Mapping[str, Any]) -> ServoModel:
    """Turn one table of the file into a model."""
    return ServoModel(
        name=name,
        number=facts["number"],
        protocols=tuple(facts["protocols"]),
        pulses=facts["pulses"],
        span=radians(facts.get("pulses_span_deg", 360.0)),
        centre=facts["centre"],
        modes=tuple(facts["modes"]),
        has_current=facts["current"],
        fast_read_firmware=facts["fast_read_fw"],
        gear=float(facts["gear"]),
        mass=facts["mass_g"] * 1e-3,
        stall=tuple(Stall(*map(float, row)) for row in facts["stall"]),
        no_load=tuple(NoLoad(float(volt), speed * RPM) for volt, speed in facts["no_load"]),
        baud_codes=_by_number(families["baud"][facts["baud"]]),
        error_bits=_by_number(families["hardware_error"][facts["hardware_error"]]),
        note=facts.get("note", ""),
    )


def _by_number(table: Mapping[str, Any]) -> Mapping[int, Any]:
    """Read the keys of a TOML table as numbers."""
    return MappingProxyType({int(key, 0): value for key, value in table.items()})
