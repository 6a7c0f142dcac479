import numpy as np
import pytest

from splinearm.config import load_cell
from splinearm.config.servo import register_names
from splinearm.drivers.chain import ServoRole
from splinearm.drivers.model import servo_model, servo_models


def test_servos_become_a_chain(arm_text, written):
    chain = load_cell(written(arm_text)).chain
    assert [servo.servo_id for servo in chain.servos] == [1, 2, 3, 4]
    assert [servo.role for servo in chain.servos] == [
        ServoRole.LEADER,
        ServoRole.SHADOW,
        ServoRole.LEADER,
        ServoRole.GRIPPER,
    ]
    assert [servo.joint for servo in chain.servos] == ["shoulder", "shoulder", "elbow", None]
    assert [servo.zero_ticks for servo in chain.servos] == [2048, 2048, 2048, None]
    assert dict(chain.servos[1].settings) == {"Drive Mode": 1, "Secondary(Shadow) ID": 1}
    assert (chain.baud, chain.protocol, chain.usual_port) == (1_000_000, 2.0, None)


def test_the_bus_is_as_the_file_says(arm_text, written, edited):
    text = edited(
        arm_text, "[bus]", '[bus]\nbaud = 57600\nprotocol = 2.0\nusual_port = "/dev/ttyUSB7"'
    )
    chain = load_cell(written(text)).chain
    assert (chain.baud, chain.usual_port) == (57600, "/dev/ttyUSB7")


def test_leader_and_shadow_add_up_to_the_torque_of_a_joint(arm_text, written):
    np.testing.assert_array_equal(load_cell(written(arm_text)).arm.limits.torque_max, [8.2, 1.5])


def test_the_torque_is_that_at_the_supply(arm_text, written, edited):
    text = edited(arm_text, "supply_v = 12.0", "supply_v = 11.1")
    np.testing.assert_allclose(load_cell(written(text)).arm.limits.torque_max, [7.6, 1.4])
    text = edited(arm_text, 'joint = "elbow"', 'joint = "elbow"\nsupply_v = 11.55')
    np.testing.assert_allclose(load_cell(written(text)).arm.limits.torque_max, [8.2, 1.45])


def test_a_joint_may_be_told_to_give_less(arm_text, written, edited):
    text = edited(arm_text, "mass_kg = 0.3", "max_torque_nm = 3.0\nmass_kg = 0.3")
    np.testing.assert_array_equal(load_cell(written(text)).arm.limits.torque_max, [3.0, 1.5])


def test_a_torque_that_a_maker_does_not_publish_is_not_known(arm_text, written, edited):
    old = 'model = "XL430-W250"\nrole = "leader"\njoint = "elbow"\nzero_ticks = 2048'
    new = 'model = "PH42-020-S300"\nrole = "leader"\njoint = "elbow"\nzero_ticks = 0\nsupply_v = 24'
    assert load_cell(written(edited(arm_text, old, new))).arm.limits.torque_max is None


def test_without_servos_there_is_no_chain(sliding_arm_text, written):
    assert load_cell(written(sliding_arm_text)).chain is None


@pytest.mark.parametrize("model", [model.name for model in servo_models()])
def test_every_register_that_a_file_may_set_has_one_key(model):
    names = register_names(servo_model(model))
    assert all(key.replace("_", "").isalnum() and key == key.lower() for key in names)
    assert len({register.name for register in names.values()}) == len(names)
    assert not {"id", "baud_rate", "torque_enable", "goal_position"} & set(names)


def test_known_registers_have_the_keys_one_would_guess():
    names = register_names(servo_model("XM430-W350"))
    for key, name in {
        "drive_mode": "Drive Mode",
        "secondary_id": "Secondary(Shadow) ID",
        "position_p_gain": "Position P Gain",
        "feedforward_2nd_gain": "Feedforward 2nd Gain",
        "goal_current": "Goal Current",
        "homing_offset": "Homing Offset",
        "return_delay_time": "Return Delay Time",
    }.items():
        assert names[key].name == name


def test_a_servo_that_counts_its_turns_may_turn_without_end(arm_text, written, edited):
    text = edited(arm_text, "min_deg = -150.0\nmax_deg = 150.0", "endless = true")
    text = edited(text, "velocity_limit = 200", "operating_mode = 4")
    assert load_cell(written(text)).arm.limits.q_max[0] == np.inf


def test_an_initial_value_outside_the_bounds_may_be_written(arm_text, written, edited):
    text = edited(arm_text, "velocity_limit = 200", "secondary_id = 255")
    settings = load_cell(written(text)).chain.servos[0].settings
    assert dict(settings) == {"Secondary(Shadow) ID": 255}


