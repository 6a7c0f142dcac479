"""What is done to virtual servos and their line, and what the doctor must say of it.

The table of docs/troubleshooting.md is made of these and of ``computer_cases``.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from fault_case import FaultCase, nothing

from splinearm.config import Cell
from splinearm.sim.choice import Choices
from splinearm.sim.line_fault import LineFault
from splinearm.sim.virtual_bus import VirtualBus


@dataclass(frozen=True, kw_only=True)
class LineCase(FaultCase):
    """One fault of servos, line or arm file; ``hurt`` gets the virtual bus."""

    where: str = ""
    """What is concerned (a regular expression), if not the port."""
    arm: str = "planar_2r"
    transport: str = "socket"
    cell: Callable[[Cell], Cell] = lambda cell: cell
    """Changes what the arm's file says."""
    also: frozenset[str] = frozenset()
    """Other codes that follow from the same fault."""
    wiring: dict[str, Any] = field(default_factory=dict)
    """Options of the virtual bus."""


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
    LineCase("L01", "the cable to all servos is cut", _silent,
             "nobody answers at 1M baud", "power on.*cable.*splinearm scan unix:"),
    LineCase("L01", "no power: only the adapter's echo comes back", _echo_only,
             "only what was sent comes back", "power on", also=frozenset({"L11"})),
    LineCase("L02", "one servo is left at 57600 baud", _register(2, "Baud Rate", 1),
             "at 57600 baud; the arm's file says 1000000",
             _MEND + r"Baud Rate \(address 8\) of servo 2 to 3",
             where=r"servo 2 \(joint2\)", transport="pty"),
    LineCase("L02", "every servo is at 57600 baud, as from the factory", _all_at_57600,
             "at 57600 baud", "Baud Rate", where="servo [12]", transport="pty"),
    LineCase("L03", "a servo speaks protocol 1.0", _register(2, "Protocol Type", 1),
             "protocol 1.0; the arm's file says 2.0",
             r"Protocol Type \(address 13\) of servo 2 to 2", where="servo 2"),
    LineCase("L04", "one servo in the middle has lost its data cable", _unplugged(4),
             r"no answer from servo 4 \(elbow\)", "check its cable", arm="wx250s"),
    LineCase("L04", "the cable behind the sixth servo is out", _unplugged(7, 8, 9),
             r"servos 7.*all that come after servo 6 \(forearm_roll\)",
             "cable that leaves servo 6", arm="wx250s"),
    LineCase("L04", "a servo was replaced by one fresh from the factory (id 1, 57600 baud)", _fresh,
             r"servo 5 \(elbow_shadow\); a XM430-W350 fresh from the factory",
             "splinearm setup wx250s --port .*gives it id 5 and 1000000 baud",
             arm="wx250s", transport="pty", also=frozenset({"L06"})),
    LineCase("L05", "two servos of one model have the same id", _register(7, "ID", 6),
             r"two servos have this id.*missing servo 7 \(wrist_angle\)",
             "splinearm setup wx250s --port .*gives the other its own id",
             where=r"servo 6 \(forearm_roll\)", arm="wx250s"),
    LineCase("L05", "two servos of different models have the same id", _register(8, "ID", 7),
             r"missing servo 8 \(wrist_rotate\)", "unplug the cable to one",
             where="servo 7", arm="wx250s"),
    LineCase("L05", "all servos are fresh out of the box: each has id 1 at 57600 baud", _all_fresh,
             r"at 57600 baud, but garbled.*missing 1 \(joint1\), 2 \(joint2\) may be among",
             "splinearm setup planar_2r --port .*one after the other",
             where="servo 1$", transport="pty"),
    LineCase("L06", "a servo answers that the arm's file does not name", nothing,
             "a XL430-W250 answers at 1000000 baud", "unplug it, or add",
             where="servo 9", arm="wx250s", cell=_without("gripper")),
    LineCase("L07", "noise: one byte in a hundred is another", _faults("garbled p=0.01"),
             "answers are damaged", "away from motors"),
    LineCase("L07", "a bad plug at one servo: half of its answers are damaged",
             _faults("corrupt id=4 p=0.5"),
             "answers are damaged, and few or none of the others'", "plugs at this servo",
             where=r"servo 4 \(elbow\)", arm="wx250s"),
    LineCase("L07", "bytes of noise before every answer", _faults("noise"),
             "answers are damaged", "away from motors"),
    LineCase("L07", "a third of the answers is cut short", _faults("truncated p=0.3"),
             "answers are damaged", "away from motors"),
    LineCase("L07", "every answer comes twice", _faults("doubled"),
             "answers are damaged", "away from motors"),
    LineCase("L08", "two fifths of one servo's answers are lost", _faults("lost id=4 p=0.4"),
             "answers are lost", "plugs at this servo", where="servo 4", arm="wx250s"),
    LineCase("L08", "a fifth of all answers is lost", _faults("lost p=0.2"),
             "answers are lost", "tighten the plugs"),
    LineCase("L09", "Return Delay Time at its factory setting of 500 us",
             _register(1, "Return Delay Time", 250),
             "waits 500 us", r"Return Delay Time \(address 9\) of servo 1 to 0",
             where=r"servo 1 \(joint1\)"),
    LineCase("L10", "Status Return Level is 1: writes are not answered",
             _register(2, "Status Return Level", 1),
             "Status Return Level is 1", "power off and on", where="servo 2"),
    LineCase("L10", "Status Return Level is 0: only pings are answered",
             _register(2, "Status Return Level", 0),
             "answers pings and no reads", "power off and on", where="servo 2"),
    LineCase("L11", "the adapter hears itself", _faults("echo"),
             "comes back before the answer", "echo of the adapter off"),
    LineCase("P05", "something holds answers back for 16 ms, and no latency timer says so",
             nothing,
             "handed over only every 1[4-7] ms", "straight into the computer",
             also=frozenset({"C07"}), wiring={"usb_latency": 0.016}),
    LineCase("S01", "the arm's file names another model", nothing,
             "it is a XM430-W350; the arm's file says XM540-W270", 'model = "XM430-W350"',
             where="servo 2", cell=_other_model),
    LineCase("S01", "a servo of a model that nobody knows", _register(2, "Model Number", 9999),
             "its model number, 9999, is not known here; the arm's file says XM430-W350",
             "known model .*XM430-W350", where="servo 2"),
    LineCase("S02", "a servo with firmware 40", _reflash(40),
             "firmware is 40, older than 42", "update it", where="servo 1"),
    LineCase("S03", "a servo with firmware 44, the last without fast reads", _reflash(44),
             "44; from 45 on it answers fast reads", "update it", where="servo 1"),
    LineCase("S04", "the supply sags to 9.8 V", _volts(9.8),
             "supply is 9.8 V", "stronger supply", where="servo 1"),
    LineCase("S05", "a supply of 15.9 V", _volts(15.9),
             "supply is 15.9 V", "lower the supply", where="servo 1"),
    LineCase("S06", "input voltage error latched", _fails(1, "input voltage"),
             "too low or too high", "measure the supply.*splinearm recover planar_2r --port",
             where="servo 1"),
    LineCase("S07", "overheating error latched", _fails(1, "overheating"),
             "too hot", "cool down.*splinearm recover", where="servo 1", also=frozenset({"S11"})),
    LineCase("S08", "motor encoder error latched", _fails(1, "motor encoder"),
             "encoder cannot be trusted", "follows the joint moved by hand", where="servo 1"),
    LineCase("S09", "electrical shock error latched", _fails(1, "electrical shock"),
             "surge", "no wire is pinched", where="servo 1", also=frozenset({"S11"})),
    LineCase("S10", "overload error latched", _fails(2, "overload"),
             "load was too high", "free the joint.*splinearm recover",
             where="servo 2", also=frozenset({"S11"})),
    LineCase("S11", "the same: torque is refused until a reboot", _fails(2, "overload"),
             "cut its torque because of overload and refuses it",
             "splinearm recover planar_2r --port", where="servo 2", also=frozenset({"S10"})),
    LineCase("S12", "PWM Limit is 0", _register(2, "PWM Limit", 0),
             "PWM Limit is 0", r"PWM Limit \(address 36\) of servo 2 to 885", where="servo 2"),
    LineCase("S13", "a servo at 70 degC", _temperature,
             "at (69|70|71) degC", "cool down", where="servo 2"),
    LineCase("S14", "Drive Mode is reversed", _register(2, "Drive Mode", 1),
             "Drive Mode is 1, the arm's file says 0: the joint would turn the other way",
             r"Drive Mode \(address 10\) of servo 2 to 0", where="servo 2"),
    LineCase("S15", "Drive Mode has profiles by time", _register(2, "Drive Mode", 4),
             "Drive Mode is 4", "Drive Mode", where="servo 2"),
    LineCase("S16", "Operating Mode is velocity", _register(2, "Operating Mode", 1),
             "Operating Mode is 1, the arm's file says 3",
             r"Operating Mode \(address 11\) of servo 2 to 3", where="servo 2"),
    LineCase("S17", "a Homing Offset of 100 ticks", _register(2, "Homing Offset", 100),
             "Homing Offset is 100, the arm's file says 0",
             r"Homing Offset \(address 20\) of servo 2 to 0", where="servo 2"),
    LineCase("S18", "a shadow does not follow its leader's id", _strange_shadow,
             r"Secondary\(Shadow\) ID is 255, the arm's file says 2",
             r"Secondary\(Shadow\) ID \(address 12\) of servo 3 to 2",
             where=r"servo 3 \(shoulder_shadow\)", arm="wx250s"),
    LineCase("S19", "the servo's position limits end within the joint's range",
             _register(2, "Max Position Limit", 2500),
             "Max Position Limit is 2500, but joint 'joint2' may go to",
             r"Max Position Limit \(address 48\) of servo 2", where="servo 2"),
    LineCase("S20", "Velocity Limit differs from the arm's file",
             _register(1, "Velocity Limit", 60),
             "Velocity Limit is 60, the arm's file says 131", "Velocity Limit",
             where="servo 1", arm="wx250s"),
    LineCase("S21", "a joint whose zero is left to calibration", nothing,
             "zero is not known", "splinearm calibrate", where="servo 1", cell=_uncalibrated),
    LineCase("S22", "a slipped horn: the joint reads far outside its range", _far,
             "its range is", "by hand", where="servo 2"),
    LineCase("S22", "a joint of three turns: which turn it is in cannot be told",
             _register(2, "Operating Mode", 4),
             "which turn joint 'joint2' is in cannot be told",
             "by hand, or narrow its limits to less than one turn",
             where="servo 2", cell=_many_turns),
    LineCase("S23", "a shadow's horn has slipped by 0.2 rad", _slip_shadow,
             "ticks from its leader 'shoulder'", "Homing Offset", where="servo 3", arm="wx250s"),
    LineCase("S24", "the servo's own watchdog has stopped it", _register(2, "Bus Watchdog", 255),
             "watchdog stopped it", "splinearm recover", where="servo 2"),
    LineCase("C07", "servos at 57600 baud, and the file says so: the loop cannot have 100 Hz",
             _all_at_57600,
             r"76 Hz follow from 40 \+ 36 bytes for 2 servos at 57600 baud", "higher Baud Rate",
             transport="pty", cell=_slow_line),
)  # fmt: skip
