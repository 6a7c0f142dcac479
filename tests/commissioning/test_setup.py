"""Setup on servos in memory: from any state to the same end, whoever stops it and where."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from memory_line import Helper, KilledError, checked, load_cell, set_up
from setup_scenes import KOCH, SCENES, disordered, fresh, ready, with_registers

from splinearm.commissioning.bench import Address, Found
from splinearm.commissioning.image import read_image
from splinearm.commissioning.session import Session
from splinearm.commissioning.task import Change, Task
from splinearm.config.folder import user_folder
from splinearm.errors import BusTimeoutError, DeclinedError, ServoError
from splinearm.sim.shaft import Shaft
from splinearm.sim.virtual_servo import VirtualServo

LONG = ("disordered", "half fresh", "fresh")
"""Of those every place to be killed at is for the long run."""


def as_set_up(cell):
    """What all servos hold at last."""
    line = fresh(cell)
    set_up(line, cell)
    return line.tables()


@pytest.mark.parametrize(
    "scene", [pytest.param(s, marks=[pytest.mark.slow] * (s in LONG)) for s in SCENES]
)
def test_killed_before_any_write_and_started_again_it_comes_to_the_same_end(scene):
    cell, make = SCENES[scene]
    whole = make()
    set_up(whole, cell)
    wanted = whole.tables()
    assert whole.writes > 3
    for k in range(whole.writes):
        line = make()
        line.kill_at = line.writes + k
        with pytest.raises(KilledError):
            set_up(line, cell)
        line.kill_at = None
        set_up(line, cell)
        assert line.tables() == wanted, f"killed before write {k}"


@pytest.mark.parametrize("scene", SCENES)
def test_a_second_run_writes_nothing_and_asks_nothing(scene):
    cell, make = SCENES[scene]
    line = make()
    set_up(line, cell)
    writes, files = line.writes, sorted(user_folder().rglob("*.toml"))
    person = Helper(line)
    report = set_up(line, cell, person)
    assert (line.writes, report.written, report.backup) == (writes, 0, None)
    assert (person.asked, person.tables, report.left) == ([], [], [])
    assert sorted(user_folder().rglob("*.toml")) == files
    assert checked(line, cell).left == []


@pytest.mark.slow
@pytest.mark.parametrize("arm", ["wx250s", "omx_f", "open_manipulator_x", "rx150", "wx200"])
def test_every_shipped_arm_is_set_up_from_the_box_wherever_it_is_killed(arm):
    cell = load_cell(arm)
    wanted = as_set_up(cell)
    count = fresh(cell)
    set_up(count, cell)
    for k in range(count.writes):
        line = fresh(cell)
        line.kill_at = k
        with pytest.raises(KilledError):
            set_up(line, cell)
        line.kill_at = None
        set_up(line, cell)
        assert line.tables() == wanted


@pytest.mark.property
@settings(max_examples=12, deadline=None)
@given(st.data())
def test_from_any_registers_it_comes_to_the_same_end(data):
    line = ready(KOCH)
    wanted = line.tables()
    for servo in line.servos.values():
        for name, values in {
            "Baud Rate": st.sampled_from((1, 2, 3, 4)),
            "Return Delay Time": st.integers(0, 254),
            "Operating Mode": st.sampled_from((1, 3, 4)),
            "Drive Mode": st.sampled_from((0, 1, 4, 5)),
            "Homing Offset": st.integers(-5000, 5000),
            "Secondary(Shadow) ID": st.sampled_from((255, 254, 2, 9)),
            "Status Return Level": st.sampled_from((0, 1, 2)),
        }.items():
            if data.draw(st.booleans(), label=name):
                servo.memory[name] = data.draw(values)
    line.servos["gripper"].memory["Drive Mode"] = 0
    line.servos["gripper"].memory["Homing Offset"] = 0
    line.servos["gripper"].memory["Secondary(Shadow) ID"] = 255
    set_up(line, KOCH)
    got = line.tables()
    for name, table in got.items():
        if table["Secondary(Shadow) ID"] >= 253:
            table["Secondary(Shadow) ID"] = wanted[name]["Secondary(Shadow) ID"]
    assert got == wanted


def test_the_first_thing_written_is_the_id_and_then_the_rate():
    line = fresh()
    line.kill_at = 3  # the base's rate, its delay and mode: then the next one's id
    person = Helper(line)
    with pytest.raises(KilledError):
        set_up(line, KOCH, person)
    (pan,) = person.tables[0]
    assert [c.register.name for c in pan.changes[:2]] == ["Baud Rate", "Return Delay Time"]
    line.kill_at = None
    set_up(line, KOCH, person)
    (lift,) = person.tables[1]
    assert [c.register.name for c in lift.changes[:2]] == ["ID", "Baud Rate"]


# --- what is asked, and what is not


def test_whole_tables_are_kept_before_the_first_write():
    line = disordered()
    line.kill_at = 0
    before = line.servos["shoulder_lift"].memory.read(0, 64)
    with pytest.raises(KilledError):
        set_up(line, KOCH)
    files = (user_folder() / "backups" / "koch_v1_1").glob("*-ttyMEM*.toml")
    newest = max(files, key=lambda file: file.stat().st_mtime_ns)
    assert before[:32].hex(" ") in newest.read_text(encoding="utf-8")


def test_without_a_yes_nothing_is_written():
    line = disordered()
    with pytest.raises(DeclinedError):
        set_up(line, KOCH, Helper(line, agrees=False))
    assert line.writes == 0


def test_torque_goes_off_only_if_the_person_says_that_the_arm_may_fall():
    line = with_registers(KOCH, elbow_flex=(("Return Delay Time", 9),))
    for servo in line.servos.values():
        servo.write(servo.model.table["Torque Enable"].address, b"\x01")
    refusing = Helper(line, falls=False)
    with pytest.raises(DeclinedError, match="not agreed that they lose it; nothing written"):
        set_up(line, KOCH, refusing)
    assert line.writes == 0
    assert refusing.let_fall == [tuple(line.servos)]
    set_up(line, KOCH)
    assert line.servos["elbow_flex"].memory["Return Delay Time"] == 0
    assert line.servos["shoulder_pan"].torque_on  # it needed nothing


def test_check_writes_nothing_and_says_what_is_left():
    line = disordered()
    report = checked(line, KOCH)
    assert line.writes == 0
    left = "\n".join(report.left)
    assert "shoulder_lift: ID 3 -> 2" in left
    assert "shoulder_pan: Protocol Type 1 -> 2" in left
    assert "wrist_roll: reboot to clear: overload" in left
    assert "gripper: PWM Limit 0 -> 885" in left
    assert checked(ready(), KOCH).left == []


def test_check_of_an_empty_line_and_of_servos_that_cannot_be_told_apart_says_so():
    line = fresh()
    assert len(checked(line, KOCH).left) == 6
    line.connect("elbow_flex")
    assert "elbow_flex: no XL330-M288 answers as id 3; it may be the one with id 1 at 57600" in (
        "\n".join(checked(line, KOCH).left)
    )
    line.connect("elbow_flex", "gripper")
    assert "as if two servos had this id" in checked(line, KOCH).left[0]
    assert line.writes == 0


# --- who is who


@pytest.mark.parametrize("yes", [False, True])
def test_a_servo_that_was_there_before_it_was_asked_for_is_asked_about(yes):
    line = fresh()
    line.connect("shoulder_lift")

    class Careful(Helper):
        def is_it(self, servo, one):
            self.asked.append(f"is it {servo.name}?")
            return not yes and super().is_it(servo, one)

    person = Careful(line)
    set_up(line, KOCH, person)
    assert person.asked[:2] == ["is it shoulder_pan?", "shoulder_pan"]
    assert person.told[0] == "Disconnect the servo that is there now (id 1 at 57600 baud)."
    assert [servo.servo_id for servo in line.servos.values()] == [1, 2, 3, 4, 5, 6]


def test_a_servo_that_stays_where_another_was_asked_for_is_not_taken_for_it():
    line = fresh()
    line.connect("shoulder_lift")
    person = Helper(line)
    person.connects = lambda servo: person.asked.append(servo.name)
    with pytest.raises(BusTimeoutError, match=r"servo 1 \(shoulder_pan\)"):
        set_up(line, KOCH, person, patience=3.0)
    assert line.writes == 0


def test_a_servo_of_another_model_is_refused_with_both():
    line = ready()
    line.servos["elbow_flex"] = other = VirtualServo.of(
        replace(KOCH.chain.servos[0], servo_id=3), KOCH.chain.baud, Shaft()
    )
    line.line = type(line.line)(line.servos.values())
    assert other.servo_id == 3
    with pytest.raises(ServoError, match=r"servo 3 \(elbow_flex\): found a XL430.*says XL330-M288"):
        set_up(line, KOCH)
    assert line.writes == 0


def test_one_by_one_believes_no_id():
    line = ready()
    line.servos["wrist_flex"].memory["ID"] = 5
    line.servos["wrist_roll"].memory["ID"] = 4  # of the same model: nothing shows it
    assert checked(line, KOCH).left == []
    person = Helper(line)
    line.connect("nobody")
    set_up(line, KOCH, person, one_by_one=True)
    assert person.asked == [*line.servos, "all"]
    assert line.servos["wrist_flex"].servo_id == 4
    assert line.servos["wrist_roll"].servo_id == 5


def test_who_has_the_id_of_another_and_is_not_known_goes_to_a_free_one():
    line = fresh()
    line.connect()
    for k, servo in enumerate(line.servos.values()):
        servo.memory["Baud Rate"] = 3
        servo.memory["ID"] = k + 1
    line.servos["wrist_flex"].memory["ID"] = 7
    line.servos["wrist_roll"].memory["ID"] = 8
    line.servos["gripper"].unplugged = True
    person = Helper(line)
    set_up(line, KOCH, person)
    assert {name: s.servo_id for name, s in line.servos.items()}["wrist_roll"] == 5
    assert person.asked[0] == "wrist_flex"


def test_nobody_connects_anything_and_it_says_whom_it_waits_for():
    line = fresh()
    person = Helper(line)
    person.connects = lambda servo: None
    with pytest.raises(BusTimeoutError, match=r"servo 1 \(shoulder_pan\)"):
        set_up(line, KOCH, person, patience=2.0)
    assert line.now > 2.0


def test_a_strange_servo_is_left_alone_and_told():
    line = ready()
    stranger = VirtualServo.of(replace(KOCH.chain.servos[0], servo_id=9), 1_000_000, Shaft())
    line.servos["stranger"] = stranger
    line.line = type(line.line)(line.servos.values())
    line.servos["gripper"].memory["Baud Rate"] = 2
    person = Helper(line)
    report = set_up(line, KOCH, person)
    assert report.notes == [
        "id 9 at 1000000 baud: a XL430-W250 that the arm's file does not name; it is left alone"
    ]
    assert stranger.servo_id == 9


# --- what cannot be


def test_too_old_a_firmware_is_told_with_the_register():
    chain = KOCH.chain
    settings = {**chain.servos[1].settings, "Drive Mode": 4}
    servos = (chain.servos[0], replace(chain.servos[1], settings=settings), *chain.servos[2:])
    cell = replace(KOCH, chain=replace(chain, servos=servos))
    line = ready()
    line.servos["shoulder_lift"].choices = replace(line.servos["shoulder_lift"].choices)
    line.servos["shoulder_lift"].reflash(40)
    with pytest.raises(ServoError, match=r"Drive Mode 4 .profiles by time. needs firmware 42"):
        set_up(line, cell)
    assert line.writes == 0


def test_an_error_that_comes_back_after_the_reboot_is_told():
    line = ready()
    servo = line.servos["elbow_flex"]
    servo.memory["Temperature Limit"] = 20
    servo.temperature = 40.0
    servo.fail("overheating")
    servo.begin_anew = lambda *_: None  # as hot as before
    with pytest.raises(ServoError, match=r"elbow_flex.*reports overheating again after a reboot"):
        set_up(line, KOCH)


def test_a_servo_that_answers_pings_alone_is_let_answer_after_a_yes():
    line = with_registers(KOCH, elbow_flex=(("Status Return Level", 0), ("Return Delay Time", 8)))
    assert "id 3 at 1000000 baud: a XL330-M288 answers pings alone" in checked(line, KOCH).left[0]
    with pytest.raises(DeclinedError, match="cannot be read"):
        set_up(line, KOCH, Helper(line, agrees=False))
    assert line.writes == 0
    person = Helper(line)
    set_up(line, KOCH, person)
    assert person.asked[0].endswith("set that to 2, so that it can be read?")
    assert line.servos["elbow_flex"].memory["Return Delay Time"] == 0


def test_a_servo_that_never_stays_as_it_was_set_is_named():
    line = with_registers(KOCH, elbow_flex=(("Return Delay Time", 9),))
    person = Helper(line)

    def spoil(words):
        if words.startswith("elbow_flex: done"):
            line.servos["elbow_flex"].memory["Return Delay Time"] = 9

    person.tell = spoil
    with pytest.raises(ServoError, match=r"servo 3 \(elbow_flex\): it is otherwise each time"):
        set_up(line, KOCH, person)


def test_a_locked_eeprom_is_told():
    spec = replace(KOCH.chain.servos[0], model="AX-12A", settings={})
    line = fresh()
    line.servos = {"old": VirtualServo.of(spec, 1_000_000, Shaft())}
    line.line = type(line.line)(line.servos.values())
    line.servos["old"].memory["Lock"] = 1
    with line.bench() as bench:
        image = read_image(bench, Found(Address(1_000_000, 1, 1), 12, 24))
        change = Change(image.model.table["Return Delay Time"], 250, 0)
        session = Session(bench, Helper(line), "old")
        task = Task(name="old", image=image, changes=(change,))
        with pytest.raises(ServoError, match="its EEPROM is locked"):
            session.carry_out([task], {image.address: image}, {})
    assert line.writes == 0