@pytest.mark.parametrize(
    ("change", "key", "remedy"),
    [
        (
            ("id = 2\n", "id = 1\n"),
            "servo[1].id",
            "1 is also the id of 'one'; give each servo its own",
        ),
        (('name = "helper"', 'name = "one"'), "servo[1].name", "also the name of another servo"),
        (('role = "shadow"', 'role = "leader"'), "servo[1].role", "a second motor is a shadow"),
        (("id = 4\n", "id = 253\n"), "servo[3].id", "from 0 to 252, got 253"),
        (('joint = "elbow"', 'joint = "elbo"'), "servo[2].joint", 'did you mean "elbow"'),
        (('joint = "elbow"\n', ""), "servo[2].joint", 'give one of "shoulder", "elbow"'),
        (
            ('joint = "elbow"', 'joint = "shoulder"'),
            "servo[2].role",
            "already leads joint 'shoulder'",
        ),
        (
            ('role = "gripper"', 'role = "gripper"\njoint = "elbow"'),
            "servo[3].joint",
            "take the key",
        ),
        (('"XL430-W250"', '"XL430-W260"'), "servo[2].model", 'did you mean "XL430-W250"'),
        (('role = "leader"', 'role = "led"'), "servo[0].role", 'did you mean "leader"'),
        (("zero_ticks = 2048\n", ""), "servo[0].zero_ticks", "give a whole number"),
        (("zero_ticks = 2048", 'zero_ticks = "later"'), "servo[0].zero_ticks", 'or "calibrate"'),
        (("zero_ticks = 2048", "zero_deg = 180"), "servo[0].zero_ticks", "is missing"),
        (
            ("velocity_limit = 200", "velocity_limit = 5000"),
            "servo[0].registers.velocity_limit",
            "Velocity Limit takes 0 to 1023, got 5000",
        ),
        (
            ("velocity_limit = 200", "speed_limit = 3"),
            "servo[0].registers.speed_limit",
            "is no register of XM430-W350 that a file sets; did you mean",
        ),
        (
            ("velocity_limit = 200", "torque_enable = 1"),
            "servo[0].registers.torque_enable",
            "is no register of XM430-W350 that a file sets",
        ),
        (
            ("velocity_limit = 200", "operating_mode = 7"),
            "servo[0].registers.operating_mode",
            "has the modes 0, 1, 3, 4, 5, 16, got 7",
        ),
        (
            ("velocity_limit = 200", "operating_mode = 1"),
            "servo[0].registers.operating_mode",
            "want a position mode",
        ),
        (
            ("velocity_limit = 200", "min_position_limit = 1000"),
            "joint[0].min_deg",
            "-150 deg is beyond where servo 'one' ends, -92.1094 deg; narrow it",
        ),
        (("max_deg = 150.0", "max_deg = 190"), "joint[0].max_deg", "ends, 179.912 deg"),
        (("min_deg = -150.0\nmax_deg = 150.0", "endless = true"), "joint[0].endless", "no limit"),
        (
            ("velocity_limit = 200", "velocity_limit = 100"),
            "joint[0].max_speed_deg_s",
            "160 deg/s is above the 137.4 deg/s that servo 'one' is set to",
        ),
        (
            ("= 160.0", "= 300"),
            "joint[0].max_speed_deg_s",
            "servo 'one' turns without load at 12 V",
        ),
        (
            ("secondary_id = 1", "secondary_id = 3"),
            "servo[1].registers.secondary_id",
            "wants 1, the id of its leader 'one', got 3",
        ),
        (
            ("mass_kg = 0.3", "mass_kg = 0.3\nmax_torque_nm = 9"),
            "joint[0].max_torque_nm",
            "more than its servos give, 8.2 N m",
        ),
        (("supply_v = 12.0\n", ""), "servo[0].supply_v", "give the voltage here or in \\[bus\\]"),
        (
            ("supply_v = 12.0", "supply_v = 5"),
            "servo[0].supply_v",
            "known from 11.1 to 14.8 V, got 5",
        ),
        (("[bus]", "[bus]\nbaud = 123"), "bus.baud", "want one of 9600.*got 123"),
        (("[bus]", "[bus]\nprotocol = 3"), "bus.protocol", "there are 1.0 and 2.0, got 3"),
        (
            ("[bus]", "[bus]\nport = 3"),
            "bus.port",
            "known are supply_v, feedforward, baud, protocol, usual_port",
        ),
    ],
)
def test_servos_that_cannot_be_used_are_refused(change, key, remedy, arm_text, edited, refusal):
    refusal(load_cell, edited(arm_text, *change), key, remedy)


def test_every_joint_has_a_leader_if_there_are_servos(arm_text, written, refusal):
    start, end = (
        arm_text.index('[[servo]]\nname = "three"'),
        arm_text.index('[[servo]]\nname = "hand"'),
    )
    remedy = r"joint 'elbow' has no leader; add a \[\[servo\]\] .* joint = \"elbow\""
    refusal(load_cell, arm_text[:start] + arm_text[end:], "servo", remedy)


def test_a_shadow_has_a_leader(arm_text, refusal):
    start, end = arm_text.index("[[servo]]"), arm_text.index('[[servo]]\nname = "helper"')
    text = arm_text[:start] + arm_text[end:]
    refusal(load_cell, text, "servo[0].joint", "joint 'shoulder' has no leader")


def test_a_servo_moves_no_sliding_joint(sliding_arm_text, written, refusal):
    servo = '[bus]\nsupply_v = 12\n[[servo]]\nname = "s{0}"\nid = {0}\nmodel = "XM430-W350"\n'
    servo += 'role = "leader"\nzero_ticks = 2048\njoint = "{1}"\n'
    second = servo.replace("[bus]\nsupply_v = 12\n", "")
    text = sliding_arm_text.replace("min_deg = -180.0", "min_deg = -170.0")
    text = text.replace("max_deg = 180.0", "max_deg = 170.0")
    text += servo.format(1, "turn") + second.format(2, "slide")
    refusal(load_cell, text, "servo[1].joint", "'slide' slides, and a servo only turns")
