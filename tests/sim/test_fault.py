"""What goes wrong inside a servo, set while it runs, and what it leaves behind."""

from dataclasses import replace
from math import tau

import pytest

from splinearm.drivers.model import servo_models
from splinearm.sim.alarm import ENCODER, INPUT_VOLTAGE, OVERHEATING, OVERLOAD, SHOCK
from splinearm.sim.event import EventKind
from splinearm.sim.rule import Refusal


def kinds(bench) -> list[EventKind]:
    return [event.kind for event in bench.servo.events]


# hardware errors


@pytest.mark.parametrize("name", [OVERHEATING, SHOCK, OVERLOAD])
def test_an_error_that_shutdown_names_cuts_the_torque_and_says_why(bench, name):
    bench.set("Torque Enable", 1)
    bench.servo.fail(name)
    assert bench.get("Torque Enable") == 0
    assert [event.cause for event in bench.servo.events.torque_lost()] == [name]


@pytest.mark.parametrize("name", [INPUT_VOLTAGE, ENCODER])
def test_an_error_that_shutdown_does_not_name_leaves_the_torque(bench, name):
    bench.set("Torque Enable", 1)
    bench.servo.fail(name)
    assert bench.get("Torque Enable") == 1
    assert bench.servo.error_byte(0) == 0x80
    assert bench.servo.events.torque_lost() == []


def test_shutdown_says_which_errors_cut_the_torque(bench):
    bench.set("Shutdown", 0x08)
    bench.set("Torque Enable", 1)
    bench.servo.fail(OVERLOAD)
    assert bench.get("Torque Enable") == 1
    bench.servo.fail(ENCODER)
    assert bench.get("Torque Enable") == 0


def test_an_error_that_a_model_does_not_have_is_refused(make_bench):
    servo = make_bench("XL330-M288").servo
    with pytest.raises(ValueError, match="XL330-M288: want one of input voltage, overheating"):
        servo.fail(ENCODER)


def test_a_torque_off_that_was_asked_for_is_not_a_loss(bench):
    bench.set("Torque Enable", 1)
    bench.set("Torque Enable", 0)
    assert kinds(bench)[-2:] == [EventKind.TORQUE_ON, EventKind.TORQUE_OFF]
    assert bench.servo.events.torque_lost() == []


# overload and heat by physics


def test_a_long_stall_is_an_overload(bench):
    bench.servo.stuck = True
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 3000)
    bench.run(2.9)
    assert bench.get("Hardware Error Status") == 0
    bench.run(0.3)
    assert bench.get("Hardware Error Status") == 0x20
    assert bench.get("Torque Enable") == 0


def test_a_short_stall_is_forgotten(bench):
    bench.set("Torque Enable", 1)
    for goal in (3000, 2048, 3000):
        bench.set("Goal Position", goal)
        bench.run(1.5)
    assert bench.get("Hardware Error Status") == 0


def test_share_and_time_of_an_overload_are_choices(bench):
    bench.servo.choices = replace(bench.servo.choices, overload_share=0.05, overload_time=0.5)
    bench.servo.stuck = True
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 2060)
    bench.run(0.6)
    assert bench.servo.load == 0.0
    assert bench.get("Hardware Error Status") == 0x20


def test_a_servo_under_load_gets_hot_until_it_shuts_down(bench):
    bench.servo.choices = replace(bench.servo.choices, overload_time=1e9)
    bench.servo.heat.pace = 500.0
    bench.servo.stuck = True
    bench.set("Torque Enable", 1)
    bench.set("Goal Position", 4000)
    bench.run(0.1)
    assert 40 < bench.get("Present Temperature") < 75
    bench.run(0.2)
    assert bench.get("Hardware Error Status") == 0x04
    hot = bench.servo.temperature
    bench.run(0.5)
    assert bench.servo.temperature < hot


