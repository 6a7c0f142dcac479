"""Where zero and the wrap point of a servo go, so that its angle is right wherever its joint is.

A servo's encoder knows the angle within one turn. Where that turn begins is fixed by how the horn
was screwed on: neither Homing Offset nor Drive Mode moves it, they only call it something else. In
position mode (3) the register jumps there, so it must lie outside the travel; where it does not,
the servo goes to a mode that counts on (4 or 5), and the start tells the turn from the joint's
limits. A Homing Offset of a leader then serves nothing, and in mode 3 it would only take away
goals: zero is ``zero_ticks``. A shadow that obeys its leader's id needs one, to say the same.
Source: ROBOTIS e-Manual, "Homing Offset", "Operating Mode", "Present Position".
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, floor, isinf, tau

from splinearm.drivers.ability import range_registers
from splinearm.drivers.chain import ServoSpec
from splinearm.drivers.model import ServoModel
from splinearm.drivers.scaling import MULTI_TURN_MODES, ONE_TURN_MODE, operating_mode
from splinearm.errors import CalibrationError
from splinearm.units import DEG

from .sweep import counts_turns
from .task import SECONDARY_ID

_MARGIN = 1.0 * DEG
"""So far from the wrap point a joint must stay in position mode, rad: stops give way a little."""

_SEAM = 2.5 * DEG
"""By how much less than a turn a joint must go for its turn to be told anywhere, rad."""

_ROUNDING = 1.5
"""So many ticks a limit may lie beyond what a servo sees."""

_REVERSED = 1
"""The bit of Drive Mode that turns the direction round."""

_NO_SECONDARY_ID = 255

_HOMING_SHARE = 4
"""In position mode a Homing Offset counts up to a turn by that number, a larger one does not."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Seen:
    """What was seen of a servo while its joint was turned by hand."""

    spec: ServoSpec
    """The servo, as the arm's file says it is."""
    registers: Mapping[str, int]
    """Its EEPROM at that time, by register name."""
    low: int
    """Lowest position of the travel, counted on, ticks."""
    high: int
    """Highest position of the travel, ticks."""
    torn: bool = False
    """Whether it was turned through angles that it does not see."""
    zero: float
    """Where the joint is zero, in the same count, ticks."""
    sign: int
    """1: the count grows with the joint; -1: it falls."""
    q_min: float
    """Lowest position that the joint may have, rad; -inf: it turns without end."""
    q_max: float
    """Highest position that the joint may have, rad."""

    @property
    def model(self) -> ServoModel:
        """Its model."""
        return self.spec.servo_model

    @property
    def whose(self) -> str:
        """What it is called to people."""
        return f"joint {self.spec.joint!r}" if self.spec.joint else self.spec.name

    @property
    def endless(self) -> bool:
        """Whether its joint turns without end."""
        return isinf(self.q_min) or isinf(self.q_max)

    @property
    def travel(self) -> tuple[float, float]:
        """The travel as the joint says it, rad."""
        per_rad = self.sign * self.model.pulses_per_rad
        ends = sorted((ticks - self.zero) / per_rad for ticks in (self.low, self.high))
        return ends[0], ends[1]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Placement:
    """What a servo's registers are to hold, and what its position then says."""

    spec: ServoSpec
    """The servo."""
    zero_ticks: int
    """Position register at joint zero."""
    settings: Mapping[str, int]
    """What registers of its EEPROM are to hold, by name."""
    travel: tuple[float, float]
    """The travel of its joint, rad."""
    turned: int
    """1: its position grows as it did while it was seen; -1: the other way round."""
    shift: float
    """What its position is more than ``turned`` times the count, up to whole turns, ticks."""
    notes: tuple[str, ...] = ()
    """What the person should know."""

    def differs(self, position: float, count: float) -> float:
        """Give how far a position is from what it is to be where the count was that, ticks."""
        away = position - (self.turned * count + self.shift)
        if not counts_turns(self.spec.servo_model):
            return away
        pulses = self.spec.servo_model.pulses
        return (away + pulses / 2.0) % pulses - pulses / 2.0


def place(seen: Seen, mode: int | None = None) -> Placement:
    """Place zero and wrap point of a servo that gets goals of its own.

    Args:
        seen: What was seen of it.
        mode: The Operating Mode that it is to have; None: that of the arm's file, if possible.

    Raises:
        CalibrationError: If the joint was turned farther than one turn, or the servo cannot be
            used as it is mounted; with the figure and the remedy.
    """
    _check_travel(seen)
    turned, homing = _turned(seen), _homing(seen)
    zero = turned * (seen.zero - homing)
    low, high = _span(seen, zero)
    mode = _mode(seen, low, high) if mode is None else mode
    notes = [*_limit_notes(seen)]
    if mode != operating_mode(seen.spec):
        notes.append(f"its wrap point lies in the travel: it needs mode {mode}")
    if mode != ONE_TURN_MODE:
        notes += _check_turn(seen)
    turns = _turns_into_one(seen.model, low, high)
    if turns is None:  # the middle at least
        turns = -floor(((low + high) / 2.0 - whole_turn(seen.model)[0]) / seen.model.pulses)
    zero_ticks = round(zero + turns * seen.model.pulses)
    return Placement(
        spec=seen.spec,
        zero_ticks=zero_ticks,
        settings=_settings(seen, mode, zero_ticks),
        travel=seen.travel,
        turned=turned,
        shift=-turned * homing,
        notes=tuple(notes),
    )


