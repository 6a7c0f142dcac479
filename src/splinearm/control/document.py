"""A run as a JSON document, for programs that start others and want to know what came of it."""

from math import isnan
from typing import Any

from splinearm.units import DEG, MM

from .ending import Ending
from .forecast import StopForecast
from .realtime import Footing
from .report import LoopReport, Spread, TrackingReport

SCHEMA = "splinearm-run/1"
"""What the document says it is."""


def run_document(
    ending: Ending,
    loop: LoopReport,
    tracking: TrackingReport | None,
    stop: StopForecast | None = None,
    footing: Footing | None = None,
) -> dict[str, Any]:
    """Give a run as values that JSON knows; keys wear their units, None where nothing is known.

    Args:
        ending: How it ended; ``error_code`` is that of FollowJointTrajectory.
        loop: How well it kept its time.
        tracking: How far the arm was off; None if nothing was measured.
        stop: What was known of stops before it began.
        footing: What the system permitted.
    """
    stopped = ending.stopped
    return {
        "schema": SCHEMA,
        "outcome": ending.outcome.value,
        "error_code": int(ending.reason),
        "error_name": ending.reason.name,
        "error_string": "" if ending.fault is None else str(ending.fault),
        "stopped_at_s": None if stopped is None else stopped.t,
        "loop": _loop(loop),
        "real_time": None if footing is None else {"fifo": footing.fifo, "locked": footing.locked},
        "stop_forecast": None if stop is None else _stop(stop),
        "tracking": None if tracking is None else _tracking(tracking),
    }


def _loop(loop: LoopReport) -> dict[str, Any]:
    return {
        "rate_hz": loop.rate,
        "cycles": loop.cycles,
        "missed": loop.missed,
        "unanswered": loop.unanswered,
        "lateness_us": _spread(loop.lateness, 1e-6),
        "busy_us": _spread(loop.busy, 1e-6),
        "servos": [
            {
                "id": servo.servo_id,
                "name": servo.name,
                "joint": servo.joint,
                "reads": servo.reads,
                "timeouts": servo.timeouts,
                "crc_errors": servo.crc_errors,
                "retries": servo.retries,
            }
            for servo in loop.servos
        ],
    }


def _stop(stop: StopForecast) -> dict[str, Any]:
    unit, name = (MM, "mm") if stop.linear else (DEG, "deg")
    return {
        "time_s": stop.time,
        "tool_mm": _number(stop.tool / MM),
        "joint": stop.joint,
        f"travel_{name}": stop.travel / unit,
    }


def _tracking(tracking: TrackingReport) -> dict[str, Any]:
    return {
        "joints": {name: _spread(spread, 1.0) for name, spread in tracking.joints},
        "tool_lag_mm": _spread(tracking.tool_lag, MM),
        "tool_turn_deg": _spread(tracking.tool_turn, DEG),
        "path_commanded_mm": _spread(tracking.path_commanded, MM),
        "path_measured_mm": _spread(tracking.path_measured, MM),
    }


def _spread(spread: Spread, unit: float) -> dict[str, float | None]:
    return {
        "rms": _number(spread.rms / unit),
        "p99": _number(spread.p99 / unit),
        "worst": _number(spread.worst / unit),
    }


def _number(value: float) -> float | None:
    return None if isnan(value) else value
