"""``splinearm calibrate``: a person at a terminal and at an arm of virtual servos."""

import json
import time
from datetime import UTC, datetime

import numpy as np
import pytest

from splinearm.backends import centred, open_arm
from splinearm.cli.main import main
from splinearm.commissioning.backup import read_backup
from splinearm.config import load_cell
from splinearm.config.calibration import calibrated, find_calibration, save_calibration
from splinearm.config.calibration_table import Calibration, ServoCalibration
from splinearm.drivers.chain import ServoRole
from splinearm.drivers.registers import Area
from splinearm.errors import ConfigError
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.units import DEG


@pytest.fixture
def home(tmp_path, monkeypatch):
    """A user's folder of one's own."""
    monkeypatch.setenv("SPLINEARM_HOME", str(tmp_path / "home"))
    return tmp_path / "home"


class Hand:
    """A hand at an arm whose servos nobody has given torque: it turns shafts."""

    def __init__(self, cell, bus):
        self.cell, self.bus = cell, bus

    def where(self, joint):
        """Where a joint is, rad."""
        pairs = zip(self.cell.chain.servos, self.bus.all_servos, strict=True)
        return next(servo.shaft.angle for spec, servo in pairs if spec.joint == joint)

    def turn(self, name, angle, seen=None):
        """Turn a joint (or the gripper: None) there, rad; wait until the screen says so."""
        self.turn_all({name: angle}, seen)

    def turn_all(self, angles, seen=None):
        """Turn joints together, as a person with many hands."""
        pairs = zip(self.cell.chain.servos, self.bus.all_servos, strict=True)
        own = [(spec, servo, servo.shaft.angle) for spec, servo in pairs if spec.joint in angles]
        far = max(abs(angles[spec.joint] - here) for spec, _, here in own)
        for part in np.linspace(0.0, 1.0, max(2, int(far / 0.8) + 1))[1:]:
            with self.bus.lock:
                for spec, servo, here in own:
                    servo.shaft.angle = float(here + part * (angles[spec.joint] - here))
            time.sleep(0.03)
        for spec, servo, _ in own:
            if seen is not None and spec.role is not ServoRole.SHADOW:
                seen.wait_for(rf"^{spec.name} +{servo.position} ")


@pytest.fixture
def arm(request):
    """An arm on a virtual bus, its horns screwed on anyhow, and a hand."""
    cell = load_cell("wx250s")
    rng = np.random.default_rng(7)
    start = cell.poses["zero"]
    with VirtualBus(cell.arm, centred(cell.chain), start, transport="socket") as bus:
        with bus.lock:
            for spec, servo in zip(cell.chain.servos, bus.all_servos, strict=True):
                servo.shaft.stuck = True  # there is something under the arm
                if spec.role is ServoRole.LEADER:
                    servo.slip(float(rng.uniform(0.0, 6.28)) if spec.joint in FREE else 0.05)
                    turned = servo.memory["Drive Mode"] ^ 1
                    servo.apply([(servo.model.table["Drive Mode"], turned)])
        yield cell, bus, Hand(cell, bus)


FREE = ("waist", "forearm_roll", "wrist_angle", "wrist_rotate")
"""Joints without a shadow: however their horn is mounted they can be used."""


def sweep(hand, cell, seen):
    """Turn every joint from end to end, and the gripper; leave them in the pose "zero"."""
    limits, names = cell.arm.limits, cell.arm.joint_names
    for angles in (limits.q_min + 1.0 * DEG, limits.q_max - 1.0 * DEG, cell.poses["zero"]):
        hand.turn_all(dict(zip(names, angles, strict=True)), seen)
    hand.turn(None, 0.7, seen)


def calibrate(seen, hand, cell):
    """Do what the screen says, up to the last question."""
    seen.wait_for("Turn each joint")
    sweep(hand, cell, seen)
    seen.press("enter")
    for joint in cell.arm.joint_names:
        seen.wait_for(f"Joint {joint}: turn it")
        hand.turn(joint, 20.0 * DEG)
        seen.wait_for("the numbers go")
        seen.press("enter")
        hand.turn(joint, 0.0)
    seen.wait_for("The pose 'zero'")
    seen.press("enter")
    seen.wait_for("Open the gripper")
    seen.press("enter")
    seen.wait_for("Close the gripper")
    hand.turn(None, 0.0)
    seen.press("enter")
    seen.wait_for("y: write that")


def eeprom(bus):
    """What the servos would not forget."""
    return [
        {register.name: servo.memory[register.name] for register in servo.memory.of(Area.EEPROM)}
        for servo in bus.all_servos
    ]


