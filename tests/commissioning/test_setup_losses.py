"""Setup where something is lost, in the way, or of another kind."""

from contextlib import suppress

import pytest
from memory_line import Helper, checked, load_cell, set_up
from setup_scenes import KOCH, SCENES, disordered, fresh, with_registers

from splinearm.commissioning.backup import read_backup, write_backup
from splinearm.commissioning.restore import restore
from splinearm.commissioning.save import save_arm
from splinearm.commissioning.setup import Setup
from splinearm.drivers.model import servo_models
from splinearm.errors import ConfigError, SplinearmError


def test_no_servo_wakes_with_torque_once_it_is_set_up():
    line = with_registers(KOCH, elbow_flex=(("Startup Configuration", 3),))
    assert checked(line, KOCH).left == ["elbow_flex: Startup Configuration 3 -> 2"]
    set_up(line, KOCH)
    assert line.servos["elbow_flex"].memory["Startup Configuration"] == 2
    assert not line.servos["elbow_flex"].torque_on


@pytest.mark.parametrize("servo_id", [3, 5])
def test_of_two_that_have_one_id_each_is_asked_for_by_itself(servo_id):
    line = with_registers(KOCH, wrist_flex=(("ID", servo_id),))
    person = Helper(line)
    set_up(line, KOCH, person)
    assert [servo.servo_id for servo in line.servos.values()] == [1, 2, 3, 4, 5, 6]
    assert "wrist_flex" in person.asked


def test_without_room_for_a_backup_nothing_is_written(tmp_path, monkeypatch):
    line = disordered()
    (tmp_path / "file").touch()
    monkeypatch.setenv("SPLINEARM_HOME", str(tmp_path / "file"))
    with line.bench() as bench:
        setup = Setup(bench, KOCH, Helper(line))
        with pytest.raises(ConfigError, match="cannot be written"):
            setup.run()
    assert (line.writes, setup.report.backup) == (0, None)


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("loss", ["a servo", "the power", "the port", "a moment"])
def test_whatever_is_lost_before_any_write_it_comes_to_the_same_end(scene, loss):
    cell, make = SCENES[scene]
    whole = make()
    set_up(whole, cell)
    wanted = whole.tables()
    for k in range(whole.writes):
        line = make()
        connected = [name for name, servo in line.servos.items() if not servo.unplugged]
        line.lose_at(line.writes + k, loss)
        with suppress(SplinearmError):
            set_up(line, cell, patience=3.0)
        line.connect(*(connected or ["nobody"]))
        set_up(line, cell)
        assert line.tables() == wanted, f"lost {loss} before write {k}"


SUPPLIES = {"XL330-M077": 5.0, "XL330-M288": 5.0, "XL320": 7.4, "PH42-020-S300": 24.0}
"""At which voltage models are known that are not known at 12 V."""


def arm_of(model, protocol, baud, file):
    """An arm of six servos of one model."""
    wanted = {
        "protocol": f"{protocol}.0",
        "max_speed_deg_s": "100.0",
        "baud": str(baud),
        "supply_v": str(SUPPLIES.get(model.name, 12.0)),
    }
    lines = []
    for line in KOCH.file.read_text(encoding="utf-8").splitlines():
        key = line.split(" ")[0]
        if not key.startswith(("operating_mode", "profile_", "position_")):
            lines.append(f"{key} = {wanted[key]}" if key in wanted else line)
    text = "\n".join(lines).replace("XL330-M288", model.name).replace("XL430-W250", model.name)
    file.write_text(text, encoding="utf-8")
    return load_cell(file)


def every_way():
    """Model, protocol and rate; the quick run takes those of one old model alone."""
    for model in servo_models():
        for protocol in model.protocols:
            for baud in sorted(rate for rate in model.baud_codes.values() if rate <= 4_500_000):
                usual = model.name == "AX-12A" and baud == 1_000_000
                marks = [] if usual else [pytest.mark.slow]
                yield pytest.param(model, protocol, baud, marks=marks)


@pytest.mark.parametrize(("model", "protocol", "baud"), list(every_way()))
def test_servos_of_every_model_are_set_up_and_restored(model, protocol, baud, tmp_path):
    cell = arm_of(model, protocol, baud, tmp_path / "arm.toml")
    line = fresh(cell)
    set_up(line, cell)
    assert [servo.servo_id for servo in line.servos.values()] == [1, 2, 3, 4, 5, 6]
    assert all(servo.memory["Return Delay Time"] == 0 for servo in line.servos.values())
    writes = line.writes
    set_up(line, cell)
    assert line.writes == writes
    before = line.tables()
    with line.bench() as bench:
        write_backup(tmp_path / "a.toml", save_arm(bench, cell.name, cell.chain).backup)
        for servo in line.servos.values():
            servo.memory["Return Delay Time"] = 9
        restore(bench, read_backup(tmp_path / "a.toml"), Helper(line))
    assert line.tables() == before
