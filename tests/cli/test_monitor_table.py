"""The table of ``splinearm monitor``: colours by level, remedies in rows, any width."""

import io
import math

import pytest
from rich.console import Console

from splinearm.cli import monitor_table
from splinearm.cli.monitor_table import Show, picture
from splinearm.joints import JointKind
from splinearm.monitoring.beat import Rhythm
from splinearm.monitoring.sample import Level, Sample, ServoSample, Verdict

NAMES = ("waist", "shoulder_shadow", "elbow")
RED, YELLOW = "\x1b[1;31m", "\x1b[33m"


def sample(*verdicts, **changes):
    servos = [
        ServoSample(
            servo_id=k,
            name=name,
            joint=name,
            model="XM430-W350",
            answers=True,
            position=math.radians(-179.991),
            velocity=1.0,
            current=-0.25,
            temperature=66.0,
            voltage=11.9,
            torque=True,
            moving=True,
            verdict=verdict,
        )
        for k, (name, verdict) in enumerate(zip(NAMES, verdicts, strict=False), 1)
    ]
    whole = {
        "t": 0.0,
        "number": 1,
        "port": "/dev/ttyUSB0",
        "baud": 1_000_000,
        "arm": "mine",
        "trouble": "",
        "rhythm": Rhythm(wanted=50.0, rate=49.9, jitter_p50=1e-5, jitter_p99=2e-4, jitter_max=3e-3),
        "servos": tuple(servos),
    }
    return Sample(**(whole | changes))


HOT = Verdict(
    level=Level.WARN,
    code="S13",
    what="hot",
    remedy="switch its torque off and let it cool down; then lighten its load",
    fields={"temperature": Level.WARN},
)
ILL = Verdict(
    level=Level.STOP,
    code="S10",
    what="overload error",
    remedy="free the joint and lighten its load; then run `splinearm recover mine --port P`",
)


def drawn(what, width, **options):
    file = io.StringIO()
    console = Console(
        file=file, width=width, force_terminal=True, color_system="standard", **options
    )
    console.print(picture(what, width))
    return file.getvalue()


def plain(what, width):
    file = io.StringIO()
    Console(file=file, width=width).print(picture(what, width))
    return file.getvalue()


@pytest.mark.parametrize("width", [80, 100, 140, 200])
def test_a_remedy_stands_in_its_row_and_no_word_of_it_is_lost(width):
    text = plain(sample(Verdict(), HOT, ILL), width)
    assert max(len(line) for line in text.splitlines()) <= width
    for verdict in (HOT, ILL):
        for word in f"{verdict.code} {verdict.what}: {verdict.remedy}".split():
            assert word[:12] in text
    assert "-179.991" in text
    assert "-0.250 A" in text
    assert "50.0 Hz, jitter p50 0.01, p99 0.2, max 3.0 ms" in text
    assert "/dev/ttyUSB0, 1000000 baud" in text
    assert ("lost/crc/again" in text) is (width >= 110)


def test_levels_have_their_colours_and_none_where_there_is_none_to_be():
    text = drawn(sample(Verdict(), HOT, ILL), 160)
    rows = {name: next(ln for ln in text.splitlines() if name in ln) for name in NAMES}
    assert YELLOW not in rows["waist"]
    assert RED not in rows["waist"]
    assert f"{YELLOW}  66" in rows["shoulder_shadow"] or f"{YELLOW}66" in rows["shoulder_shadow"]
    assert RED in rows["elbow"]
    text = drawn(sample(Verdict(), HOT, ILL), 160, no_color=True)
    assert "\x1b[33" not in text
    assert "31m" not in text


def test_a_port_that_is_gone_and_a_line_that_is_dead_are_said_in_the_header():
    gone = sample(servos=(), trouble="there is no such port")
    assert "the port cannot be used: there is no such port; waiting" in plain(gone, 80)
    lost = Verdict(level=Level.STOP, code="L04", what="a servo is missing", remedy="its cable")
    silent = tuple(
        ServoSample(servo_id=k, name=f"servo_{k}", joint=None, model="", verdict=lost)
        for k in (1, 2)
    )
    text = plain(sample(servos=silent, arm=None), 80)
    assert "L01 no servo answers" in text
    assert "2 servos on" in text
    assert text.count("no answer") == 2


def test_a_line_that_is_too_slow_is_said_in_the_header():
    slow = sample(Verdict(), rhythm=Rhythm(wanted=50.0, rate=31.0))
    assert "C07 slower than was asked for: `splinearm doctor /dev/ttyUSB0`" in plain(slow, 100)
    assert "C07" not in plain(sample(Verdict()), 100)


def test_a_sliding_joint_is_in_millimetres():
    rail = ServoSample(
        servo_id=1,
        name="rail",
        joint="rail",
        model="XM430-W350",
        kind=JointKind.PRISMATIC,
        answers=True,
        position=0.0125,
        load=0.5,
    )
    text = plain(sample(servos=(rail,)), 100)
    assert "12.500 mm" in text
    assert "50.0 %" in text


def test_where_there_is_no_room_the_worst_comes_first(monkeypatch):
    file = io.StringIO()
    monkeypatch.setattr(
        monitor_table, "console", Console(file=file, width=80, height=9, force_terminal=True)
    )
    with Show() as show:
        show(sample(Verdict(), Verdict(), ILL))
        text = file.getvalue()
    assert "elbow" in text
    assert "S10" in text
    assert "waist" not in text


@pytest.mark.parametrize("is_terminal", [True, False])
def test_samples_are_shown_in_place_or_one_after_the_other(is_terminal, monkeypatch):
    file = io.StringIO()
    console = Console(file=file, width=100, height=30, force_terminal=is_terminal)
    monkeypatch.setattr(monitor_table, "console", console)
    with Show() as show:
        show(sample(Verdict()))
        show(sample(HOT))
    text = file.getvalue()
    assert text.count("S13 hot") == (2 if is_terminal else 1)  # what was last stays
    assert ("\x1b[?1049h" in text) is is_terminal
