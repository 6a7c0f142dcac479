"""What is wrong with this computer: Python, libraries, priority, pictures."""

from collections.abc import Iterator

from .catalogue import found
from .computer import Computer
from .finding import Finding

_HERE = "this computer"
_PYTHON = (3, 11)
_MUJOCO = 4

LIBRARIES = {
    "numpy": "numpy",
    "numba": "numba",
    "mujoco": "mujoco",
    "dynamixel_sdk": "dynamixel-sdk",
    "serial": "pyserial",
    "rich": "rich",
    "argcomplete": "argcomplete",
    "matplotlib": "matplotlib",
}
"""By module what installs it: without any of these something does not work."""

EXTRAS = {
    "fast": (("fastcrc",), "without it a loop takes more of the processor"),
    "log": (("mcap",), "`run --mcap` needs it"),
    "cad": (("ezdxf", "svgelements"), "drawings (DXF, SVG) need it"),
}
"""By extra its modules, and who needs it."""


def check_software(computer: Computer) -> Iterator[Finding]:
    """Look at what nothing works without."""
    if computer.python < _PYTHON:
        have, want = (".".join(map(str, version)) for version in (computer.python, _PYTHON))
        yield found(
            "C01",
            _HERE,
            f"this is Python {have}; splinearm needs {want} or newer",
            f"install Python {want} or newer and run `python{want} -m pip install splinearm`",
        )
    for module, distribution in LIBRARIES.items():
        if computer.module(module) is None:
            yield found(
                "C02",
                _HERE,
                f"the library {distribution} is not there",
                f"run `pip install --force-reinstall {distribution}`",
            )
    yield from _check_mujoco(computer)


def _check_mujoco(computer: Computer) -> Iterator[Finding]:
    """Tell a MuJoCo of before version 4, and what pip leaves of it when it is updated in place."""
    place, version = computer.module("mujoco"), computer.version("mujoco")
    if place is None:
        return
    remedy = "run `pip uninstall -y mujoco mujoco-core && pip install mujoco`"
    if version is not None and int(version.partition(".")[0]) < _MUJOCO:
        yield found("C03", _HERE, f"MuJoCo is {version}; {_MUJOCO}.0 or newer is needed", remedy)
    elif place == "":
        yield found(
            "C03",
            _HERE,
            "the folder of MuJoCo has no code: an update from 3.x in place has deleted it",
            remedy,
        )


def check_comfort(computer: Computer) -> Iterator[Finding]:
    """Look at what more would be possible."""
    permitted = computer.footing()
    if not (permitted.fifo and permitted.locked):
        what, _, remedy = permitted.words.partition("; to permit it, ")
        yield found("C06", _HERE, what, remedy or "use Linux for a loop that is always on time")
    if not _can_draw(computer):
        yield found(
            "C05",
            _HERE,
            "there is no display, and neither EGL nor OSMesa is installed: MuJoCo cannot draw "
            "(plans, runs and their pictures do not need it)",
            "run `sudo apt install libegl1 libgl1` and `export MUJOCO_GL=egl`",
        )
    for extra, (modules, who) in EXTRAS.items():
        missing = [module for module in modules if computer.module(module) is None]
        if missing:
            yield found(
                "C04",
                _HERE,
                f"the extra {extra!r} is not installed ({', '.join(missing)}): {who}",
                f"run `pip install 'splinearm[{extra}]'`",
            )


def _can_draw(computer: Computer) -> bool:
    shown = any(computer.environment.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
    return shown or computer.has_library("EGL") or computer.has_library("OSMesa")
