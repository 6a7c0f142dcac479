"""``splinearm teach ARM``: record motions led by hand and keep them as a job."""

import argparse
from collections.abc import Callable
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from .port_words import add_port, port_of

if TYPE_CHECKING:
    from splinearm.backends import Station
    from splinearm.config import Cell
    from splinearm.drivers.gripper import Gripper
    from splinearm.joints import JointState
    from splinearm.teaching.fitting import FitRule
    from splinearm.teaching.recording import Recording
    from splinearm.teaching.session import Lesson, Session

    from .keyboard import Keyboard
    from .teach_table import Board

_EPILOG = """keys:
    space   starts a piece; again: stops it
    g       the gripper closes here (at once, if it is calibrated); again: it opens
    u       takes back the piece that is being recorded, or the last one
    enter   ends: the arm holds, and the job is written

Arms of which most servos measure their current, and whose file says what they
weigh, are carried by their servos. Others have no torque while a piece is
recorded: SUPPORT THE ARM. That is asked first.

exit codes:
    0  the job is written
    1  it is written, but not all of what was led: the rest lies beside it as tables
    2  nothing is written"""


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "teach",
        help="record motions led by hand and keep them as a job",
        description="Lead the arm by hand. Each piece becomes a B-spline with few control points,\n"
        "near to what was led; pauses are kept. `splinearm play` carries the job out.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("arm", help="the arm's file, or the name of an arm that is shipped")
    add_port(parser)
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "-o", "--output", type=Path, default=None, metavar="JOB", help="the job to write"
    )
    where.add_argument(
        "--append", type=Path, default=None, metavar="JOB", help="add the pieces to this job"
    )
    parser.add_argument("--name", default=None, help="what the job is called")
    _add_leading(parser)
    _add_fitting(parser)
    parser.add_argument(
        "--tables", action="store_true", help="write each recording as a table beside the job too"
    )
    parser.add_argument("--json", action="store_true", help="print what was made as JSON")
    parser.set_defaults(run=run)


def _add_leading(parser: argparse.ArgumentParser) -> None:
    """Declare how the arm is led, or what was led before."""
    parser.add_argument(
        "--rate", type=float, default=100.0, metavar="HZ", help="readings a second (default: 100)"
    )
    how = parser.add_mutually_exclusive_group()
    how.add_argument(
        "--carried",
        action="store_true",
        default=None,
        help="let the servos carry the arm (default where most measure their current)",
    )
    how.add_argument(
        "--limp",
        dest="carried",
        action="store_false",
        help="no torque while a piece is recorded (default elsewhere): support the arm",
    )
    parser.add_argument(
        "--from",
        dest="rows",
        type=Path,
        default=None,
        metavar="CSV",
        help="take a recording instead: what `run --csv` wrote, or a table of t_s and JOINT_deg",
    )
    parser.add_argument(
        "--trim", default=None, metavar="A:B", help="of that recording only from A to B, in s"
    )


def _add_fitting(parser: argparse.ArgumentParser) -> None:
    """Declare how near the motions are to what was led."""
    parser.add_argument(
        "--tolerance-mm",
        type=float,
        default=1.0,
        metavar="MM",
        help="how far the tool may be off what was led (default: 1)",
    )
    parser.add_argument(
        "--tolerance-deg",
        type=float,
        default=0.5,
        metavar="DEG",
        help="how far a joint may be off (default: 0.5)",
    )


def run(args: argparse.Namespace) -> int:
    """Record, fit, write."""
    from splinearm.backends import require_chain
    from splinearm.config import load_cell
    from splinearm.errors import ConfigError

    from .teach_making import Making
    from .words import rate_of

    if args.trim is not None and args.rows is None:
        raise ConfigError("--trim", "", "is for a recording (--from); what is led now is trimmed")
    rule, rate = _rule(args), rate_of(args.rate)
    cell = load_cell(args.arm)
    file = _file(args, cell)
    if args.rows is not None:
        made = Making(args, cell, rule, file)
        made.take([_from_rows(args, cell)])
        return made.exit_code
    require_chain(cell)
    session, trouble = _lesson(args, cell, rate)
    made = Making(args, cell, rule, file)
    if session.pieces or trouble is None:
        made.take(session.pieces)
    if trouble is not None:
        raise trouble
    return made.exit_code


def _rule(args: argparse.Namespace) -> "FitRule":
    from splinearm.errors import ConfigError
    from splinearm.teaching.fitting import FitRule
    from splinearm.teaching.recording import Nearness
    from splinearm.units import DEG, MM

    for word, value in (("mm", args.tolerance_mm), ("deg", args.tolerance_deg)):
        if not 0.001 <= value <= 1000.0:
            raise ConfigError(f"--tolerance-{word}", "", f"want 0.001 to 1000, got {value:g}")
    nearness = Nearness(tool=args.tolerance_mm * MM, joint=args.tolerance_deg * DEG)
    return FitRule(nearness=nearness)


