"""What is done to virtual servos and their line, and what the doctor must say of it.

The table of docs/troubleshooting.md is made of these and of ``computer_cases``.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from splinearm.config import Cell
from splinearm.sim.choice import Choices
from splinearm.sim.line_fault import LineFault
from splinearm.sim.virtual_bus import VirtualBus


@dataclass(frozen=True, kw_only=True)
class LineCase:
    """One fault of servos, line or arm file."""

    code: str
    """What must be found."""
    act: str
    """What is done, in words."""
    cause: str
    """What the cause must say (a regular expression)."""
    remedy: str
    """The same of the remedy."""
    where: str = ""
    """What is concerned, if not the port."""
    arm: str = "planar_2r"
    transport: str = "socket"
    hurt: Callable[[VirtualBus], None] = lambda _: None
    cell: Callable[[Cell], Cell] = lambda cell: cell
    also: frozenset[str] = frozenset()
    """Other codes that follow from the same fault."""
    wiring: dict[str, Any] = field(default_factory=dict)


def _register(servo_id: int, name: str, value: int) -> Callable[[VirtualBus], None]:
    def hurt(bus: VirtualBus) -> None:
        bus.servos[servo_id].memory[name] = value

    return hurt


def _fails(servo_id: int, *names: str) -> Callable[[VirtualBus], None]:
    def hurt(bus: VirtualBus) -> None:
        bus.servos[servo_id].fail(*names)

    return hurt


def _faults(*texts: str) -> Callable[[VirtualBus], None]:
    def hurt(bus: VirtualBus) -> None:
        bus.faults = tuple(LineFault.parse(text) for text in texts)

    return hurt


def _without(name: str, **settings: Any) -> Callable[[Cell], Cell]:
    """Take a servo out of the file, or change one."""

    def change(cell: Cell) -> Cell:
        servos = tuple(
            replace(s, **settings) if s.name == name else s
            for s in cell.chain.servos
            if settings or s.name != name
        )
        return replace(cell, chain=replace(cell.chain, servos=servos))

    return change


def _unplugged(*ids: int) -> Callable[[VirtualBus], None]:
    def hurt(bus: VirtualBus) -> None:
        for servo_id in ids:
            bus.servos[servo_id].unplugged = True

    return hurt


def _silent(bus: VirtualBus) -> None:
    bus.silent = True


def _echo_only(bus: VirtualBus) -> None:
    bus.silent = True
    bus.faults = (LineFault.parse("echo"),)


def _all_at_57600(bus: VirtualBus) -> None:
    for servo in bus.all_servos:
        servo.memory["Baud Rate"] = 1


def _fresh(bus: VirtualBus) -> None:
    bus.servos[5].choices = Choices(boot_time=0.0)
    bus.servos[5].swap()


def _all_fresh(bus: VirtualBus) -> None:
    for servo in bus.all_servos:
        servo.choices = Choices(boot_time=0.0)
        servo.swap()


def _slow_line(cell: Cell) -> Cell:
    return replace(cell, chain=replace(cell.chain, baud=57_600))


def _temperature(bus: VirtualBus) -> None:
    bus.servos[2].heat.ambient = 70.0
    bus.servos[2].temperature = 70.0


def _volts(value: float) -> Callable[[VirtualBus], None]:
    def hurt(bus: VirtualBus) -> None:
        bus.servos[1].voltage = value

    return hurt


def _far(bus: VirtualBus) -> None:
    bus.servos[2].slip(float(np.deg2rad(75.0)))


def _slip_shadow(bus: VirtualBus) -> None:
    bus.servos[3].slip(0.2)


def _many_turns(cell: Cell) -> Cell:
    chain = cell.chain
    settings = {**chain.servos[1].settings, "Operating Mode": 4}
    servos = (chain.servos[0], replace(chain.servos[1], settings=settings))
    limits = cell.arm.limits
    only_second = np.array([1.0, 3.0])
    wide = replace(limits, q_min=limits.q_min * only_second, q_max=limits.q_max * only_second)
    return replace(cell, arm=replace(cell.arm, limits=wide), chain=replace(chain, servos=servos))


def _reflash(firmware: int) -> Callable[[VirtualBus], None]:
    def hurt(bus: VirtualBus) -> None:
        bus.servos[1].choices = Choices(boot_time=0.0)
        bus.servos[1].reflash(firmware)

    return hurt


def _other_model(cell: Cell) -> Cell:
    servo = cell.chain.servos[1]
    return replace(
        cell,
        chain=replace(
            cell.chain, servos=(cell.chain.servos[0], replace(servo, model="XM540-W270"))
        ),
    )


def _uncalibrated(cell: Cell) -> Cell:
    return _without(cell.chain.servos[0].name, zero_ticks=None)(cell)


def _strange_shadow(bus: VirtualBus) -> None:
    bus.servos[3].memory["Secondary(Shadow) ID"] = 255


_MEND = r"run `splinearm setup planar_2r --port \S+`: it sets "

LINE_CASES = (
    LineCase(
        code="L01",
        act="the cable to all servos is cut",
        hurt=_silent,
        cause="nobody answers at 1M baud",
        remedy="power on.*cable.*splinearm scan unix:",
    ),
    LineCase(
        code="L01",
        act="no power: only the adapter's echo comes back",
        hurt=_echo_only,
        cause="only what was sent comes back",
        remedy="power on",
        also=frozenset({"L11"}),
    ),
    LineCase(
        code="L02",
        act="one servo is left at 57600 baud",
        hurt=_register(2, "Baud Rate", 1),
        transport="pty",
        where=r"servo 2 \(joint2\)",
        cause="at 57600 baud; the arm's file says 1000000",
        remedy=_MEND + r"Baud Rate \(address 8\) of servo 2 to 3",
    ),
    LineCase(
        code="L02",
        act="every servo is at 57600 baud, as from the factory",
        hurt=_all_at_57600,
        transport="pty",
        where="servo [12]",
        cause="at 57600 baud",
        remedy="Baud Rate",
    ),
    LineCase(
        code="L03",
        act="a servo speaks protocol 1.0",
        hurt=_register(2, "Protocol Type", 1),
        where="servo 2",
        cause="protocol 1.0; the arm's file says 2.0",
        remedy=r"Protocol Type \(address 13\) of servo 2 to 2",
    ),
    LineCase(
        code="L04",
        act="one servo in the middle has lost its data cable",
        arm="wx250s",
        hurt=_unplugged(4),
        cause=r"no answer from servo 4 \(elbow\)",
        remedy="check its cable",
    ),
    LineCase(
        code="L04",
        act="the cable behind the sixth servo is out",
        arm="wx250s",
        hurt=_unplugged(7, 8, 9),
        cause=r"servos 7.*all that come after servo 6 \(forearm_roll\)",
        remedy="cable that leaves servo 6",
    ),
    LineCase(
        code="L04",
        act="a servo was replaced by one fresh from the factory (id 1, 57600 baud)",
        arm="wx250s",
        transport="pty",
        hurt=_fresh,
        cause=r"servo 5 \(elbow_shadow\); a XM430-W350 fresh from the factory",
        remedy="splinearm setup wx250s --port .*gives it id 5 and 1000000 baud",
        also=frozenset({"L06"}),
    ),
    LineCase(
        code="L05",
        act="two servos of one model have the same id",
        arm="wx250s",
        hurt=_register(7, "ID", 6),
        where=r"servo 6 \(forearm_roll\)",
        cause=r"two servos have this id.*missing servo 7 \(wrist_angle\)",
        remedy="splinearm setup wx250s --port .*gives the other its own id",
    ),
    LineCase(
        code="L05",
        act="two servos of different models have the same id",
        arm="wx250s",
        hurt=_register(8, "ID", 7),
        where="servo 7",
        cause=r"missing servo 8 \(wrist_rotate\)",
        remedy="unplug the cable to one",
    ),
    LineCase(
        code="L05",
        act="all servos are fresh out of the box: each has id 1 at 57600 baud",
        transport="pty",
        hurt=_all_fresh,
        where="servo 1$",
        cause=r"at 57600 baud, but garbled.*missing 1 \(joint1\), 2 \(joint2\) may be among",
        remedy="splinearm setup planar_2r --port .*one after the other",
    ),
    LineCase(
        code="L06",
        act="a servo answers that the arm's file does not name",
        arm="wx250s",
        cell=_without("gripper"),
        where="servo 9",
        cause="a XL430-W250 answers at 1000000 baud",
        remedy="unplug it, or add",
    ),
    LineCase(
        code="L07",
        act="noise: one byte in a hundred is another",
        hurt=_faults("garbled p=0.01"),
        cause="answers are damaged",
        remedy="away from motors",
    ),
    LineCase(
        code="L07",
        act="a bad plug at one servo: half of its answers are damaged",
        arm="wx250s",
        hurt=_faults("corrupt id=4 p=0.5"),
        where=r"servo 4 \(elbow\)",
        cause="answers are damaged, and few or none of the others'",
        remedy="plugs at this servo",
    ),
    LineCase(
        code="L07",
        act="bytes of noise before every answer",
        hurt=_faults("noise"),
        cause="answers are damaged",
        remedy="away from motors",
    ),
    LineCase(
        code="L07",
        act="a third of the answers is cut short",
        hurt=_faults("truncated p=0.3"),
        cause="answers are damaged",
        remedy="away from motors",
    ),
    LineCase(
        code="L07",
        act="every answer comes twice",
        hurt=_faults("doubled"),
        cause="answers are damaged",
        remedy="away from motors",
    ),
    LineCase(
        code="L08",
        act="two fifths of one servo's answers are lost",
        arm="wx250s",
        hurt=_faults("lost id=4 p=0.4"),
        where="servo 4",
        cause="answers are lost",
        remedy="plugs at this servo",
    ),
    LineCase(
        code="L08",
        act="a tenth of all answers is lost",
        hurt=_faults("lost p=0.1"),
        cause="answers are lost",
        remedy="tighten the plugs",
    ),
    LineCase(
        code="L09",
        act="Return Delay Time at its factory setting of 500 us",
        hurt=_register(1, "Return Delay Time", 250),
        where=r"servo 1 \(joint1\)",
        cause="waits 500 us",
        remedy=r"Return Delay Time \(address 9\) of servo 1 to 0",
    ),
    LineCase(
        code="L10",
        act="Status Return Level is 1: writes are not answered",
        hurt=_register(2, "Status Return Level", 1),
        where="servo 2",
        cause="Status Return Level is 1",
        remedy="power off and on",
    ),
    LineCase(
        code="L10",
        act="Status Return Level is 0: only pings are answered",
        hurt=_register(2, "Status Return Level", 0),
        where="servo 2",
        cause="answers pings and no reads",
        remedy="power off and on",
    ),
    LineCase(
        code="L11",
        act="the adapter hears itself",
        hurt=_faults("echo"),
        cause="comes back before the answer",
        remedy="echo of the adapter off",
    ),
    LineCase(
        code="P05",
        act="something holds answers back for 16 ms, and no latency timer says so",
        wiring={"usb_latency": 0.016},
        cause="handed over only every 1[4-7] ms",
        remedy="straight into the computer",
        also=frozenset({"C07"}),
    ),
    LineCase(
        code="S01",
        act="the arm's file names another model",
        cell=_other_model,
        where="servo 2",
        cause="it is a XM430-W350; the arm's file says XM540-W270",
        remedy='model = "XM430-W350"',
    ),
    LineCase(
        code="S01",
        act="a servo of a model that nobody knows",
        hurt=_register(2, "Model Number", 9999),
        where="servo 2",
        cause="its model number, 9999, is not known here; the arm's file says XM430-W350",
        remedy="known model .*XM430-W350",
    ),
    LineCase(
        code="S02",
        act="a servo with firmware 40",
        hurt=_reflash(40),
        where="servo 1",
        cause="firmware is 40, older than 42",
        remedy="update it",
    ),
    LineCase(
        code="S03",
        act="a servo with firmware 44, the last without fast reads",
        hurt=_reflash(44),
        where="servo 1",
        cause="44; from 45 on it answers fast reads",
        remedy="update it",
    ),
    LineCase(
        code="S04",
        act="the supply sags to 9.8 V",
        hurt=_volts(9.8),
        where="servo 1",
        cause="supply is 9.8 V",
        remedy="stronger supply",
    ),
    LineCase(
        code="S05",
        act="a supply of 15.9 V",
        hurt=_volts(15.9),
        where="servo 1",
        cause="supply is 15.9 V",
        remedy="lower the supply",
    ),
    LineCase(
        code="S06",
        act="input voltage error latched",
        hurt=_fails(1, "input voltage"),
        where="servo 1",
        cause="too low or too high",
        remedy="measure the supply.*splinearm recover planar_2r --port",
    ),
    LineCase(
        code="S07",
        act="overheating error latched",
        hurt=_fails(1, "overheating"),
        where="servo 1",
        cause="too hot",
        remedy="cool down.*splinearm recover",
        also=frozenset({"S11"}),
    ),
    LineCase(
        code="S08",
        act="motor encoder error latched",
        hurt=_fails(1, "motor encoder"),
        where="servo 1",
        cause="encoder cannot be trusted",
        remedy="follows the joint moved by hand",
    ),
    LineCase(
        code="S09",
        act="electrical shock error latched",
        hurt=_fails(1, "electrical shock"),
        where="servo 1",
        cause="surge",
        remedy="no wire is pinched",
        also=frozenset({"S11"}),
    ),
    LineCase(
        code="S10",
        act="overload error latched",
        hurt=_fails(2, "overload"),
        where="servo 2",
        cause="load was too high",
        remedy="free the joint.*splinearm recover",
        also=frozenset({"S11"}),
    ),
    LineCase(
        code="S11",
        act="the same: torque is refused until a reboot",
        hurt=_fails(2, "overload"),
        where="servo 2",
        cause="cut its torque because of overload and refuses it",
        remedy="splinearm recover planar_2r --port",
        also=frozenset({"S10"}),
    ),
    LineCase(
        code="S12",
        act="PWM Limit is 0",
        hurt=_register(2, "PWM Limit", 0),
        where="servo 2",
        cause="PWM Limit is 0",
        remedy=r"PWM Limit \(address 36\) of servo 2 to 885",
    ),
    LineCase(
        code="S13",
        act="a servo at 70 degC",
        hurt=_temperature,
        where="servo 2",
        cause="at (69|70|71) degC",
        remedy="cool down",
    ),
    LineCase(
        code="S14",
        act="Drive Mode is reversed",
        hurt=_register(2, "Drive Mode", 1),
        where="servo 2",
        cause="Drive Mode is 1, the arm's file says 0: the joint would turn the other way",
        remedy=r"Drive Mode \(address 10\) of servo 2 to 0",
    ),
    LineCase(
        code="S15",
        act="Drive Mode has profiles by time",
        hurt=_register(2, "Drive Mode", 4),
        where="servo 2",
        cause="Drive Mode is 4",
        remedy="Drive Mode",
    ),
    LineCase(
        code="S16",
        act="Operating Mode is velocity",
        hurt=_register(2, "Operating Mode", 1),
        where="servo 2",
        cause="Operating Mode is 1, the arm's file says 3",
        remedy=r"Operating Mode \(address 11\) of servo 2 to 3",
    ),
    LineCase(
        code="S17",
        act="a Homing Offset of 100 ticks",
        hurt=_register(2, "Homing Offset", 100),
        where="servo 2",
        cause="Homing Offset is 100, the arm's file says 0",
        remedy=r"Homing Offset \(address 20\) of servo 2 to 0",
    ),
    LineCase(
        code="S18",
        act="a shadow does not follow its leader's id",
        arm="wx250s",
        hurt=_strange_shadow,
        where=r"servo 3 \(shoulder_shadow\)",
        cause=r"Secondary\(Shadow\) ID is 255, the arm's file says 2",
        remedy=r"Secondary\(Shadow\) ID \(address 12\) of servo 3 to 2",
    ),
    LineCase(
        code="S19",
        act="the servo's position limits end within the joint's range",
        hurt=_register(2, "Max Position Limit", 2500),
        where="servo 2",
        cause="Max Position Limit is 2500, but joint 'joint2' may go to",
        remedy=r"Max Position Limit \(address 48\) of servo 2",
    ),
    LineCase(
        code="S20",
        act="Velocity Limit differs from the arm's file",
        arm="wx250s",
        hurt=_register(1, "Velocity Limit", 60),
        where="servo 1",
        cause="Velocity Limit is 60, the arm's file says 131",
        remedy="Velocity Limit",
    ),
    LineCase(
        code="S21",
        act="a joint whose zero is left to calibration",
        cell=_uncalibrated,
        where="servo 1",
        cause="zero is not known",
        remedy="splinearm calibrate",
    ),
    LineCase(
        code="S22",
        act="a slipped horn: the joint reads far outside its range",
        hurt=_far,
        where="servo 2",
        cause="its range is",
        remedy="by hand",
    ),
    LineCase(
        code="S22",
        act="a joint of three turns: which turn it is in cannot be told",
        cell=_many_turns,
        hurt=_register(2, "Operating Mode", 4),
        where="servo 2",
        cause="which turn joint 'joint2' is in cannot be told",
        remedy="by hand, or narrow its limits to less than one turn",
    ),
    LineCase(
        code="S23",
        act="a shadow's horn has slipped by 0.2 rad",
        arm="wx250s",
        hurt=_slip_shadow,
        where="servo 3",
        cause="ticks from its leader 'shoulder'",
        remedy="Homing Offset",
    ),
    LineCase(
        code="S24",
        act="the servo's own watchdog has stopped it",
        hurt=_register(2, "Bus Watchdog", 255),
        where="servo 2",
        cause="watchdog stopped it",
        remedy="splinearm recover",
    ),
    LineCase(
        code="C07",
        act="servos at 57600 baud, and the file says so: the loop cannot have 100 Hz",
        arm="planar_2r",
        transport="pty",
        cell=_slow_line,
        hurt=_all_at_57600,
        cause=r"76 Hz follow from 40 \+ 36 bytes for 2 servos at 57600 baud",
        remedy="higher Baud Rate",
    ),
)
