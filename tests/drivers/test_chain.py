import pytest

from splinearm.drivers.chain import ServoChain, ServoRole


def test_a_chain_gives_its_leaders_in_the_order_of_the_joints(make_chain):
    chain = make_chain()
    names = [servo.name for servo in chain.leaders_of(("elbow", "waist"))]
    assert names == ["elbow", "waist"]
    assert [servo.name for servo in chain.shadows_of(("shoulder",))] == ["shadow"]
    assert chain.shadows_of(("waist",)) == ()
    assert chain.servo("shadow").servo_id == 3


def test_names_that_are_not_there_are_answered_with_those_that_are(make_chain):
    with pytest.raises(ValueError, match="shoulder"):
        make_chain().leaders_of(("wrist",))
    with pytest.raises(ValueError, match="elbow"):
        make_chain().servo("wrist")


def test_settings_cannot_be_changed_from_outside(make_spec):
    settings = {"Drive Mode": 1}
    servo = make_spec("waist", 1, settings=settings)
    settings["Drive Mode"] = 0
    assert servo.settings["Drive Mode"] == 1
    with pytest.raises(TypeError):
        servo.settings["Drive Mode"] = 0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"servo_id": 253}, "0..252"),
        ({"model": "SG90"}, "no servo model"),
        ({"settings": {"Torque": 1}}, "no register 'Torque'"),
        ({"settings": {"Present Position": 1}}, "can only be read"),
        ({"settings": {"Drive Mode": 256}}, "0..255"),
        ({"settings": {"Torque Enable": 1}}, "the driver"),
        ({"joint": None}, "the joint it moves"),
        ({"role": ServoRole.GRIPPER}, "no joint"),
    ],
)
def test_a_servo_that_cannot_be_is_refused(make_spec, changes, message):
    facts = {"name": "waist", "servo_id": 1} | changes
    with pytest.raises(ValueError, match=message):
        make_spec(facts.pop("name"), facts.pop("servo_id"), **facts)


@pytest.mark.parametrize(
    ("second", "message"),
    [
        ({"name": "b", "servo_id": 1, "joint": "b"}, "two have the id 1"),
        ({"name": "a", "servo_id": 2, "joint": "b"}, "two have the name 'a'"),
        ({"name": "b", "servo_id": 2, "joint": "a"}, "joint of a leader 'a'"),
        ({"name": "b", "servo_id": 2, "joint": "c", "role": ServoRole.SHADOW}, "has no leader"),
    ],
)
def test_servos_that_contradict_each_other_are_refused(make_spec, second, message):
    pair = (make_spec("a", 1), make_spec(second.pop("name"), second.pop("servo_id"), **second))
    with pytest.raises(ValueError, match=message):
        ServoChain(servos=pair)


def test_a_bus_that_cannot_be_is_refused():
    with pytest.raises(ValueError, match="baud"):
        ServoChain(servos=(), baud=0)
    with pytest.raises(ValueError, match="protocol"):
        ServoChain(servos=(), protocol=3.0)
