"""``splinearm jog ARM``: move an arm by the keyboard."""

import argparse
import json
import logging
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from . import port_words

if TYPE_CHECKING:
    from splinearm.config import Cell
    from splinearm.jogging import Jogger, JogState
    from splinearm.jogging.waypoint import WaypointFile

    from .jog_key import Settings
    from .keyboard import Keyboard

_REDRAW = 0.1
"""Time between two drawings, s."""
_SHOWN = 3.0
"""How long a note stays on the screen, s."""


_EPILOG = """keys:
    up down       choose a joint, or 1 to 9; left and right move it
    tab           joints, the tool along the axes of the base, along its own
    m             moves while a key is held, or in steps
    + - [ ]       speed and step
    space         brakes
    g G           closes and opens the gripper
    w             saves this place as a waypoint
    q, esc        brake, hold and end

The screen says which keys move what.

exit codes:
    0  it was ended by q or esc; the arm holds
    1  a fault has ended it: it says whether the arm holds
    2  refused; nothing moved
  130  it was ended by Ctrl-C, SIGTERM or the loss of its terminal; the arm holds"""


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "jog",
        help="move an arm by the keyboard",
        description="Move an arm by the keyboard: joint by joint, or its tool along the axes of\n"
        "the base or of the tool. The tool does at most 250 mm/s. A terminal does not\n"
        "say when a key is let go: the arm brakes when no more of its repeats come, and\n"
        "holds, as it does when the terminal is closed.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("arm", help="the arm's file, or the name of an arm that is shipped")
    port_words.add_port(parser, virtual=False)
    parser.add_argument(
        "--on",
        choices=("mujoco", "virtual"),
        default=None,
        help="mujoco: a simulation; virtual: servos on a virtual bus instead of a port",
    )
    parser.add_argument(
        "--speed-mm-s",
        type=float,
        default=50.0,
        metavar="V",
        help="speed of the tool, mm/s (default: 50; at most 250)",
    )
    parser.add_argument(
        "--speed-deg-s",
        type=float,
        default=15.0,
        metavar="V",
        help="speed of turns, deg/s (default: 15; at most 60)",
    )
    parser.add_argument(
        "--step-mm", type=float, default=None, metavar="MM", help="move in steps of so much"
    )
    parser.add_argument(
        "--step-deg", type=float, default=None, metavar="DEG", help="turn in steps of so much"
    )
    parser.add_argument(
        "--waypoints",
        type=Path,
        default=None,
        metavar="FILE",
        help="the job file to which w appends a place; a new one is begun",
    )
    parser.add_argument(
        "--json", action="store_true", help="say in the end, as JSON, where the arm holds"
    )
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Open, jog, hold, say where."""
    from splinearm.backends import open_arm
    from splinearm.config import load_cell
    from splinearm.control.stop import StopRequest
    from splinearm.errors import MotionError, TerminalLostError
    from splinearm.jogging import Jogger
    from splinearm.jogging.waypoint import WaypointFile

    from .keyboard import Keyboard

    cell = load_cell(args.arm)
    session = Session(cell, args)
    waypoints = WaypointFile(args.waypoints, cell)
    where = port_words.port_of(args, cell, announce=session.say)
    lost = False
    try:
        with (
            StopRequest() as stop,
            Keyboard() as keyboard,
            open_arm(cell, where, realtime=True) as station,
            Jogger(
                station, cell, stop=stop, observe=session.observe, announce=session.say
            ) as jogger,
        ):
            try:
                session.attend(keyboard, jogger, waypoints, station.where)
            except (TerminalLostError, OSError):  # nobody sees or steers it any more
                lost = True
    except MotionError as fault:
        if args.json:
            _print_json(cell, session, waypoints, str(fault))
        raise
    with suppress(OSError):  # of a terminal that is gone
        _report(cell, session, waypoints, args)
    return 0 if session.ended_by_key and not lost else 130


class Session:
    """A person at the keys of an arm.

    Args:
        cell: The arm.
        args: What was said on the command line.

    Raises:
        ConfigError: If a speed or a step is none that can be.
    """

    def __init__(self, cell: "Cell", args: argparse.Namespace) -> None:
        from .jog_key import KeyRepeat

        self._cell = cell
        self._settings = _settings(cell, args)
        self._repeat = KeyRepeat()
        self._notes: deque[tuple[float, str]] = deque(maxlen=1)
        self.fastest = 0.0
        """How fast the tool was told to be at its fastest, m/s."""
        self.last: JogState | None = None
        """What the arm did last."""
        self.ended_by_key = False
        """Whether q or Esc ended it."""

    def say(self, words: str) -> None:
        """Put a line on the screen, from any thread."""
        self._notes.append((time.monotonic(), words))

    def observe(self, state: "JogState") -> None:
        """Take note of a cycle, in the loop."""
        self.last = state
        velocity = self._cell.arm.jacobian(state.setpoint.q)[:3] @ state.setpoint.qd
        self.fastest = max(self.fastest, float(velocity @ velocity) ** 0.5)
        if state.hindrance is not None and not state.hindrance.temporary:
            self.say(state.hindrance.words)

    def attend(
        self,
        keyboard: "Keyboard",
        jogger: "Jogger",
        waypoints: "WaypointFile",
        where: str,
    ) -> None:
        """Read keys and draw until the jogging ends, by a wish or a fault."""
        from .jog_screen import Screen, screen_file

        with _said_by(self.say), Screen(screen_file()) as screen:
            drawn = 0.0
            while not jogger.ends:
                key = keyboard.read(_REDRAW / 4.0)
                while key is not None and not jogger.ends:
                    self._press(key, jogger, waypoints)
                    key = keyboard.read(0.0)
                if time.monotonic() - drawn >= _REDRAW:
                    drawn = time.monotonic()
                    screen.draw(self._lines(jogger, where))

    def _press(self, key: str, jogger: "Jogger", waypoints: "WaypointFile") -> None:
        self._repeat.press(key, time.monotonic())
        if key in ("q", "esc"):
            self.ended_by_key = True
            jogger.end()
        elif key == " ":
            jogger.brake()
        elif key == "w":
            self._save(jogger, waypoints)
        elif key in "gG" and jogger.has_gripper:
            jogger.grip(0.0 if key == "g" else 100.0)
        elif not self._settings.change(key):
            self._move(key, jogger)

    def _move(self, key: str, jogger: "Jogger") -> None:
        from splinearm.joints import JointKind

        chosen = self._settings
        slides = self._cell.arm.limits.kinds[chosen.joint] is JointKind.PRISMATIC
        rates = chosen.rates(key, slides)
        if rates is None:
            self.say(f"{key}: no key of this mode")
            return
        frame = chosen.frame
        if chosen.stepping:
            if jogger.state.stepping or jogger.state.moving:
                return  # one step at a time, also while a key is held
            duration = chosen.step_time(rates, slides)
            if frame is None:
                jogger.step_joints(rates * duration, duration)
            else:
                jogger.step_tool(rates * duration, duration, frame)
        elif frame is None:
            jogger.joints(rates, self._repeat.lasts)
        else:
            jogger.tool(rates, frame, self._repeat.lasts)

    def _save(self, jogger: "Jogger", waypoints: "WaypointFile") -> None:
        from splinearm.errors import ConfigError

        if jogger.state.moving:
            self.say("w: the arm moves; let it rest first")
            return
        try:
            self.say(waypoints.save(jogger.state.setpoint.q))
        except ConfigError as error:
            self.say(str(error))

    def _lines(self, jogger: "Jogger", where: str) -> list[str]:
        from .jog_screen import View, lines

        now = jogger.state
        note = ""
        if self._notes and time.monotonic() - self._notes[-1][0] < _SHOWN:
            note = f"! {self._notes[-1][1]}"
        held = "" if self._settings.stepping else f" after {self._repeat.lasts:.2f} s without a key"
        view = View(
            cell=self._cell,
            where=where,
            settings=self._settings,
            q=now.setpoint.q if now.state is None else now.state.q,
            moving=now.moving,
            note=note,
            brakes=f"it brakes{held} and rests within {jogger.stop_time:.2f} s",
            has_gripper=jogger.has_gripper,
        )
        return lines(view)


class _Teller(logging.Handler):
    """Says what is logged."""

    def __init__(self, say: Callable[[str], object]) -> None:
        super().__init__()
        self._say = say

    def emit(self, record: logging.LogRecord) -> None:
        self._say(record.getMessage())


@contextmanager
def _said_by(say: Callable[[str], object]) -> Iterator[None]:
    """Let what is logged be said on the screen, not across it."""
    root = logging.getLogger()
    before, root.handlers = root.handlers, [_Teller(say)]
    try:
        yield
    finally:
        root.handlers = before


def _settings(cell: "Cell", args: argparse.Namespace) -> "Settings":
    from splinearm.errors import ConfigError

    from .jog_key import Settings

    for name, most in (
        ("speed_mm_s", 250.0),
        ("speed_deg_s", 60.0),
        ("step_mm", 100.0),
        ("step_deg", 90.0),
    ):
        value = getattr(args, name)
        if value is not None and not 0.0 < value <= most:
            option = f"--{name.replace('_', '-')}"
            raise ConfigError(option, "", f"want above 0 and at most {most:g}, got {value:g}")
    chosen = Settings(n=cell.arm.n, speed_mm=args.speed_mm_s, speed_deg=args.speed_deg_s)
    chosen.stepping = args.step_mm is not None or args.step_deg is not None
    chosen.step_mm = args.step_mm or chosen.step_mm
    chosen.step_deg = args.step_deg or chosen.step_deg
    return chosen


def _report(
    cell: "Cell", session: Session, waypoints: "WaypointFile", args: argparse.Namespace
) -> None:
    """Say where the arm holds, and what was saved."""
    from splinearm.jogging.waypoint import pose_words

    if args.json:
        _print_json(cell, session, waypoints)
    elif session.last is not None:
        q = session.last.setpoint.q
        angles = ", ".join(f"{angle:.1f}" for angle in cell.to_file_units(q))
        print(f"the arm holds at {angles}")
        print(f"tool in base: {pose_words(cell, q)}")
        if args.waypoints is None and waypoints.lines:
            print("", *waypoints.lines, sep="\n", end="")


def _print_json(
    cell: "Cell", session: Session, waypoints: "WaypointFile", fault: str | None = None
) -> None:
    last = session.last
    told = {
        "arm": cell.name,
        "joints": list(cell.arm.joint_names),
        "fault": fault,
        "ended_by_key": session.ended_by_key,
        "holds_at": None if last is None else cell.to_file_units(last.setpoint.q).tolist(),
        "T_base_tool": None if last is None else cell.arm.fk(last.setpoint.q).tolist(),
        "fastest_mm_s": session.fastest * 1e3,
        "waypoints": waypoints.lines,
    }
    print(json.dumps(told))