def place_together(leader: Seen, shadows: Sequence[Seen]) -> tuple[Placement, ...] | None:
    """Place a leader and shadows that obey its id: all must say the same, wherever they are.

    None if that cannot be, as they are mounted: where the wrap point of one of them lies in the
    travel they would be whole turns apart after a loss of power, and fight each other.

    Raises:
        CalibrationError: As ``place``.
    """
    first = place(leader)
    for shadow in shadows:
        _check_travel(shadow)
    offsets = [_offset(leader, first, shadow) for shadow in shadows]
    known = [offset for offset in offsets if offset is not None]
    if len(known) < len(offsets) or _turns_into_one(leader.model, *_own_span(leader)) is None:
        return None
    mode = first.settings["Operating Mode"]
    short = max(map(abs, known)) <= leader.model.pulses // _HOMING_SHARE
    if mode == ONE_TURN_MODE and not short:
        mode = MULTI_TURN_MODES[0]
        first = place(leader, mode)
    return (first, *(_beside(first, *pair) for pair in zip(shadows, known, strict=True)))


def place_apart(shadow: Seen) -> Placement:
    """Place a shadow that obeyed its leader's id and cannot say what that one says.

    It gets goals of its own from now on.

    Raises:
        CalibrationError: As ``place``.
    """
    placement = place(shadow)
    return replace(
        placement,
        settings={**placement.settings, SECONDARY_ID: _NO_SECONDARY_ID},
        notes=(*placement.notes, "it cannot share its leader's id: it gets goals of its own"),
    )


def _offset(leader: Seen, first: Placement, shadow: Seen) -> int | None:
    """Give the Homing Offset with which a shadow says what its leader says; None: none does."""
    turned = _turned(shadow)
    turns = _turns_into_one(shadow.model, *_own_span(shadow))
    if turns is None or shadow.model.pulses != leader.model.pulses:
        return None
    own = turned * (shadow.zero - _homing(shadow))
    return first.zero_ticks - round(own + turns * shadow.model.pulses)


def _beside(first: Placement, shadow: Seen, homing: int) -> Placement:
    """Place a shadow beside its leader."""
    settings = _settings(shadow, first.settings["Operating Mode"], first.zero_ticks)
    turned = _turned(shadow)
    return Placement(
        spec=shadow.spec,
        zero_ticks=first.zero_ticks,
        settings={
            **settings,
            "Homing Offset": homing,
            SECONDARY_ID: shadow.spec.settings[SECONDARY_ID],
        },
        travel=shadow.travel,
        turned=turned,
        shift=homing - turned * _homing(shadow),
    )


def _own_span(seen: Seen) -> tuple[float, float]:
    """Give from where to where the position must be right without a Homing Offset, ticks."""
    return _span(seen, _turned(seen) * (seen.zero - _homing(seen)))


def _check_travel(seen: Seen) -> None:
    """Refuse a joint that was turned farther than its servo can tell."""
    figure = (seen.high - seen.low) / seen.model.pulses_per_rad / DEG
    if seen.torn:
        raise CalibrationError(
            seen.whose,
            f"was turned through angles that {seen.spec.model} does not see; it sees "
            f"{seen.model.span / DEG:.0f} deg: keep within them, or mount the horn anew",
        )
    if seen.high - seen.low > seen.model.pulses and not seen.endless:
        raise CalibrationError(
            seen.whose,
            f"was turned by {figure:.1f} deg, more than one turn: its servo could not tell one end "
            "from the other; turn it only as far as it may go, or give it a stop",
        )


def _turned(seen: Seen) -> int:
    """Give -1 if the direction must change: a joint's numbers are to grow with it."""
    if seen.sign > 0 or "Drive Mode" in seen.registers:
        return seen.sign
    raise CalibrationError(
        seen.whose,
        f"counts against the joint, and {seen.spec.model} has no Drive Mode that would turn that "
        "round: mount the servo the other way round, or turn the joint's axis in the arm's file",
    )


def _homing(seen: Seen) -> int:
    """Give the Homing Offset that counted while the joint was turned."""
    homing = seen.registers.get("Homing Offset", 0)
    one_turn = seen.registers.get("Operating Mode", ONE_TURN_MODE) == ONE_TURN_MODE
    return 0 if one_turn and abs(homing) > seen.model.pulses // _HOMING_SHARE else homing