def test_in_an_xl320_heat_and_overload_are_other_bits_and_cut_the_torque_limit(make_bench):
    bench = make_bench("XL320", zero=512)
    bench.set("Torque Enable", 1)
    bench.servo.fail(OVERLOAD)
    assert bench.get("Hardware Error Status") == 0x01
    assert bench.get("Torque Limit") == 0
    bench.run(0.1)
    assert not bench.servo.torque_on
    assert bench.get("Hardware Error Status") == 0x01
    assert bench.set("Torque Limit", 1023) == 0
    bench.run(0.1)
    assert bench.servo.torque_on
    assert bench.get("Hardware Error Status") == 0


def test_an_ax_that_is_still_hot_is_cut_off_again(make_bench):
    bench = make_bench("AX-12A", zero=512)
    bench.set("Torque Enable", 1)
    bench.servo.temperature = 75.0
    bench.run(0.05)
    assert bench.servo.error_byte_v1(0) == 0x04
    bench.set("Torque Limit", 500)
    bench.run(0.05)
    assert bench.get("Torque Limit") == 0
    bench.servo.temperature = 40.0
    bench.run(0.05)
    assert bench.servo.error_byte_v1(0) == 0
    bench.set("Torque Limit", 500)
    bench.run(0.05)
    assert bench.servo.torque_on


def test_a_voltage_error_goes_or_stays_by_choice(bench):
    for stays in (True, False):
        bench.servo.reboot()
        bench.servo.choices = replace(bench.servo.choices, voltage_error_stays=stays)
        bench.servo.voltage = 9.0
        bench.run(0.05)
        assert bench.get("Hardware Error Status") == 0x01
        bench.servo.voltage = 12.0
        bench.run(0.05)
        assert bench.get("Hardware Error Status") == (0x01 if stays else 0)


# supply


@pytest.mark.parametrize("voltage", [9.6, 14.8])
def test_a_motor_turns_by_its_supply(make_bench, voltage):
    bench = make_bench(Operating_Mode=16)
    bench.servo.voltage = voltage
    bench.set("Torque Enable", 1)
    bench.set("Goal PWM", 885)
    bench.run(1.0)
    assert bench.servo.shaft.speed == pytest.approx(46 / 60 * tau * voltage / 12.0, rel=0.02)


@pytest.mark.parametrize("voltage", [10.0, 14.0])
def test_a_current_is_kept_at_any_supply(make_bench, voltage):
    bench = make_bench(Operating_Mode=0)
    bench.servo.voltage = voltage
    bench.set("Torque Enable", 1)
    bench.set("Goal Current", 100)
    bench.run(0.01)
    assert bench.get("Present Current") == pytest.approx(100, abs=2)


def test_a_current_sensor_can_be_off(bench):
    bench.servo.current_offset = 0.05
    assert bench.get("Present Current") == round(50 / 2.69)


# power, firmware, another servo


def test_a_loss_of_power_takes_ram_turns_and_torque(make_bench):
    bench = make_bench(Operating_Mode=4)
    bench.servo.shaft.angle = 3 * tau
    bench.set("Position P Gain", 300)
    bench.set("Torque Enable", 1)
    bench.servo.power_cycle(off_for=1.0)
    assert bench.get("Operating Mode") == 4
    assert bench.get("Position P Gain") == 800
    assert bench.get("Present Position") == 2048
    assert [event.cause for event in bench.servo.events.torque_lost()] == ["loss of power"]
    bench.run(1.39)
    assert not bench.servo.listens(57_600)
    bench.run(0.02)
    assert bench.servo.listens(57_600)


def test_the_time_of_a_reboot_can_be_set(bench):
    bench.servo.choices = replace(bench.servo.choices, boot_time=0.1)
    bench.servo.reboot()
    bench.run(0.11)
    assert bench.servo.listens(57_600)


