"""How hot, how badly fed and how hard at work a servo may be, before a word and before a stop."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from math import inf, isnan, nan

import numpy as np

from .model import ServoModel

_TEMPERATURE_WARN, _TEMPERATURE_STOP = 15.0, 5.0
"""How far below the servo's own limit, degC: at its limit it cuts its torque and the arm falls."""
_LOW_WARN, _HIGH_WARN = 1.05, 0.98
"""Shares of the servo's own limits at which its supply is worth a word."""
_EFFORT_WARN, _EFFORT_STOP = 0.7, 0.9
"""Shares of the stall torque, over half a second: no servo bears that for long."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HealthLimits:
    """What is borne of a servo. NaN: what follows from its model and its own limit registers."""

    temperature_warn: float = nan
    """Temperature from which on a person is told, degC."""
    temperature_stop: float = nan
    """Temperature from which on the arm stops, degC."""
    voltage_low_warn: float = nan
    """Supply at or below which a person is told, V."""
    voltage_low_stop: float = nan
    """Supply at or below which the arm stops, V."""
    voltage_high_warn: float = nan
    """Supply at or above which a person is told, V."""
    voltage_high_stop: float = nan
    """Supply at or above which the arm stops, V."""
    current_warn: float = nan
    """Current over half a second from which on a person is told, A."""
    current_stop: float = nan
    """Current over half a second from which on the arm stops, A."""
    load_warn: float = nan
    """The same of servos that measure a load, as a share of their torque."""
    load_stop: float = nan
    """The same from which on the arm stops."""

    def __post_init__(self) -> None:
        for name in ("temperature", "voltage_high", "current", "load"):
            self._order(name, 1.0)
        self._order("voltage_low", -1.0)

    def _order(self, name: str, sign: float) -> None:
        """Refuse a warning that would come after the stop."""
        warn, stop = getattr(self, f"{name}_warn"), getattr(self, f"{name}_stop")
        if sign * warn > sign * stop:  # never so of NaN
            place = "below" if sign > 0.0 else "above"
            raise ValueError(f"{name}_warn: want it {place} {name}_stop, {stop:g}, got {warn:g}")

    def resolved(self, model: ServoModel, registers: Mapping[str, int]) -> "HealthLimits":
        """Give the same with a number in every field; infinite: never.

        Args:
            model: The model of the servo.
            registers: What its Temperature Limit and Min and Max Voltage Limit hold; for those that
                are missing what they hold in the factory.
        """
        defaults = _defaults(model, registers)
        chosen = {
            field.name: value
            for field in fields(self)
            if not isnan(value := getattr(self, field.name))
        }
        # who moves the stop only does not want the warning to come after it
        for name, first in (
            ("temperature", min),
            ("voltage_high", min),
            ("current", min),
            ("load", min),
            ("voltage_low", max),
        ):
            warn, stop = f"{name}_warn", f"{name}_stop"
            if stop in chosen and warn not in chosen:
                chosen[warn] = first(defaults[warn], chosen[stop])
            elif warn in chosen and stop not in chosen:
                last = max if first is min else min
                chosen[stop] = last(defaults[stop], chosen[warn])
        return replace(self, **(defaults | chosen))


def _defaults(model: ServoModel, registers: Mapping[str, int]) -> dict[str, float]:
    """Give what follows from a servo's own limits and its model."""

    def limit(name: str) -> float:
        value = registers.get(name)
        if value is None and name in model.table:
            initial = model.table[name].initial
            value = initial if isinstance(initial, int) else None
        return nan if value is None else float(value)

    hot = limit("Temperature Limit")
    low, high = limit("Min Voltage Limit") / 10.0, limit("Max Voltage Limit") / 10.0
    stall = stall_current(model, 0.5 * (low + high))
    figures = {
        "temperature_warn": hot - _TEMPERATURE_WARN,
        "temperature_stop": hot - _TEMPERATURE_STOP,
        "voltage_low_warn": low * _LOW_WARN,
        "voltage_low_stop": low,
        "voltage_high_warn": high * _HIGH_WARN,
        "voltage_high_stop": high,
        "current_warn": stall * _EFFORT_WARN,
        "current_stop": stall * _EFFORT_STOP,
        "load_warn": inf if model.has_current else _EFFORT_WARN,
        "load_stop": inf if model.has_current else _EFFORT_STOP,
    }
    never = {name: -inf if "_low_" in name else inf for name in figures}
    return {name: never[name] if isnan(value) else value for name, value in figures.items()}


def stall_current(model: ServoModel, voltage: float) -> float:
    """Give what a model draws when it is held at full drive, A; NaN if nobody says or measures."""
    if not model.has_current or not model.stall:
        return nan
    volts = [figure.voltage for figure in model.stall]
    return float(np.interp(voltage, volts, [figure.current for figure in model.stall]))
