"""Completion: what it offers, and that real shells take it."""

import argparse
import io
import os
import shutil
import sys
from pathlib import Path

import argcomplete
import pytest

from splinearm.cli import completion
from splinearm.cli.main import build_parser
from splinearm.config import load_cell, shipped_arms

SHELLS = {
    "bash": ["bash", "--noprofile", "--norc", "-i"],
    "zsh": ["zsh", "-f", "-i"],
    "fish": ["fish", "--no-config", "-i"],
}
SETUPS = {
    "bash": 'eval "$(splinearm completion bash)"; PS1="ready> "\n',
    "zsh": 'autoload -U compinit; compinit -u -d "$HOME/dump"; '
    'eval "$(splinearm completion zsh)"; PS1="ready> "\n',
    "fish": "splinearm completion fish | source; function fish_prompt; echo 'ready> '; end\n",
}


class _EndedError(Exception):
    """What stands for the end of the process that a shell asked."""


@pytest.fixture
def offered(monkeypatch, tmp_path):
    """What is offered where a line ends."""
    monkeypatch.chdir(tmp_path)

    def ask(line):
        def end(code):
            raise _EndedError(code)

        for name, value in {
            "_ARGCOMPLETE": "1",
            "_ARGCOMPLETE_SHELL": "bash",
            "COMP_LINE": line,
            "COMP_POINT": str(len(line)),
        }.items():
            monkeypatch.setenv(name, value)
        said = io.StringIO()
        # what it has to say to those who debug it goes to a file descriptor that is others' here
        monkeypatch.setattr(argcomplete.autocomplete, "_init_debug_stream", lambda: None)
        monkeypatch.setattr(argcomplete.io, "debug_stream", io.StringIO())
        with pytest.raises(_EndedError):
            completion.answer_shell(build_parser(), leave=end, output=said)
        return [word.strip() for word in said.getvalue().split("\013") if word]

    return ask


def test_commands_options_and_choices_are_offered(offered):
    commands = offered("splinearm ")
    assert {"run", "monitor", "doctor", "completion"} <= set(commands)
    assert offered("splinearm moni") == ["monitor"]
    assert {"--port", "--json", "--udp", "--once"} <= set(offered("splinearm monitor --"))
    assert offered("splinearm monitor --on ") == ["virtual"]
    assert offered("splinearm completion ") == ["bash", "zsh", "fish"]
    assert offered("splinearm arms sh") == ["show"]
    assert offered("splinearm monitor --rate ") == []


def test_arms_are_offered_those_that_are_shipped_and_files_that_are_some(offered, tmp_path):
    (tmp_path / "mine.toml").write_text('schema = "splinearm-arm/1"', encoding="utf-8")
    (tmp_path / "other.toml").write_text('schema = "something/1"', encoding="utf-8")
    (tmp_path / "robot.urdf").touch()
    (tmp_path / "notes.txt").touch()
    (tmp_path / "sub").mkdir()
    assert offered("splinearm arms show ") == [*shipped_arms(), "mine.toml", "robot.urdf", "sub/"]
    assert offered("splinearm monitor wx") == ["wx200", "wx250s"]
    assert offered("splinearm doctor --arm mi") == ["mine.toml"]


def test_files_are_offered_by_their_kind(offered, tmp_path):
    folder = tmp_path / "parts"
    folder.mkdir()
    for name in ("a.ngc", "b.NC", "c.dxf", "d.svg", "e.json", "f.png", ".hidden.ngc", "g.txt"):
        (folder / name).touch()
    (folder / "job.toml").write_text('schema = "splinearm-job/1"', encoding="utf-8")
    assert offered("splinearm run parts/") == [
        f"parts/{name}" for name in ("a.ngc", "b.NC", "e.json", "job.toml")
    ]
    assert offered("splinearm plan parts/") == ["parts/job.toml"]
    assert offered("splinearm toolpath parts/") == ["parts/c.dxf", "parts/d.svg"]
    assert offered("splinearm plan parts/job.toml --plot parts/") == ["parts/d.svg", "parts/f.png"]
    assert offered("splinearm run nowhere/") == []
    assert offered("splinearm run ~nobody-of-this-name/") == []


