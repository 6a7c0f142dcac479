"""The entry point: finds the command, turns errors into one line and an exit code.

Exit codes: 0 done; 1 the motion was stopped by a fault, two arms that were compared differ, or what
was looked at has something wrong; 2 nothing moved, because of bad input or an arm that is not
ready; 130 stopped by Ctrl-C.

Nothing heavy is imported before a command is chosen: ``--help`` stays quick.
"""

import argparse
import logging
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Protocol

from splinearm.errors import (
    BusTimeoutError,
    MotionError,
    PacketError,
    PortError,
    SplinearmError,
    StartError,
)

from . import (
    arms,
    backup,
    calibrate,
    completion,
    demo,
    doctor,
    gcode,
    guide,
    jog,
    monitor,
    plan,
    play,
    recover,
    restore,
    run,
    scan,
    setup,
    teach,
    toolpath,
    virtual_bus,
)

DONE, FAULT, REFUSED, INTERRUPTED = 0, 1, 2, 130

_EPILOG = """New here? Run 'splinearm demo': it needs no hardware.
An arm on the table? docs/hardware.md leads from the box to the first motion.

exit codes: 0 done; 1 a fault stopped the motion, or what was looked at has something wrong;
2 refused, nothing moved; 130 stopped by Ctrl-C. Most commands take --json."""


class _Command(Protocol):
    """What a command's file offers."""

    def add_parser(self, commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
        """Declare the command's words."""
        ...


_COMMANDS: tuple[_Command, ...] = (
    *(demo, run, plan, toolpath, gcode, arms),
    *(
        doctor,
        scan,
        setup,
        backup,
        restore,
        calibrate,
        monitor,
        recover,
        guide,
        jog,
        teach,
        play,
        virtual_bus,
        completion,
    ),
)


def build_parser() -> argparse.ArgumentParser:
    """Give the parser of the whole command line."""
    parser = argparse.ArgumentParser(
        prog="splinearm",
        description="Plan robot-arm motions as B-splines and carry them out.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="store_true", help="print the version and leave")
    parser.add_argument("-v", "--verbose", action="store_true", help="say more on the error stream")
    commands = parser.add_subparsers(title="commands", dest="command", metavar="COMMAND")
    for command in _COMMANDS:
        command.add_parser(commands)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; give the exit code."""
    _open_closed_streams()
    parser = build_parser()
    completion.answer_shell(parser)
    args = parser.parse_args(argv)
    if args.version:
        from importlib.metadata import version

        print(f"splinearm {version('splinearm')}")
        return DONE
    if args.command is None:
        parser.print_help()
        return REFUSED
    logging.basicConfig(
        level=logging.INFO if args.verbose else logging.WARNING,
        format="%(levelname)s %(name)s: %(message)s",
    )
    if sys.stderr.isatty():
        # the first plan on a machine is silent for ten seconds otherwise
        logging.getLogger("splinearm.compiled").setLevel(logging.INFO)
    try:
        code = int(args.run(args))
        sys.stdout.flush()  # what cannot be written any more shall be said here
    except SplinearmError as error:
        _complain(_in_words(error, args))
        return FAULT if isinstance(error, MotionError) and not _unmoved(error) else REFUSED
    except KeyboardInterrupt:
        _complain("stopped")
        return INTERRUPTED
    except OSError as error:
        if not isinstance(error, BrokenPipeError):  # who read it has gone, as `head` does
            _complain(f"cannot go on: {error}")
        with suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAULT
    return code


def _open_closed_streams() -> None:
    """Give a program that was started with closed streams some that lead nowhere."""
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115


def _complain(words: str) -> None:
    """Say it on the error stream, if that is still there: a terminal may have been closed."""
    with suppress(OSError):
        print(f"splinearm: {words}", file=sys.stderr, flush=True)


def _in_words(error: SplinearmError, args: argparse.Namespace) -> str:
    """Give an error in one line; of a line that is silent or garbled with its cause."""
    if not isinstance(error, BusTimeoutError | PacketError | PortError):
        return str(error)
    from splinearm.doctor.first_aid import explained

    port = getattr(args, "port", None) or getattr(args, "on", None)
    return explained(
        error, port=port, arm=getattr(args, "arm", None), job=getattr(args, "job", None)
    )


def _unmoved(error: MotionError) -> bool:
    return isinstance(error, StartError)
