"""Backups: every byte of the table in a file, and the EEPROM from it back."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from memory_line import Helper, KilledError, MemoryLine, load_cell, set_up

from splinearm.commissioning.backup import backup_file, read_backup, write_backup
from splinearm.commissioning.image import kept
from splinearm.commissioning.restore import restore
from splinearm.commissioning.save import save_arm, save_everyone
from splinearm.drivers.registers import Area
from splinearm.errors import ConfigError, DeclinedError, ServoError, SilentBusError

KOCH = load_cell("koch_v1_1")


def ready():
    line = MemoryLine(KOCH)
    set_up(line, KOCH)
    line.connect()
    return line


def eeprom(line):
    """Every byte of every EEPROM that can be written."""
    return {
        name: {r.name: servo.memory.read(r.address, r.size) for r in kept(servo.model.table)}
        for name, servo in line.servos.items()
    }


def saved_in(line, file):
    with line.bench() as bench:
        saved = save_arm(bench, KOCH.name, KOCH.chain)
    write_backup(file, saved.backup)
    return saved


def restored(line, file, person=None, **options):
    with line.bench() as bench:
        return restore(bench, read_backup(file), person or Helper(line), **options)


def spoil(line, draw=None):
    """Change whatever can be changed."""
    for k, servo in enumerate(line.servos.values()):
        for name, value in {
            "Return Delay Time": 7 + k,
            "Drive Mode": 5,
            "Operating Mode": 3,
            "Homing Offset": -100 * k - 1,
            "Velocity Limit": 33,
            "Min Position Limit": 5,
            "Secondary(Shadow) ID": (k + 3) % 6 + 1,
            "Shutdown": 1,
        }.items():
            servo.memory[name] = value


def test_the_file_has_every_byte_of_both_areas(tmp_path):
    line = ready()
    saved_in(line, tmp_path / "a.toml")
    backup = read_backup(tmp_path / "a.toml")
    assert [servo.name for servo in backup.servos] == list(line.servos)
    for servo in backup.servos:
        memory = line.servos[servo.name].memory
        assert {block.area for block in servo.image.blocks} == {Area.EEPROM, Area.RAM}
        for register in memory.table.registers:
            data = servo.image.bytes_at(register.address, register.size)
            assert data == memory.read(register.address, register.size), register.name


def test_a_restored_backup_equals_the_original_in_every_writable_byte(tmp_path):
    line = ready()
    line.servos["wrist_roll"].memory["Moving Threshold"] = 77
    saved_in(line, tmp_path / "a.toml")
    before = eeprom(line)
    spoil(line)
    line.servos["elbow_flex"].memory["Baud Rate"] = 1
    line.servos["shoulder_pan"].memory["Protocol Type"] = 1
    line.servos["gripper"].memory["ID"] = 9
    assert eeprom(line) != before
    report = restored(line, tmp_path / "a.toml")
    assert eeprom(line) == before
    assert report.backup is not None
    assert "Model Number, Model Information, Firmware Version (read only)" in report.notes[0]
    writes = line.writes
    assert restored(line, tmp_path / "a.toml").written == 0
    assert line.writes == writes


def test_servos_go_back_to_how_they_came_out_of_the_box_one_at_a_time(tmp_path):
    line = MemoryLine(KOCH)
    line.connect()
    fresh = eeprom(line)
    line.connect("nobody")
    file = set_up(line, KOCH).backup
    line.connect()
    with pytest.raises(ConfigError, match="both were id 1 at 57600 baud, which cannot be on one"):
        restored(line, file)
    restored(line, file, only=["elbow_flex"])
    with pytest.raises(ServoError, match=r"shall get id 1 .*where another servo answers"):
        restored(line, file, only=["gripper"])
    for name in line.servos:
        line.connect(name)
        restored(line, file, only=[name])
    assert eeprom(line) == fresh


def test_killed_anywhere_and_started_again_it_is_restored_all_the_same(tmp_path):
    line = ready()
    saved_in(line, tmp_path / "a.toml")
    before = eeprom(line)

    def hurt():
        line = ready()
        spoil(line)
        line.servos["gripper"].memory["ID"] = 9
        line.servos["gripper"].memory["Baud Rate"] = 2
        line.writes = 0
        return line

    whole = hurt()
    restored(whole, tmp_path / "a.toml")
    for k in range(0, whole.writes, 9):
        line = hurt()
        line.kill_at = k
        with pytest.raises(KilledError):
            restored(line, tmp_path / "a.toml")
        line.kill_at = None
        restored(line, tmp_path / "a.toml")
        assert eeprom(line) == before


@pytest.mark.property
@settings(max_examples=6, deadline=None)
@given(st.data())
def test_any_eeprom_is_kept_and_restored_byte_for_byte(tmp_path_factory, data):
    line = ready()
    servo = line.servos["shoulder_lift"]
    for register in kept(servo.model.table):
        low, high = register.minimum, register.maximum
        if register.name in ("ID", "Baud Rate", "Protocol Type", "Operating Mode", "Drive Mode"):
            continue
        if isinstance(low, int) and isinstance(high, int):
            servo.memory[register.name] = data.draw(st.integers(low, high), label=register.name)
    file = tmp_path_factory.mktemp("any") / "a.toml"
    servo.memory["Status Return Level"] = 2
    saved_in(line, file)
    before = eeprom(line)
    spoil(line)
    restored(line, file, only=["shoulder_lift"])
    assert eeprom(line)["shoulder_lift"] == before["shoulder_lift"]


def test_whatever_an_arm_and_a_port_are_called_is_read_again(tmp_path):
    line = ready()
    saved = saved_in(line, tmp_path / "a.toml").backup
    for name in ('of "mine"\x07', "a\\b\x7f\n", "\N{MECHANICAL ARM} \u00fc"):
        write_backup(tmp_path / "b.toml", replace(saved, arm=name, port=name))
        read = read_backup(tmp_path / "b.toml")
        assert (read.arm, read.port) == (name, name)


def test_who_is_stopped_in_the_middle_knows_where_the_servos_are_kept_as_they_were(tmp_path):
    line = ready()
    saved_in(line, tmp_path / "a.toml")
    spoil(line)
    line.kill_at = line.writes
    person = Helper(line)
    with pytest.raises(KilledError):
        restored(line, tmp_path / "a.toml", person)
    (words,) = person.told
    assert read_backup(words.removeprefix("the servos as they were: ")).arm == KOCH.name


def test_without_a_yes_nothing_is_restored(tmp_path):
    line = ready()
    saved_in(line, tmp_path / "a.toml")
    spoil(line)
    writes = line.writes
    with pytest.raises(DeclinedError):
        restored(line, tmp_path / "a.toml", Helper(line, agrees=False))
    assert line.writes == writes


def test_who_is_not_there_is_named(tmp_path):
    line = ready()
    saved_in(line, tmp_path / "a.toml")
    line.connect("shoulder_pan", "gripper")
    with pytest.raises(ServoError, match=r"servo 2 \(shoulder_lift\): no XL430-W250 on /dev/ttyM"):
        restored(line, tmp_path / "a.toml")
    with pytest.raises(ConfigError, match="'nose' is not one of shoulder_pan"):
        restored(line, tmp_path / "a.toml", only=["nose"])


def test_a_servo_that_is_another_of_the_backup_is_not_taken_for_the_one_that_is_missing(tmp_path):
    line = ready()
    saved_in(line, tmp_path / "a.toml")
    line.connect("shoulder_pan")  # of the same model
    writes = line.writes
    with pytest.raises(ServoError, match=r"servo 2 \(shoulder_lift\): no XL430-W250"):
        restored(line, tmp_path / "a.toml", only=["shoulder_lift"])
    assert line.writes == writes


def test_whoever_answers_is_saved_without_an_arm_too():
    line = ready()
    line.servos["gripper"].memory["Baud Rate"] = 1
    line.servos["gripper"].memory["ID"] = 2
    with line.bench() as bench:
        saved = save_everyone(bench)
    names = [servo.name for servo in saved.backup.servos]
    assert sorted(names) == [
        "id 2 at 1000000 baud",
        "id 2 at 57600 baud",
        *(f"servo {k}" for k in (1, 3, 4, 5)),
    ]
    line.connect("nobody")
    with line.bench() as bench, pytest.raises(SilentBusError):
        save_everyone(bench)


def test_what_is_not_in_a_backup_is_said():
    line = ready()
    line.servos["gripper"].unplugged = True
    line.servos["elbow_flex"].memory["Status Return Level"] = 0
    with line.bench() as bench:
        saved = save_arm(bench, KOCH.name, KOCH.chain)
    assert saved.lacking == (
        "gripper: no answer as id 6",
        "id 3 at 1000000 baud: answers pings alone",
    )


def test_a_backup_s_name_says_arm_and_port_and_is_never_taken_twice():
    first = backup_file("my arm", "/dev/serial/by-id/usb-ROBOTIS_U2D2 (x)-if00")
    assert first.parent.name == "my_arm"
    assert first.name.endswith("-usb-ROBOTIS_U2D2_x_-if00.toml")
    first.parent.mkdir(parents=True)
    first.touch()
    second = backup_file("my arm", "/dev/serial/by-id/usb-ROBOTIS_U2D2 (x)-if00")
    assert second != first
    assert backup_file("", "unix:/tmp/x/bus.sock").parent.name == "servos"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('schema = "splinearm-backup/1"', 'schema = "x"', "schema: wants"),
        ("model_number = 1060", "model_number = 1", r"model_number: of a XL430-W250 is 1060"),
        ('bytes = """\n24', 'bytes = """\nzz', "pairs of hexadecimal digits"),
        ("id = 1\n", "id = 7\n", "has no EEPROM with the ID 7"),
        ("firmware = 53", "firmwar = 53", "firmware: is missing"),
        ('area = "EEPROM"', 'area = "ROM"', "area: wants one of"),
        ("address = 0\n", "address = 10\n", "has no bytes of ID, Baud Rate.*was the file cut off"),
    ],
)
def test_a_file_that_is_no_backup_is_refused(tmp_path, old, new, words):
    line = ready()
    file = tmp_path / "a.toml"
    saved_in(line, file)
    text = file.read_text(encoding="utf-8")
    assert old in text
    file.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ConfigError, match=words):
        read_backup(file)


def test_a_servo_replaced_by_a_new_one_gets_what_the_old_one_held(tmp_path):
    line = ready()
    saved_in(line, tmp_path / "a.toml")
    before = eeprom(line)
    servo = line.servos["wrist_flex"]
    servo.swap()
    servo.choices = replace(servo.choices, boot_time=0.0)
    restored(line, tmp_path / "a.toml")
    assert eeprom(line) == before


def test_of_an_old_firmware_is_kept_what_it_has(tmp_path):
    line = ready()
    servo = line.servos["gripper"]
    servo.reflash(52)  # its indirect registers lie elsewhere, and fewer of them
    saved_in(line, tmp_path / "a.toml")
    (image,) = [s.image for s in read_backup(tmp_path / "a.toml").servos if s.name == "gripper"]
    assert image.found.firmware == 52
    assert image.value("Present Position") is not None
    assert max(b.address + len(b.data) for b in image.blocks) <= servo.memory.table.size


def test_in_protocol_1_what_lies_beyond_its_reach_is_left_out():
    line = ready()
    line.servos["shoulder_pan"].memory["Protocol Type"] = 1
    with line.bench() as bench:
        saved = save_everyone(bench)
    (image,) = [s.image for s in saved.backup.servos if s.image.address.protocol == 1]
    assert image.value("Indirect Data 28") is not None
    assert image.value("Indirect Data 29") is None


@pytest.mark.parametrize(
    ("address", "byte", "words"),
    [
        (8, "c8", "Baud Rate: is 200, a XL430-W250 takes 0, 1, 2"),
        (11, "09", "Operating Mode: is 9, a XL430-W250 takes 1, 3, 4, 16"),
        (9, "ff", "Return Delay Time: is 255, a XL430-W250 takes 0 to 254"),
    ],
)
def test_what_a_servo_would_refuse_is_refused_before_anything_is_written(
    tmp_path, address, byte, words
):
    line = ready()
    line.servos["shoulder_pan"].memory["Velocity Limit"] = 44
    file = tmp_path / "a.toml"
    saved_in(line, file)
    text = file.read_text(encoding="utf-8")
    at = text.index('bytes = """\n') + len('bytes = """\n') + 3 * address
    file.write_text(text[:at] + byte + text[at + 2 :], encoding="utf-8")
    line.servos["shoulder_pan"].memory["Velocity Limit"] = 55
    writes = line.writes
    with pytest.raises(ConfigError, match=words):
        restored(line, file)
    assert line.writes == writes


def test_two_of_one_name_and_names_that_cannot_be_shown_are_refused(tmp_path):
    line = ready()
    file = tmp_path / "a.toml"
    saved_in(line, file)
    text = file.read_text(encoding="utf-8")
    for old, new, words in (
        ('"shoulder_lift"', '"shoulder_pan"', "two of the name 'shoulder_pan'"),
        ('"shoulder_lift"', '"\\u001b[31m"', "wants letters that can be shown"),
    ):
        file.write_text(text.replace(old, new), encoding="utf-8")
        with pytest.raises(ConfigError, match=words):
            read_backup(file)


def test_a_restored_servo_that_wakes_with_torque_is_not_woken_and_said(tmp_path):
    line = ready()
    servo = line.servos["elbow_flex"]
    servo.memory["Startup Configuration"] = 1
    saved_in(line, tmp_path / "a.toml")
    servo.memory["Startup Configuration"] = 0
    report = restored(line, tmp_path / "a.toml")
    assert servo.memory["Startup Configuration"] == 1
    assert not servo.torque_on
    assert "elbow_flex: it switches its torque on by itself" in report.notes[-1]
