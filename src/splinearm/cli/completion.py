"""``splinearm completion SHELL``: what lets a shell complete the words of this command line.

A shell that completes starts this program with ``_ARGCOMPLETE`` in its environment and takes what
it prints: so it is asked what is there at that moment, and must answer in a blink. Nothing heavy is
imported for it; arm files are only looked into for the names of their poses.
"""

import argparse
import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, TextIO

SHELLS = ("bash", "zsh", "fish")
"""The shells for which there is a script."""

_ARMS = Path(__file__).parents[1] / "config" / "arms"
_DEVICES = Path("/dev")
_PORTS = ("serial/by-id/*", "ttyUSB*", "ttyACM*", "ttyDXL*")
_PROGRAMS = (".ngc", ".nc", ".gcode", ".tap", ".cnc")
_LOOK = 20_000
"""Characters within which a TOML file says what it is."""
_PICTURES = (".png", ".svg", ".pdf")
_MODELS = (".toml", ".urdf", ".xml", ".mjcf")

_ENDINGS: dict[str, tuple[str, ...]] = {
    "splinearm toolpath file": (".dxf", ".svg", ".toml"),
    "splinearm toolpath output": _PROGRAMS,
    "splinearm plan job": (".toml",),
    "splinearm restore file": (".toml",),
    "splinearm teach output": (".toml",),
    "splinearm teach append": (".toml",),
    "splinearm jog waypoints": (".toml",),
    "rows": (".csv",),
    "job": (".toml", ".json", ".csv", *_PROGRAMS),
    "file": _PROGRAMS,
    "part": (".dxf", ".svg"),
    "tools": (".toml",),
    "plot": _PICTURES,
    "preview": _PICTURES,
    "save": (".json", ".csv"),
    "csv": (".csv",),
    "mcap": (".mcap",),
    "json": (".json",),
}
"""Which files an argument takes, by its name, or by that of its command and its own."""

_SCHEMAS = {
    "job": "splinearm-job/",
    "tools": "splinearm-tools/",
    "splinearm restore file": "splinearm-backup/",
    "splinearm teach append": "splinearm-job/",
    "splinearm toolpath file": "splinearm-toolpath/",
}
"""What TOML files say that they are, which an argument takes, by the same names."""

_HELP = """in bash, in ~/.bashrc:
    eval "$(splinearm completion bash)"
in zsh, in ~/.zshrc, after compinit:
    eval "$(splinearm completion zsh)"
in fish, once:
    splinearm completion fish > ~/.config/fish/completions/splinearm.fish"""