@pytest.mark.slow  # of an arm without shadows the page for new owners shows it too
def test_an_arm_is_calibrated_by_hand_and_moves_then(arm, terminal, home, capsys):
    cell, bus, hand = arm
    with bus.lock:  # the arm holds itself
        for servo in bus.all_servos:
            servo.apply([(servo.model.table["Torque Enable"], 1)])
    seen = terminal("calibrate", "wx250s", "--port", bus.port, rows=44, columns=110)
    seen.wait_for("Support the arm")
    assert all(servo.torque_on for servo in bus.all_servos)
    seen.press("enter", "y", "s")
    seen.wait_for("Turn each joint")
    while not bus.rig.asleep:
        time.sleep(0.02)
    calibrate(seen, hand, cell)
    assert "Operating Mode" in seen.screen
    assert not home.exists()
    seen.press("y")
    seen.wait_for("The torque is still off")
    assert seen.exit_code == 0
    made = find_calibration("wx250s")
    assert {servo.name for servo in made.servos} == {servo.name for servo in cell.chain.servos}
    assert calibrated(cell).chain.gripper.grip.travel is not None
    check_arm(cell, bus, hand, capsys)


def check_arm(cell, bus, hand, capsys):
    """The doctor finds nothing on the servos, and the arm knows where it is, also when power was
    gone in between."""
    with bus.lock:
        for servo in bus.all_servos:
            servo.power_cycle()
    time.sleep(0.6)
    main(["doctor", bus.port, "--arm", "wx250s", "--json"])
    found = json.loads(capsys.readouterr().out)
    assert [f for f in found["findings"] if f["code"].startswith("S")] == []
    with open_arm(cell, bus.port, feedforward="off") as station:
        assert "as calibrated" in station.where
        np.testing.assert_allclose(station.driver.goal, cell.poses["zero"], atol=2.5 * 0.088 * DEG)


@pytest.fixture
def small():
    """An arm of two joints without torque, mounted anyhow, and a hand."""
    cell = load_cell("planar_2r")
    start = cell.poses["home"]
    with VirtualBus(cell.arm, centred(cell.chain), start, transport="socket") as bus:
        with bus.lock:
            bus.all_servos[0].slip(2.0)
            bus.all_servos[1].slip(0.3)
        yield cell, bus, Hand(cell, bus)


def start(terminal, bus, *more):
    seen = terminal("calibrate", "planar_2r", "--port", bus.port, *more, rows=30, columns=100)
    seen.wait_for("Turn each joint")
    return seen


def turn_from_end_to_end(hand, cell, joint, seen):
    i = cell.arm.joint_names.index(joint)
    hand.turn(joint, cell.arm.limits.q_min[i], seen)
    hand.turn(joint, cell.arm.limits.q_max[i], seen)


def find_sign(hand, joint, seen):
    seen.wait_for(f"Joint {joint}: turn it")
    seen.press("enter")  # too early
    seen.wait_for("turn it farther")
    hand.turn(joint, hand.where(joint) - 0.5)
    seen.wait_for("the numbers go down")
    seen.press("r")
    hand.turn(joint, hand.where(joint) + 0.4)
    seen.wait_for("the numbers go up")
    seen.press("enter")


def test_one_joint_by_its_ends_then_the_rest_and_nothing_is_written_by_who_leaves(
    small, terminal, home
):
    cell, bus, hand = small
    with bus.lock:
        bus.all_servos[1].memory["Max Position Limit"] = 4000
    before = eeprom(bus)
    seen = start(terminal, bus, "--joint", "joint2", "--zero", "ends", "--json")
    hand.turn("joint2", hand.where("joint2") + 6.8, seen)
    seen.wait_for("too far: the servo cannot tell")
    seen.press("enter")
    seen.wait_for("Turned farther than the servo can tell: joint2. Press r to begin anew")
    seen.press("enter")
    hand.turn("joint2", 0.0, seen)
    seen.press("r")
    seen.wait_for(r"0\.0 deg +298 deg")
    turn_from_end_to_end(hand, cell, "joint2", seen)
    seen.wait_for(r"29[78]\.\d deg +-$")
    seen.press("enter")
    find_sign(hand, "joint2", seen)
    seen.wait_for("y: write that")
    assert eeprom(bus) == before
    assert not home.exists()
    seen.press("n", "y")
    assert seen.exit_code == 0
    (saved,) = read_backup(next((home / "backups").rglob("*.toml"))).servos
    assert (saved.name, saved.image.value("Max Position Limit")) == ("joint2", 4000)
    made = find_calibration("planar_2r")
    assert [servo.name for servo in made.servos] == ["joint2"]
    assert made.servos[0].zero_by == "the ends of its travel"
    slipped = 2048 + 0.3 * 4096 / (2.0 * np.pi)
    assert made.servos[0].zero_ticks == pytest.approx(slipped, abs=2)
    document = seen.raw.decode().split("again.")[-1]
    assert json.loads(document)["servos"][0]["zero_ticks"] == made.servos[0].zero_ticks

    # what is missing is taken up; who leaves, or loses the terminal, has changed nothing
    before, text = eeprom(bus), next((home / "calibrations").rglob("*.toml")).read_text()
    for leave, code in ((lambda seen: seen.press("q"), 130), (lambda seen: seen.hang_up(), 2)):
        seen = start(terminal, bus)
        seen.wait_for("all but joint1")
        seen.press("enter")
        seen.wait_for("Missing of what the limits span: joint1 ")
        leave(seen)
        assert seen.exit_code == code
    assert eeprom(bus) == before
    assert [f.read_text() for f in (home / "calibrations").rglob("*.toml")] == [text]