def _file(args: argparse.Namespace, cell: "Cell") -> Path:
    """Give the file to write, after looking whether it can be."""
    from splinearm.teaching.job_file import appendable

    from .files import require_new

    if args.append is not None:
        appendable(args.append, cell)
        return Path(args.append)
    if args.output is not None:
        require_new(rows=args.output)
        return Path(args.output)
    number = 1
    while (file := Path(f"{cell.name}-taught-{number}.toml")).exists():
        number += 1
    return file


def _from_rows(args: argparse.Namespace, cell: "Cell") -> "Recording":
    from splinearm.errors import ConfigError
    from splinearm.teaching.rows import read_rows

    recording = read_rows(args.rows, cell.arm.limits)
    if args.trim is None:
        return recording
    try:
        start, end = (float(word) for word in args.trim.split(":"))
        return recording.between(start, end)
    except ValueError as error:
        raise ConfigError("--trim", "", f"want A:B in s, got {args.trim}: {error}") from error


def _lesson(
    args: argparse.Namespace, cell: "Cell", rate: float
) -> "tuple[Session, Exception | None]":
    """Have pieces led by hand; what ended that too early comes with them."""
    from splinearm.backends import open_arm
    from splinearm.errors import SplinearmError
    from splinearm.teaching.session import Session

    from .keyboard import Keyboard
    from .teach_making import say

    has_gripper = cell.chain is not None and any(s.joint is None for s in cell.chain.servos)
    session = Session(cell.arm.joint_names, rate, has_gripper=has_gripper)
    with Keyboard() as keyboard:
        where = port_of(args, cell, announce=say)
        with open_arm(cell, where, rate=rate, feedforward="full") as station:
            try:
                _lead(session, keyboard, station, cell, args)
            except SplinearmError as error:
                say(f"{error}")  # before what was led is fitted, which takes its time
                session.end()
                return session, error
    session.end()
    return session, None


def _lead(
    session: "Session",
    keyboard: "Keyboard",
    station: "Station",
    cell: "Cell",
    args: argparse.Namespace,
) -> None:
    """Lead the arm until the session ends."""
    from splinearm.control.aside import Aside
    from splinearm.control.stop import StopRequest
    from splinearm.teaching.leading import Limp, is_carried, lead

    from .teach_making import say
    from .teach_table import Board

    carried = is_carried(station, cell) if args.carried is None else bool(args.carried)
    say(f"{cell.arm.name}, {station.where}")
    if not carried and not _is_supported(keyboard):
        return
    gripper = _gripper(station)

    def is_limp() -> bool:
        return session.recording and not session.ends

    with ExitStack() as stack:
        stop = stack.enter_context(StopRequest())
        board = stack.enter_context(Board(cell, carried=carried))
        aside = stack.enter_context(Aside())  # it ends before the board does
        cycle = _Cycle(session, keyboard, stop.request, board, aside.later(board.show))
        cycle.gripper = gripper
        lead(
            station,
            cell,
            cycle,
            limp=None if carried else Limp(wished=is_limp, announce=cycle.announce),
            stop=stop,
            rate=args.rate,
        )


def _gripper(station: "Station") -> "Gripper | None":
    """Give the gripper, with torque, if it can do what is marked."""
    from splinearm.errors import BusError

    from .teach_making import say

    gripper = station.gripper
    if gripper is None:
        return None
    try:
        gripper.take()
    except BusError as error:
        say(f"g only marks what the gripper shall do, it does not move now: {error}")
        return None
    return gripper


def _is_supported(keyboard: "Keyboard") -> bool:
    """Ask a person to support the arm."""
    from .teach_making import say

    say(
        "Its servos do not carry it: while a piece is recorded the arm has NO TORQUE and falls "
        "unless you support it. Between pieces it holds. Support it, then press y (n: leave it)"
    )
    while True:
        key = keyboard.read(1.0)
        if key in ("y", "Y"):
            return True
        if key in ("n", "N", "q", "esc"):
            return False


class _Cycle:
    """What is done in each cycle: a reading, a key, now and then a picture."""

    def __init__(
        self,
        session: "Session",
        keyboard: "Keyboard",
        end: Callable[[], object],
        board: "Board",
        show: "Callable[[Lesson], object]",
    ) -> None:
        self._session, self._keyboard = session, keyboard
        self._end, self._board, self._show = end, board, show
        self.gripper: Gripper | None = None
        """Does what is marked at once; None: it is marked only."""

    def __call__(self, state: "JointState | None") -> None:
        session = self._session
        session.see(state)
        key = self._keyboard.read(0.0)
        if key is not None:
            session.press(key)
            self._grip(key)
        if session.ends:
            self._end()
        if key is not None or self._board.is_due():
            self._show(session.lesson())

    def announce(self, words: str) -> None:
        """Show at once what a person must know."""
        self._session.warn(words)
        self._show(self._session.lesson())

    def _grip(self, key: str) -> None:
        """Let the gripper do what was marked; a line that is lost is lost, the mark stays."""
        from splinearm.errors import BusError

        if key != "g" or self.gripper is None or not self._session.pieces:
            return
        with suppress(BusError):
            self.gripper.send(100.0 if self._session.pieces[-1] == "open" else 0.0)