def test_poses_and_joints_are_those_of_the_arm_that_is_named(offered, tmp_path):
    assert offered("splinearm virtual-bus wx250s --pose ") == list(load_cell("wx250s").poses)
    assert offered("splinearm virtual-bus --pose ") == []
    joints = list(load_cell("wx250s").arm.joint_names)
    assert offered("splinearm calibrate wx250s --joint ") == joints
    (tmp_path / "broken.toml").write_text("schema = splinearm-arm/1", encoding="utf-8")
    assert offered("splinearm virtual-bus broken.toml --pose ") == []


def test_ports_are_those_that_are_there(offered, tmp_path, monkeypatch):
    by_id = tmp_path / "serial" / "by-id"
    by_id.mkdir(parents=True)
    for file in (by_id / "usb-U2D2", tmp_path / "ttyUSB0", tmp_path / "tty0"):
        file.touch()
    monkeypatch.setattr(completion, "_DEVICES", tmp_path)
    there = [str(by_id / "usb-U2D2"), str(tmp_path / "ttyUSB0")]
    assert offered("splinearm monitor --port ") == there
    assert offered("splinearm run job.toml --on ") == ["mujoco", "virtual", *there]


def test_nobody_is_answered_who_did_not_ask(monkeypatch):
    monkeypatch.delenv("_ARGCOMPLETE", raising=False)
    completion.answer_shell(build_parser())


def arguments(parser):
    """Every argument of every command that takes something."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from arguments(command)
        elif action.nargs != 0 and not action.choices:
            yield parser.prog, action


def test_every_arm_port_and_file_of_every_command_is_completed():
    parser = build_parser()
    completion.furnish(parser)
    for command, action in arguments(parser):
        if action.dest in ("arm", "port", "job", "pose") or action.type is Path:
            assert hasattr(action, "completer"), f"{command} {action.dest}"


@pytest.mark.parametrize("shell", SHELLS)
def test_there_is_a_script_for_each_shell(shell, cli):
    assert cli("completion", shell) == 0
    assert "splinearm" in cli.out
    assert "_ARGCOMPLETE" in cli.out


def test_shells_take_it(terminal, tmp_path):
    program = tmp_path / "splinearm"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m splinearm "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    env = {"PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}", "HOME": str(tmp_path)}
    there = [shell for shell in SHELLS if shutil.which(shell) is not None]
    opened = [terminal(command=SHELLS[shell], rows=30, columns=100, env=env) for shell in there]
    for shell, seen in zip(there, opened, strict=True):
        seen.type(SETUPS[shell])
    for seen in opened:
        seen.wait_for(r"^ready> $|^ready>$")
    for typed, shown in (
        ("splinearm moni\t", "ready> *splinearm monitor"),
        ("pla\t", "splinearm monitor planar_2r"),
        ("--js\t", "splinearm monitor planar_2r --json"),
    ):
        for seen in opened:
            seen.type(typed)
        for seen in opened:
            seen.wait_for(shown)
    missing = set(SHELLS) - set(there)
    if missing:
        pytest.skip(f"not installed here, so not tried: {', '.join(sorted(missing))}")


def test_an_answer_needs_nothing_heavy(python):
    loaded = python(
        "import io, os, sys\n"
        "line = 'splinearm monitor '\n"
        "os.environ |= {'_ARGCOMPLETE': '1', 'COMP_POINT': '18', 'COMP_LINE': line}\n"
        "from splinearm.cli import completion\n"
        "from splinearm.cli.main import build_parser\n"
        "said = io.StringIO()\n"
        "try:\n"
        "    completion.answer_shell(build_parser(), leave=sys.exit, output=said)\n"
        "except SystemExit:\n"
        "    pass\n"
        "assert 'wx250s' in said.getvalue()\n"
        "print([name for name in ('numpy', 'rich', 'numba', 'serial') if name in sys.modules])"
    )
    assert loaded.strip() == "[]"
