"""What a servo does when told so by an instruction other than read and write."""

import pytest

from splinearm.drivers.chain import ServoRole, ServoSpec
from splinearm.drivers.model import servo_model
from splinearm.sim.rule import Refusal
from splinearm.sim.shaft import Shaft
from splinearm.sim.virtual_servo import BOOT_TIME, VirtualServo

CLEAR = b"\x01\x44\x58\x4c\x22"
BACKUP, RESTORE = b"\x01CTRL", b"\x02CTRL"


def test_a_reg_write_waits_for_its_action(bench):
    assert bench.servo.reg_write(104, (50).to_bytes(4, "little")) == 0
    assert bench.get("Registered Instruction") == 1
    assert bench.get("Goal Velocity") == 0
    assert bench.servo.action() == 0
    assert bench.get("Goal Velocity") == 50
    assert bench.get("Registered Instruction") == 0


def test_an_action_without_a_reg_write_is_an_instruction_error(bench):
    assert bench.servo.action() == Refusal.INSTRUCTION == 2


def test_a_reg_write_that_would_be_refused_is_refused_at_once(bench):
    assert bench.servo.reg_write(104, (500).to_bytes(4, "little")) == Refusal.DATA_LIMIT
    assert bench.get("Registered Instruction") == 0


def test_a_reboot_forgets_ram_and_keeps_eeprom(bench):
    bench.set("Drive Mode", 4)
    bench.set("Position P Gain", 333)
    bench.set("Torque Enable", 1)
    assert bench.servo.reboot() == 0
    assert bench.get("Torque Enable") == 0
    assert bench.get("Position P Gain") == 800
    assert bench.get("Drive Mode") == 4


def test_for_a_while_after_a_reboot_it_is_deaf(bench):
    assert bench.servo.listens(57_600)
    bench.servo.reboot()
    assert not bench.servo.listens(57_600)
    bench.run(BOOT_TIME + 0.002)
    assert bench.servo.listens(57_600)


@pytest.mark.parametrize(
    ("option", "servo_id", "baud"), [(0xFF, 1, 57_600), (0x01, 7, 57_600), (0x02, 7, 1_000_000)]
)
def test_a_factory_reset_spares_what_its_option_names(make_bench, option, servo_id, baud):
    bench = make_bench(ID=7, Baud_Rate=3, Drive_Mode=4)
    assert bench.servo.factory_reset(option) == 0
    assert bench.servo.servo_id == servo_id
    assert bench.servo.baud == baud
    assert bench.get("Drive Mode") == 0
    assert bench.get("Firmware Version") == 53


def test_a_factory_reset_without_a_known_option_is_refused(make_bench):
    bench = make_bench(ID=7)
    assert bench.servo.factory_reset(0x03) == Refusal.DATA_RANGE
    assert bench.servo.factory_reset(0xFF, broadcast=True) == Refusal.RESULT_FAIL
    assert bench.servo.servo_id == 7


def test_a_clear_forgets_whole_turns(make_bench):
    bench = make_bench(Operating_Mode=4)
    bench.servo.shaft.angle = 20.0
    folded = bench.get("Present Position") % 4096
    assert bench.servo.clear(CLEAR) == 0
    assert bench.get("Present Position") == folded


def test_after_a_clear_the_servo_stays_where_it_is(make_bench):
    bench = make_bench(Operating_Mode=4)
    bench.servo.shaft.angle = 20.0
    bench.set("Goal Position", bench.get("Present Position"))
    bench.set("Torque Enable", 1)
    bench.run(0.1)
    assert bench.servo.clear(CLEAR) == 0
    bench.run(0.5)
    assert bench.servo.shaft.angle == pytest.approx(20.0, abs=0.01)


def test_a_clear_in_motion_fails(make_bench):
    bench = make_bench(Operating_Mode=1)
    bench.set("Torque Enable", 1)
    bench.set("Goal Velocity", 100)
    bench.run(0.5)
    assert bench.servo.clear(CLEAR) == Refusal.RESULT_FAIL == 1


def test_a_clear_of_anything_else_is_refused(bench):
    assert bench.servo.clear(b"\x02ERCL") == Refusal.DATA_RANGE


def test_settings_come_back_from_a_backup(bench):
    bench.set("Position P Gain", 333)
    bench.set("Drive Mode", 4)
    bench.set("Indirect Address 1", 65)
    assert bench.servo.backup(RESTORE) == Refusal.RESULT_FAIL  # there is none yet
    assert bench.servo.backup(BACKUP) == 0
    assert bench.get("Backup Ready") == 1
    bench.servo.factory_reset(0x01)
    assert bench.get("Drive Mode") == 0
    assert bench.servo.backup(RESTORE) == 0
    assert bench.get("Drive Mode") == 4
    assert bench.get("Position P Gain") == 333
    assert bench.get("Indirect Address 1") == 65


def test_with_the_torque_on_there_is_no_backup(bench):
    bench.set("Torque Enable", 1)
    assert bench.servo.backup(BACKUP) == Refusal.RESULT_FAIL


def test_old_firmware_knows_neither_backup_nor_clear_nor_fast_reads():
    servo = VirtualServo(servo_model("XM430-W350"), firmware=38)
    assert servo.backup(BACKUP) == Refusal.INSTRUCTION
    assert servo.clear(CLEAR) == Refusal.INSTRUCTION
    assert not servo.has_fast_read


def test_startup_configuration_switches_the_torque_on_and_restores_ram(make_bench):
    bench = make_bench(Startup_Configuration=3)
    assert bench.get("Torque Enable") == 1
    bench.set("Torque Enable", 0)
    bench.set("Position P Gain", 444)
    bench.servo.backup(BACKUP)
    bench.servo.reboot()
    assert bench.get("Position P Gain") == 444
    assert bench.get("Torque Enable") == 1


def test_by_its_secondary_id_its_eeprom_is_closed(bench):
    assert bench.servo.write(10, b"\x01", shadowing=True) == Refusal.ACCESS
    assert bench.servo.write(65, b"\x01", shadowing=True) == 0


def test_the_arm_file_sets_it_up():
    spec = ServoSpec(
        name="elbow",
        servo_id=9,
        model="XM430-W350",
        role=ServoRole.LEADER,
        joint="elbow",
        zero_ticks=1500,
        settings={"Drive Mode": 1, "Velocity Limit": 131},
    )
    servo = VirtualServo.of(spec, 1_000_000, Shaft(angle=0.1))
    assert (servo.servo_id, servo.baud) == (9, 1_000_000)
    assert servo.value("Velocity Limit") == 131
    assert servo.value("Present Position") == 1500 + round(0.1 * 4096 / 6.283185307)


def test_a_servo_left_to_calibration_is_mounted_at_its_centre():
    spec = ServoSpec(name="g", servo_id=9, model="XL330-M288", role=ServoRole.GRIPPER)
    assert VirtualServo.of(spec, 57_600, Shaft()).position == 2048


def test_a_baud_rate_that_the_model_has_not_is_refused():
    spec = ServoSpec(name="g", servo_id=9, model="XL330-M288", role=ServoRole.GRIPPER)
    with pytest.raises(ValueError, match="baud: want one of"):
        VirtualServo.of(spec, 4_500_000, Shaft())


def test_a_setting_that_does_not_fit_is_refused():
    with pytest.raises(ValueError, match=r"ID: want a value in 0\.\.255, got 256"):
        VirtualServo(servo_model("XM430-W350"), settings={"ID": 256})