def test_old_firmware_knows_no_fast_read_and_keeps_its_settings(make_bench):
    bench = make_bench(ID=7, Baud_Rate=3)
    bench.servo.reflash(44)
    assert not bench.servo.has_fast_read
    assert (bench.servo.servo_id, bench.servo.baud) == (7, 1_000_000)
    assert bench.servo.ping()[2] == 44


def test_another_servo_in_its_place_has_factory_settings_and_sits_otherwise(make_bench):
    bench = make_bench(ID=7, Baud_Rate=3, Operating_Mode=4, Drive_Mode=1)
    bench.servo.backup(b"\x01CTRL")
    bench.servo.swap(slipped=0.2)
    assert (bench.servo.servo_id, bench.servo.baud) == (1, 57_600)
    assert bench.get("Operating Mode") == 3
    assert bench.get("Backup Ready") == 0
    # turned round as it is mounted, its position now falls with the joint
    assert abs(bench.get("Present Position") - 2048) == pytest.approx(0.2 / tau * 4096, abs=1)


@pytest.mark.parametrize("model", [model.name for model in servo_models()])
def test_an_id_and_a_baud_rate_that_a_model_lacks_cannot_be_set(make_bench, model):
    bench = make_bench(model, zero=None)
    for name in ("ID", "Baud Rate"):
        beyond = int(bench.servo.memory.table[name].maximum or 0) + 1
        assert bench.set(name, beyond) == Refusal.DATA_RANGE
    bench.set("Torque Enable", 1)
    assert bench.set("ID", 9) == Refusal.ACCESS
    bench.set("Torque Enable", 0)
    assert bench.set("ID", 9) == Refusal.NONE
    assert bench.servo.servo_id == 9


# mechanics


def test_a_stuck_joint_does_not_move_until_it_is_free(bench):
    bench.set("Torque Enable", 1)
    bench.servo.stuck = True
    assert bench.servo.stuck
    bench.set("Goal Position", 2200)
    bench.run(0.5)
    assert bench.get("Present Position") == 2048
    bench.servo.stuck = False
    bench.run(1.0)
    assert bench.get("Present Position") == pytest.approx(2200, abs=4)


def test_a_horn_that_slips_changes_the_position_and_the_servo_follows_it(bench):
    bench.set("Torque Enable", 1)
    bench.run(0.1)
    bench.servo.slip(0.1)
    assert bench.get("Present Position") == 2048 + round(0.1 / tau * 4096)
    bench.run(1.0)
    assert bench.servo.shaft.angle == pytest.approx(-0.1, abs=0.01)


def test_with_a_dead_encoder_a_servo_sees_nothing_of_its_motion(make_bench):
    bench = make_bench(Operating_Mode=1)
    bench.set("Torque Enable", 1)
    bench.set("Goal Velocity", 20)
    bench.run(0.5)
    bench.servo.encoder_dead = True
    assert bench.servo.encoder_dead
    there = bench.get("Present Position")
    bench.run(0.5)
    assert (bench.get("Present Position"), bench.get("Present Velocity")) == (there, 0)
    assert bench.servo.duty > 0.4  # it pushes harder and harder
    bench.servo.encoder_dead = False
    assert bench.get("Present Position") > there + 200


def test_with_play_the_shaft_moves_later(bench):
    moved = []
    for play in (0.0, 0.02):
        bench.servo.reboot()
        bench.servo.backlash = play
        assert bench.servo.backlash == play
        bench.servo.shaft.angle = bench.servo.shaft.speed = 0.0
        bench.set("Torque Enable", 1)
        bench.set("Goal Position", 2300)
        bench.run(0.02)
        moved.append(bench.servo.shaft.angle)
    assert moved[0] > moved[1] > 0.0


def test_what_was_done_to_its_mechanics_is_written_down(bench):
    bench.servo.stuck = True
    bench.servo.backlash = 0.01
    bench.servo.slip(-0.2)
    causes = [event.cause for event in bench.servo.events.of(EventKind.MECHANICAL)]
    assert causes == ["stuck", "backlash 0.01 rad", "slip -0.2 rad"]
