"""The programs that LinuxCNC brings, read by its own interpreter and by ours, move by move."""

import re
from math import pi
from pathlib import Path

import numpy as np
import pytest

from splinearm.errors import GcodeError
from splinearm.toolpaths.action import ArcFeed, Feed, Rapid, SplineFeed
from splinearm.toolpaths.gcode_compensation import compensate
from splinearm.toolpaths.gcode_interpreter import run_gcode, run_gcode_text
from splinearm.toolpaths.gcode_machine import NcMachine, NcTool

SHARE, DOC = Path("/usr/share/linuxcnc/ncfiles"), Path("/usr/share/doc/linuxcnc")
pytestmark = [
    pytest.mark.kernel,
    pytest.mark.skipif(not SHARE.is_dir(), reason=f"LinuxCNC's samples are not in {SHARE}"),
]

MM = 1e-3
CALL = re.compile(r"^\s*\d+\s+N\S*\s+(\w+)\((.*)\)\s*$")
TOOLS = {number: number * MM for number in range(1, 100)}
TABLE = "".join(f"T{n} P{n} D{d / 25.4e-3:.6f} Z0\n" for n, d in TOOLS.items())
NOT_OURS = re.compile(
    r"threading|tapping|probing|spindle that is followed|G7[01]|g7[0-2]|diameters of a lathe|"
    r"other than X, Y and Z|\^|waiting for an input|there is no subroutine|constant surface|"
    r"there is no code M1|coordinate systems that are turned|tool \d+ is not|was never set",
    re.IGNORECASE,
)
"""What we refuse for a reason: lathes, probes, rotary axes, polar words, codes of one machine."""


def theirs(file, read):
    """Give the ways of LinuxCNC in mm, and whether it read the program to its end."""
    done = read(file, TABLE, ends=False)
    found, unit = [], 1.0
    shift = {"SET_G5X_OFFSET": 0.0, "SET_G92_OFFSET": 0.0, "USE_TOOL_LENGTH_OFFSET": 0.0}
    ended = False
    for match in filter(None, map(CALL.match, done.stdout.splitlines())):
        name, words = match.groups()
        values = words.replace(",", " ").split()
        if name == "USE_LENGTH_UNITS":
            unit = 1.0 if "MM" in words else 25.4
        elif name in shift:
            first = 1 if name == "SET_G5X_OFFSET" else 0
            shift[name] = unit * np.array(values[first : first + 3], dtype=float)
        elif name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED"):
            end = unit * np.array(values[:3], dtype=float) + sum(shift.values())
            found.append(("rapid" if "TRAVERSE" in name else "feed", end))
        elif name == "ARC_FEED":
            found.append(("arc", (np.array(values[:6], dtype=float), unit, sum(shift.values()))))
        elif name.startswith("NURBS"):
            found.append(("spline", None))
        ended |= name == "PROGRAM_END"
    return found, ended


def ours(actions):
    kinds = {Rapid: "rapid", Feed: "feed", ArcFeed: "arc", SplineFeed: "spline"}
    return [
        (kinds[type(a)], a if isinstance(a, ArcFeed | SplineFeed) else a.end / MM)
        for a in actions
        if type(a) in kinds
    ]


def moved(ways):
    """Drop straight ways that go nowhere, which the two count in their own ways."""
    place, kept = np.zeros(3), []
    for kind, way in ways:
        if kind in ("rapid", "feed"):
            if np.abs(way - place).max() < 2e-3:
                continue
            place = way
        kept.append((kind, way))
    return kept


def same(a, b):
    """Say whether two ways are one; files in inches are told to four decimals only."""
    if a[0] != b[0]:
        return False
    if a[0] == "spline":
        return True
    if a[0] != "arc":
        return np.abs(a[1] - b[1]).max() < 3e-3
    (values, unit, shift), arc = a[1], b[1]
    i, j = (arc.axis + 1) % 3, (arc.axis + 2) % 3
    shift = np.broadcast_to(shift, 3)
    end = [values[0] * unit + shift[i], values[1] * unit + shift[j],
           values[5] * unit + shift[arc.axis]]  # fmt: skip
    middle = [values[2] * unit + shift[i], values[3] * unit + shift[j]]
    turns = abs(arc.turn) / (2.0 * pi)
    return (
        np.abs(np.array(end) - arc.end[[i, j, arc.axis]] / MM).max() < 3e-3
        and np.abs(np.array(middle) - arc.centre[[i, j]] / MM).max() < 5e-3
        and np.sign(values[4]) == np.sign(arc.turn)
        and abs(values[4]) - 1 <= turns + 1e-6 <= abs(values[4]) + 2e-6
    )


def compared(file, rs274):
    """Give what came of a program: same, neither, ours alone, refused, compensated, or a fault."""
    machine = NcMachine(tools={n: NcTool(diameter=d) for n, d in TOOLS.items()})
    wanted, ended = theirs(file, rs274)
    try:
        actions = run_gcode(file, machine)
    except GcodeError as error:
        if not ended:
            return "neither"
        return "refused" if NOT_OURS.search(str(error)) else f"refused: {error}"
    if not ended:
        return "ours alone"
    if any(getattr(action, "side", 0) for action in actions):
        return "compensated"
    a, b = moved(wanted), moved(ours(actions))
    wrong = next((k for k, pair in enumerate(zip(a, b, strict=False)) if not same(*pair)), None)
    if wrong is not None:
        return f"differs in way {wrong}: {a[wrong]} and {b[wrong]}"
    return "same" if len(a) == len(b) else f"has {len(b)} ways, {len(a)} wanted"


def counted(files, rs274):
    found = {str(file): compared(file, rs274) for file in files}
    fine = {"same", "neither", "ours alone", "refused", "compensated"}
    assert not {file: what for file, what in found.items() if what not in fine}
    return [sum(what == kind for what in found.values()) for kind in ("same", "refused")]


def test_small_samples_agree_move_by_move(rs274):
    files = [file for file in sorted(SHARE.glob("*.ngc")) if file.stat().st_size < 6000]
    same_ones, _ = counted(files, rs274)
    assert same_ones >= 0.4 * len(files)


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_every_sample_agrees_or_is_refused_with_a_reason(rs274):
    files = [*sorted(SHARE.rglob("*.ngc")), *sorted(DOC.rglob("*.ngc"))]
    same_ones, refused = counted(dict.fromkeys(file.resolve() for file in files), rs274)
    assert same_ones > 4 * refused


def test_a_compensated_contour_without_trimmed_parts_is_theirs(tmp_path, rs274):
    text = (
        "G21 G90 F500\nG0 X-30 Y-30\nG1 Z-1\nG41.1 D6 G1 X0 Y-12\nY30\nG2 X10 Y40 I10 J0\n"
        "G1 X50\nY12\nG2 X42 Y4 I-8 J0\nG1 X-12\nG40 G1 X-30\nM2\n"
    )
    file = tmp_path / "part.ngc"
    file.write_text(text)
    wanted, ended = theirs(file, rs274)
    assert ended
    found = ours(compensate(run_gcode_text(text)).actions)
    ends = np.array([w.end / MM if k == "arc" else w for k, w in found])

    def place(kind, way):
        return np.array([*way[0][:2], way[0][5]]) if kind == "arc" else way

    # between the way in and the way out each of theirs ends where one of ours does
    middle = [place(*way) for way in moved(wanted)[3:-2]]
    off = [np.abs(ends - end).max(axis=1).min() for end in middle]
    assert len(middle) >= 6
    assert max(off) < 2e-3
