"""Where the joints stand: outside their ranges, or apart from their shadows."""

from collections.abc import Iterator, Mapping
from math import isinf

from splinearm.config import Cell
from splinearm.drivers.chain import ServoSpec
from splinearm.drivers.crew import Crew
from splinearm.drivers.scaling import ONE_TURN_MODE, operating_mode
from splinearm.drivers.turn import fold, unwrapped_zero
from splinearm.errors import ServoError
from splinearm.units import DEG

from .advice import set_by_hand
from .catalogue import found
from .chart import Chart
from .finding import Finding
from .setting_check import named

_SAG = 2.0 * DEG
_APART = 3.0 * DEG
"""How far a joint may hang beyond its range, and a shadow from its leader, as on switching on."""


def check_places(cell: Cell, charts: Mapping[int, Chart]) -> Iterator[Finding]:
    """See that every joint stands within its range, where its zero is known."""
    if cell.chain is None:
        return
    crew = Crew.of(cell.chain, cell.arm.joint_names)
    for joint, servo in enumerate(crew.leaders):
        chart = named(charts, servo)
        if servo.zero_ticks is None:
            yield found(
                "S21",
                f"servo {servo.servo_id} ({servo.name})",
                f'where joint {servo.joint!r} is zero is not known (zero_ticks = "calibrate")',
                f"`splinearm calibrate {cell.name}` finds it with you, by hand",
            )
        elif chart is not None and "Present Position" in chart.values:
            yield from _check_place(cell, chart, servo, joint)
    for shadow in (*crew.coupled, *crew.followers):
        own, leads = named(charts, shadow), named(charts, crew.leader_of(shadow))
        if own is not None and leads is not None:
            yield from _check_shadow(own, shadow, leads, crew.leader_of(shadow))


def _check_place(cell: Cell, chart: Chart, servo: ServoSpec, joint: int) -> Iterator[Finding]:
    limits, zero = cell.arm.limits, servo.zero_ticks or 0
    low, high = float(limits.q_min[joint]), float(limits.q_max[joint])
    ticks = chart.values["Present Position"]
    if not chart.values.get("Torque Enable", 0):
        ticks = fold(servo, ticks)
    try:
        zero = unwrapped_zero(servo, zero, ticks, low, high)
    except ServoError as error:
        cause, _, act = error.reason.partition("; ")
        yield found("S22", chart.where, cause, act or "move it within its range by hand")
        return
    q = (ticks - zero) / servo.servo_model.pulses_per_rad
    beyond = max(low - q, q - high)
    if beyond > _SAG and not isinf(beyond):
        yield found(
            "S22",
            chart.where,
            f"joint {servo.joint!r} is at {q / DEG:.1f} deg; its range is {low / DEG:.1f} to "
            f"{high / DEG:.1f} deg",
            "move it within its range by hand, with the torque off; if it is there by its looks, "
            "its zero_ticks in the arm's file is wrong",
        )


def _check_shadow(
    own: Chart, shadow: ServoSpec, leads: Chart, leader: ServoSpec
) -> Iterator[Finding]:
    name = "Present Position"
    if name not in own.values or name not in leads.values:
        return
    zeros = (shadow.zero_ticks, leader.zero_ticks)
    gap = own.values[name] - leads.values[name]
    if None not in zeros and own.values.get("Secondary(Shadow) ID", 255) > 252:
        gap -= (shadow.zero_ticks or 0) - (leader.zero_ticks or 0)
    pulses = shadow.servo_model.pulses
    if operating_mode(shadow) == ONE_TURN_MODE:  # whole turns fold away
        gap = (gap + pulses // 2) % pulses - pulses // 2
    if abs(gap) / shadow.servo_model.pulses_per_rad > _APART:
        homing = own.values.get("Homing Offset", 0) - gap
        remedy = set_by_hand(shadow.servo_model, shadow.servo_id, "Homing Offset", homing)
        yield found(
            "S23",
            own.where,
            f"it stands {gap} ticks from its leader {leader.name!r}: they would fight each other",
            f"{remedy}; or mount its horn anew",
        )