def _span(seen: Seen, zero: float) -> tuple[float, float]:
    """Give from where to where the position must be right: travel and limits, ticks."""
    low, high = seen.travel
    if not seen.endless:
        low, high = min(low, seen.q_min), max(high, seen.q_max)
    per_rad = seen.model.pulses_per_rad
    return zero + low * per_rad, zero + high * per_rad


def whole_turn(model: ServoModel) -> tuple[int, int]:
    """Give the lowest and the highest position of a servo's one turn, ticks."""
    lowest = model.centre - model.pulses // 2
    return lowest, lowest + model.pulses - 1


def _turns_into_one(model: ServoModel, low: float, high: float) -> int | None:
    """Give how many turns bring a span into a servo's one turn, with a margin; None: none do."""
    first, last = whole_turn(model)
    if not counts_turns(model):
        return 0 if first - _ROUNDING <= low and high <= last + _ROUNDING else None
    margin = _MARGIN * model.pulses_per_rad
    turns = ceil((first + margin - low) / model.pulses)
    return turns if high + turns * model.pulses <= last - margin else None


def _mode(seen: Seen, low: float, high: float) -> int:
    """Give the mode in which the position is right all over a span."""
    mode = operating_mode(seen.spec)
    inside = _turns_into_one(seen.model, low, high) is not None and not seen.endless
    if mode != ONE_TURN_MODE or inside:
        return mode
    if MULTI_TURN_MODES[0] in seen.model.modes:
        return MULTI_TURN_MODES[0]
    raise CalibrationError(
        seen.whose,
        f"reaches beyond what its servo sees: it would have to say {low:.0f} to {high:.0f} ticks; "
        + _remount(seen, low, high),
    )


def _remount(seen: Seen, low: float, high: float) -> str:
    """Give in words what brings a span into one turn, or that nothing does."""
    model = seen.model
    room = (model.pulses - 1) / model.pulses_per_rad - 2.0 * _MARGIN * counts_turns(model)
    if high - low > room * model.pulses_per_rad:
        return (
            f"{(high - low) / model.pulses_per_rad / DEG:.0f} deg are more than it has: narrow the "
            "joint's limits in the arm's file, or turn it less far"
        )
    middle = sum(whole_turn(model)) / 2.0
    off = (low + high) / 2.0 - middle
    if counts_turns(model):
        off = (off + model.pulses / 2.0) % model.pulses - model.pulses / 2.0
    return f"mount its horn anew, {abs(off) / model.pulses_per_rad / DEG:.0f} deg from where it is"


def _check_turn(seen: Seen) -> tuple[str, ...]:
    """Refuse a travel in which the start could take one turn for another; say where it asks."""
    if seen.endless:
        return ("it turns without end: which turn it is in is forgotten with the power",)
    middle = (seen.q_min + seen.q_max) / 2.0
    low, high = seen.travel
    far = max(high - middle, middle - low)
    if far > (tau + _SEAM) / 2.0:
        raise CalibrationError(
            seen.whose,
            f"was turned from {low / DEG:.1f} to {high / DEG:.1f} deg, far outside its limits "
            f"({seen.q_min / DEG:.1f} to {seen.q_max / DEG:.1f} deg): after a loss of power its "
            "turn could not be told; put the arm in its pose anew, or correct the limits",
        )
    if max(seen.q_max - middle, far) > (tau - _SEAM) / 2.0:
        return (
            "it goes nearly a whole turn: near the ends the start will ask you to move it, as the "
            "turn is forgotten with the power",
        )
    return ()


def _settings(seen: Seen, mode: int, zero_ticks: int) -> dict[str, int]:
    """Give what the registers are to hold."""
    table, model = seen.model.table, seen.model
    wanted: dict[str, int] = {}
    if "Drive Mode" in table:
        now = seen.registers["Drive Mode"] & _REVERSED
        other = seen.spec.settings.get("Drive Mode", seen.registers["Drive Mode"]) & ~_REVERSED
        wanted["Drive Mode"] = other | (now ^ _REVERSED if _turned(seen) < 0 else now)
    if "Operating Mode" in table:
        wanted["Operating Mode"] = mode
    if "Homing Offset" in table:
        wanted["Homing Offset"] = 0
    if mode == ONE_TURN_MODE:
        first, last = whole_turn(model)
        ends = zip(range_registers(model), (seen.q_min, seen.q_max), strict=True)
        for name, q in ends:
            ticks = round(zero_ticks + q * model.pulses_per_rad)
            wanted[name] = min(max(ticks, first), last)
    return wanted


def _limit_notes(seen: Seen) -> tuple[str, ...]:
    """Say by how much the limits reach beyond where the joint was turned to."""
    low, high = seen.travel
    notes = []
    for beyond, end in ((low - seen.q_min, "lower"), (seen.q_max - high, "upper")):
        if not seen.endless and beyond > 5.0 * DEG:
            notes.append(f"its {end} limit is {beyond / DEG:.0f} deg beyond where it was turned to")
    return tuple(notes)
