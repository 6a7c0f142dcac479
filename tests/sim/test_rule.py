"""Each rule by which a servo refuses a write, at the servo itself, without a port."""

import pytest

from splinearm.sim.rule import Refusal

NONE = Refusal.NONE


def test_a_read_only_register_refuses(bench):
    assert bench.set("Present Position", 0) == Refusal.ACCESS == 7


def test_the_eeprom_is_locked_while_the_torque_is_on(bench):
    assert bench.set("Drive Mode", 4) == NONE
    bench.set("Torque Enable", 1)
    assert bench.set("Drive Mode", 0) == Refusal.ACCESS
    assert bench.get("Drive Mode") == 4
    bench.set("Torque Enable", 0)
    assert bench.set("Drive Mode", 0) == NONE


def test_ram_is_open_while_the_torque_is_on(bench):
    bench.set("Torque Enable", 1)
    assert bench.set("Position P Gain", 700) == NONE
    assert bench.get("Position P Gain") == 700


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("Torque Enable", 2),
        ("LED", 2),
        ("Operating Mode", 2),
        ("Operating Mode", 17),
        ("Baud Rate", 8),
        ("ID", 253),
        ("Drive Mode", 2),
        ("Status Return Level", 3),
        ("Bus Watchdog", 128),
        ("Position P Gain", 16384),
        ("Max Position Limit", 4096),
        ("Min Voltage Limit", 94),
        ("PWM Limit", 886),
        ("Indirect Address 1", 63),
        ("Protocol Type", 3),
    ],
)
def test_a_value_out_of_range_is_a_range_error(bench, name, value):
    before = bench.get(name)
    assert bench.set(name, value) == Refusal.DATA_RANGE == 4
    assert bench.get(name) == before


@pytest.mark.parametrize(
    ("limit", "value", "goal", "beyond"),
    [
        ("Max Position Limit", 3000, "Goal Position", 3001),
        ("Min Position Limit", 1000, "Goal Position", 999),
        ("Velocity Limit", 100, "Goal Velocity", -101),
        ("PWM Limit", 500, "Goal PWM", 501),
        ("Current Limit", 300, "Goal Current", -301),
    ],
)
def test_a_goal_beyond_its_limit_is_a_limit_error(bench, limit, value, goal, beyond):
    assert bench.set(limit, value) == NONE
    assert bench.set(goal, beyond) == Refusal.DATA_LIMIT == 6
    within = beyond - 1 if beyond > value else beyond + 1
    assert bench.set(goal, within) == NONE


@pytest.mark.parametrize("mode", [4, 5])
def test_extended_positions_go_over_256_turns_and_no_further(bench, mode):
    bench.set("Operating Mode", mode)
    assert bench.set("Goal Position", -1_048_575) == NONE
    assert bench.set("Goal Position", 1_048_575) == NONE
    assert bench.set("Goal Position", 1_048_576) == Refusal.DATA_LIMIT


def test_modes_that_a_model_lacks_are_out_of_its_range(make_bench):
    bench = make_bench("XL430-W250")
    assert bench.set("Operating Mode", 5) == Refusal.DATA_RANGE
    assert bench.set("Operating Mode", 16) == NONE


@pytest.mark.parametrize("value", [0, 252, 253, 255])
def test_a_secondary_id_can_be_set_and_switched_off(bench, value):
    assert bench.set("Secondary(Shadow) ID", value) == NONE


def test_a_write_of_two_bytes_to_four_is_a_length_error(bench):
    assert bench.servo.write(116, b"\x00\x02") == Refusal.DATA_LENGTH == 5


def test_a_write_to_no_register_is_an_access_error(bench):
    assert bench.servo.write(66, b"\x00") == Refusal.ACCESS


def test_a_read_of_no_register_is_an_access_error(bench):
    assert bench.servo.read(66, 2) == (Refusal.ACCESS, b"")


def test_a_write_of_several_registers_is_done_in_whole_or_not_at_all(bench):
    # Profile Acceleration fits, Profile Velocity does not
    data = (5).to_bytes(4, "little") + (40_000).to_bytes(4, "little")
    assert bench.servo.write(108, data) == Refusal.DATA_RANGE
    assert bench.get("Profile Acceleration") == 0


def test_indirect_data_obey_the_rules_of_what_they_point_at(bench):
    for k in range(4):
        bench.set(f"Indirect Address {k + 1}", 116 + k)
        bench.set(f"Indirect Address {k + 5}", 132 + k)
    assert bench.servo.write(224, (4096).to_bytes(4, "little")) == Refusal.DATA_LIMIT
    assert bench.servo.write(228, bytes(4)) == Refusal.ACCESS
    assert bench.servo.write(224, (1000).to_bytes(4, "little")) == NONE
    assert bench.get("Goal Position") == 1000
