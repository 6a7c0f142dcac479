"""A sample as a table for a terminal: rows in the colours of their levels, remedies in the rows."""

import logging
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from types import TracebackType
from typing import Self

from rich.box import SIMPLE_HEAD
from rich.console import Group, RenderableType
from rich.live import Live
from rich.table import Table
from rich.text import Text

from splinearm.monitoring.document import Value, document, flat, servo_document, unit_of
from splinearm.monitoring.sample import Level, Sample, ServoSample

from .output import console

WIDE = 110
"""Columns of a terminal from which on counts and joints have room of their own."""

_STYLES = {Level.WELL: "", Level.WARN: "yellow", Level.STOP: "bold red"}
_ROOMY = 90
"""Columns from which on names need not be broken."""
_REDRAWN, _PRINTED = 0.2, 1.0  # s
_SLOW = 0.8
"""Share of the wanted rate below which that is worth a word."""
_NUMBERS = ("deg", "deg/s", "effort", "degC", "V")


def picture(sample: Sample, width: int) -> RenderableType:
    """Give a sample as a header and a table.

    Args:
        sample: The sample.
        width: Columns of the terminal.
    """
    wide = width >= WIDE
    headings: tuple[str, ...] = ("servo", "id", *_NUMBERS, "torque", "what to do")
    if wide:
        headings = ("servo", "joint", "id", *_NUMBERS, "torque", "lost/crc/again", "what to do")
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, show_edge=False)
    for name in headings:
        table.add_column(
            name,
            justify="right" if name in ("id", *_NUMBERS) else "left",
            overflow="fold",
            no_wrap=name in ("id", *_NUMBERS),
            max_width=12 if name == "servo" and width < _ROOMY else None,
        )
    says = any(servo.answers for servo in sample.servos)
    for servo in sample.servos:
        row = _row(servo)
        if not says and servo.verdict.code == "L04":  # the header says what to do
            row["what to do"] = Text("no answer")
        cells = [row[name] for name in headings]
        table.add_row(*cells, style="" if servo.answers else _STYLES[Level.STOP])
    return Group(*_header(sample), table)


def _header(sample: Sample) -> Sequence[Text]:
    """Give what holds of all servos."""
    said = flat({k: v for k, v in document(sample).items() if k != "servos"})
    spread = {k: said[f"jitter_ms.{k}"] or "-" for k in ("p50", "p99", "max")}
    who = sample.arm or f"{len(sample.servos)} servos"
    of = f" of {said['wanted_rate_hz']}" if said["wanted_rate_hz"] else ""
    lines = [
        Text(f"{who} on {sample.port}, {sample.baud} baud", style="bold"),
        Text(
            f"{said['rate_hz'] or '-'}{of} Hz, jitter p50 {spread['p50']}, p99 {spread['p99']}, "
            f"max {spread['max']} ms"
        ),
        Text(
            f"{said['reads']} answers asked for: {said['lost']} lost, {said['damaged']} damaged "
            f"(CRC); {said['retries']} questions asked again"
        ),
    ]
    if sample.trouble:
        words = f"the port cannot be used: {sample.trouble}; waiting until it can"
        lines.append(Text(words, style=_STYLES[Level.STOP]))
    elif sample.servos and not any(servo.answers for servo in sample.servos):
        words = "L01 no servo answers: switch the servos' power on, check the cable; "
        words += f"`splinearm doctor {sample.port}` looks closer"
        lines.append(Text(words, style=_STYLES[Level.STOP]))
    elif sample.rhythm.rate < _SLOW * sample.rhythm.wanted:
        words = "C07 slower than was asked for: "
        words += f"`splinearm doctor {sample.port}` says what holds it up"
        lines.append(Text(words, style=_STYLES[Level.WARN]))
    return lines


def _row(servo: ServoSample) -> dict[str, Text]:
    """Give the cells of a servo by their headings."""
    said, unit, fields = servo_document(servo), unit_of(servo), servo.verdict.fields

    def cell(text: str, *names: str) -> Text:
        level = max((fields.get(name, Level.WELL) for name in names), default=Level.WELL)
        return Text(text or "-", style=_STYLES[level])

    sliding = "" if unit == "deg" else " mm"
    position, velocity = _fixed(said[f"position_{unit}"], 3), _fixed(said[f"velocity_{unit}_s"], 2)
    current, load = _fixed(said["current_a"], 3), _fixed(said["load_percent"], 1)
    effort = f"{current} A" if current else f"{load} %" if load else ""
    torque = {None: "", True: "on", False: "off"}[servo.torque]
    counts = f"{said['lost']}/{said['damaged']}/{said['retries']}"
    return {
        "servo": Text(servo.name),
        "joint": Text(servo.joint or "-"),
        "id": Text(str(servo.servo_id)),
        "deg": cell(position + sliding if position else ""),
        "deg/s": cell(velocity),
        "effort": cell(effort, "current", "load"),
        "degC": cell(_fixed(said["temperature_degc"], 0), "temperature"),
        "V": cell(_fixed(said["voltage_v"], 1), "voltage"),
        "torque": Text(f"{torque or '-'}, moves" if servo.moving else torque or "-"),
        "lost/crc/again": Text(counts),
        "what to do": Text(_advice(servo), style=_STYLES[servo.verdict.level]),
    }


def _fixed(value: Value, digits: int) -> str:
    """Give a number with all its digits, so that columns stand still; "" for nothing."""
    return f"{value:.{digits}f}" if isinstance(value, int | float) else ""


def _advice(servo: ServoSample) -> str:
    """Say what is wrong and what mends it."""
    verdict = servo.verdict
    if not verdict.what:
        return ""
    code = f"{verdict.code} " if verdict.code else ""
    what = "no answer" if verdict.code == "L04" else verdict.what
    errors = f" ({', '.join(servo.errors)})" if servo.errors else ""
    return f"{code}{what}{errors}: {verdict.remedy}"


class Show:
    """Shows samples: on a terminal in place of each other, else one after the other.

    What was last on a terminal stays there in the end.
    """

    def __init__(self) -> None:
        self.period = _REDRAWN if console.is_terminal else _PRINTED
        """How often it is worth while, s."""
        self._live: Live | None = None
        self._stack = ExitStack()
        self._last: Sample | None = None

    def __enter__(self) -> Self:
        if console.is_terminal:
            live = Live(console=console, screen=True, auto_refresh=False)
            self._live = self._stack.enter_context(live)
            logger = logging.getLogger("splinearm")  # the table says it better
            self._stack.callback(logger.setLevel, logger.level)
            logger.setLevel(logging.ERROR)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stack.close()
        if self._live is not None and self._last is not None and error is None:
            console.print(picture(self._last, console.width))

    def __call__(self, sample: Sample) -> None:
        """Show a sample."""
        self._last = sample
        if self._live is None:
            console.print(picture(sample, console.width))
            return
        shown = picture(sample, console.width)
        if len(console.render_lines(shown)) > console.height:  # what is well may be cut off
            worst = sorted(sample.servos, key=lambda servo: -servo.verdict.level)
            shown = picture(replace(sample, servos=tuple(worst)), console.width)
        self._live.update(shown, refresh=True)