def test_a_rehearsal_needs_no_arm_and_keeps_nothing(terminal, home):
    seen = terminal(
        "calibrate", "planar_2r", "--on", "virtual", "--joint", "joint2", rows=30, columns=100
    )
    seen.wait_for("your hand is on joint1")
    seen.press("down")
    seen.wait_for("your hand is on joint2")
    seen.type("\x1b[1;2C" * 4 + "\r\r")
    seen.wait_for("Joint joint2: turn it")
    seen.type("\x1b[1;2D")
    seen.wait_for("the numbers go down")
    seen.press("enter")
    seen.wait_for("The pose")
    seen.press("enter")
    seen.wait_for("y: write that")
    seen.press("y")
    seen.wait_for("A rehearsal: nothing was kept")
    assert seen.exit_code == 0
    assert not home.exists()


def test_without_a_terminal_nothing_is_asked_of_the_servos(cli, home):
    assert cli("calibrate", "planar_2r", "--port", "/dev/nothing") == 2
    assert "terminal" in cli.err
    assert len(cli.err.splitlines()) == 1


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--pose", "yoga"), "'yoga' is not one of"),
        (("--name", "../x"), "is no name of a calibration"),
        (("--use", "winter"), "no such calibration of planar_2r; there are: none"),
        (("--rename", "winter", "summer"), "no such calibration"),
    ],
)
def test_bad_words_are_refused_in_one_line(cli, home, words, message):
    assert cli("calibrate", "planar_2r", "--port", "/dev/nothing", *words) == 2
    assert message in cli.err
    assert len(cli.err.splitlines()) == 1
    assert not home.exists()


def test_calibrations_are_listed_renamed_and_taken_in_use(cli, home):
    servo = ServoCalibration(name="joint1", servo_id=1, model="XM430-W350", zero_ticks=2048)
    date = datetime(2026, 11, 22, tzinfo=UTC)
    made = Calibration(arm="planar_2r", name="summer", date=date, servos=(servo,))
    assert cli("calibrate", "planar_2r", "--list") == 0
    assert "has no calibration yet" in cli.out
    file = save_calibration(made)
    assert cli("calibrate", "planar_2r", "--use", "summer") == 0
    assert "in use" in cli.out
    assert cli("calibrate", "planar_2r", "--rename", "summer", "autumn", "--list") == 0
    assert "autumn" in cli.out
    assert cli("calibrate", "planar_2r", "--rename", "default", "spring") == 0
    assert "none is in use now; `splinearm calibrate planar_2r --use spring`" in cli.out
    assert cli("calibrate", "planar_2r", "--use", "spring") == 0
    file.with_name("bad.toml").write_text("nothing")
    assert cli("calibrate", "planar_2r", "--list", "--json") == 0
    rows = json.loads(cli.out)
    assert {row["name"] for row in rows} == {"default", "autumn", "spring", "bad"}
    assert rows[0]["name"] == "default"
    assert rows[0]["servos"][0]["zero_ticks"] == 2048
    assert ["is not TOML" in row.get("broken", "") for row in rows if row["name"] == "bad"] == [
        True
    ]


def test_an_arm_with_a_broken_calibration_is_not_opened(home):
    servo = ServoCalibration(name="joint1", servo_id=1, model="XM430-W350", zero_ticks=2048)
    date = datetime(2026, 11, 22, tzinfo=UTC)
    file = save_calibration(
        Calibration(arm="planar_2r", name="default", date=date, servos=(servo,))
    )
    file.write_text(file.read_text().replace("2048", '"2048"'))
    with (
        pytest.raises(ConfigError, match=r"servo\[0\].zero_ticks: wants .*\(line 10\)"),
        open_arm(load_cell("planar_2r"), "/dev/nothing"),
    ):
        pass