Completer = Callable[..., Iterable[str]]
"""What argcomplete asks for words: with ``prefix``, ``parsed_args`` and more, all by name."""


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Declare the command's words."""
    parser = commands.add_parser(
        "completion",
        help="let bash, zsh or fish complete these words",
        description="Print what lets a shell complete commands, options, arms, ports, poses and "
        "files by their kind.",
        epilog=_HELP,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("shell", choices=SHELLS, help="the shell")
    parser.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Print the script."""
    from argcomplete.shell_integration import shellcode

    script = shellcode(["splinearm"], use_defaults=False, shell=args.shell)
    print(script)
    return 0


def answer_shell(
    parser: argparse.ArgumentParser,
    *,
    leave: Callable[[int], object] = os._exit,
    output: TextIO | None = None,
) -> None:
    """Answer a shell that asks how a line may go on, and end; do nothing if none asks.

    Args:
        parser: The parser of the whole command line.
        leave: Ends this process.
        output: Where the answer goes; None: to where the shell listens.
    """
    if "_ARGCOMPLETE" not in os.environ:
        return
    import argcomplete
    from argcomplete.completers import SuppressCompleter

    furnish(parser)
    nothing = SuppressCompleter()
    argcomplete.autocomplete(
        parser,
        always_complete_options=False,
        default_completer=nothing,
        exit_method=leave,
        output_stream=output,
    )


def furnish(parser: argparse.ArgumentParser) -> None:
    """Tell the arguments of all commands what they can be."""
    for action in parser._actions:  # noqa: SLF001 - argparse has no other way to walk them
        if isinstance(action, argparse._SubParsersAction):  # noqa: SLF001
            for command in {id(each): each for each in action.choices.values()}.values():
                furnish(command)
        elif not action.choices and action.nargs != 0:
            completer = _completer(parser.prog, action)
            if completer is not None:
                action.completer = completer  # type: ignore[attr-defined] # as argcomplete wants


def _completer(command: str, action: argparse.Action) -> Completer | None:
    """Give what completes an argument; None: nothing can."""
    name = action.dest
    known: dict[str, Completer] = {
        "arm": arms,
        "other": arms,
        "port": ports,
        "pose": poses,
        "joint": joints,
        "on": places,
    }
    if name in known:
        return known[name]
    if action.type is Path or name in ("job", "file"):
        endings = _ENDINGS.get(f"{command} {name}", _ENDINGS.get(name, ()))
        says = _SCHEMAS.get(f"{command} {name}", _SCHEMAS.get(name, ""))
        return lambda prefix="", **_: files(prefix, endings, says=says)
    return None


def arms(prefix: str = "", **_: object) -> Iterator[str]:
    """Give the shipped arms, and files that may be arms."""
    yield from shipped()
    yield from files(prefix, _MODELS, says="splinearm-arm/")


def shipped() -> list[str]:
    """Give the names of the shipped arms."""
    return sorted(file.stem for file in _ARMS.glob("*.toml"))


def ports(**_: object) -> list[str]:
    """Give the ports that are there, those by their lasting names first."""
    return [str(path) for pattern in _PORTS for path in sorted(_DEVICES.glob(pattern))]


def places(**_: object) -> list[str]:
    """Give what may move: a simulation, virtual servos, or what is on a port that is there."""
    return ["mujoco", "virtual", *ports()]


def poses(parsed_args: argparse.Namespace | None = None, **_: object) -> list[str]:
    """Give the poses of the arm that the line names."""
    table = _arm_file(parsed_args).get("poses")
    names = table if isinstance(table, dict) else ()
    return [name.removesuffix("_mm").removesuffix("_deg") for name in names]


def joints(parsed_args: argparse.Namespace | None = None, **_: object) -> list[str]:
    """Give the joints of the arm that the line names."""
    tables = _arm_file(parsed_args).get("joint")
    rows = tables if isinstance(tables, list) else ()
    return [str(row["name"]) for row in rows if isinstance(row, dict) and "name" in row]


def _arm_file(parsed_args: argparse.Namespace | None) -> dict[str, Any]:
    """Give what the file of the arm that the line names says; nothing if that cannot be told."""
    import tomllib

    arm = getattr(parsed_args, "arm", None)
    if not arm:
        return {}
    file = _ARMS / f"{arm}.toml" if arm in shipped() else Path(arm)
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}


def files(prefix: str, endings: tuple[str, ...], *, says: str = "") -> list[str]:
    """Give folders, and the files of some endings, that go on as a word begins.

    Args:
        prefix: How the word begins.
        endings: The endings, in small letters; none: every file.
        says: What a TOML file must say, near its beginning.
    """
    head, slash, stem = prefix.rpartition("/")
    try:
        there = sorted(Path(f"{head}{slash}" or ".").expanduser().iterdir())
    except (OSError, RuntimeError):  # no folder, or the home of nobody
        return []
    names = []
    for path in there:
        if not path.name.startswith(stem) or (path.name.startswith(".") and not stem):
            continue
        if path.is_dir():
            names.append(f"{head}{slash}{path.name}/")
        elif _fits(path, endings, says):
            names.append(f"{head}{slash}{path.name}")
    return names


def _fits(path: Path, endings: tuple[str, ...], says: str) -> bool:
    """Tell whether a file is of a kind."""
    ending = path.suffix.lower()
    if endings and ending not in endings:
        return False
    if not says or ending != ".toml":
        return True
    try:
        with path.open(encoding="utf-8", errors="replace") as stream:
            return says in stream.read(_LOOK)
    except OSError:
        return False
