import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers.model import servo_models
from splinearm.drivers.registers import (
    Access,
    Area,
    ControlTable,
    Register,
    load_table,
    resolve,
)

MODELS = [model.name for model in servo_models()]


def test_there_are_twelve_tables():
    assert len(MODELS) == 12


@pytest.mark.parametrize("name", MODELS)
def test_a_table_loads_and_its_bounds_name_registers_that_it_has(name):
    table = load_table(name)
    assert table["Model Number"].address == 0
    assert [table[register] for register in table] == list(table.registers)
    for register in table.registers:
        assert table.at(register.address) is table.at(register.end - 1) is register
        for bound in (register.initial, register.minimum, register.maximum):
            if isinstance(bound, str):
                assert bound.removeprefix("-") in table


@pytest.mark.parametrize(
    ("model", "name", "address", "size"),
    [
        ("XM430-W350", "Goal Position", 116, 4),
        ("XM430-W350", "Present Position", 132, 4),
        ("XM430-W350", "Bus Watchdog", 98, 1),
        ("XL430-W250", "Present Load", 126, 2),
        ("XL330-M288", "Hardware Error Status", 70, 1),
        ("MX-28-2", "Drive Mode", 10, 1),
        ("PH42-020-S300", "Goal Position", 564, 4),
        ("XL320", "Goal Position", 30, 2),
        ("AX-12A", "Present Position", 36, 2),
    ],
)
def test_registers_lie_where_the_manual_has_them(model, name, address, size):
    register = load_table(model)[name]
    assert (register.address, register.size) == (address, size)


def test_a_register_says_what_may_be_done_with_it():
    table = load_table("XM430-W350")
    assert table["Homing Offset"].area is Area.EEPROM
    assert table["Homing Offset"].signed
    assert not table["Present Position"].writable
    assert table["Present Velocity"].scale == pytest.approx(0.229)
    assert table["Present Velocity"].unit == "rev/min"


def any_register():
    return st.builds(
        lambda size, signed: Register(
            name="R", address=0, size=size, area=Area.RAM, access=Access.WRITE, signed=signed
        ),
        st.sampled_from([1, 2, 4]),
        st.booleans(),
    )


@pytest.mark.property
@given(register=any_register(), data=st.data())
def test_a_value_comes_back_from_its_bytes(register, data):
    low, high = register.span
    value = data.draw(st.integers(low, high))
    assert register.decode(register.encode(value)) == value
    for outside in (low - 1, high + 1):
        with pytest.raises(ValueError, match=str(outside)):
            register.encode(outside)


def test_bytes_of_another_length_are_refused():
    with pytest.raises(ValueError, match="want 4 bytes, got 2"):
        load_table("XM430-W350")["Goal Position"].decode(b"ab")


def test_an_unknown_register_is_answered_with_near_names():
    with pytest.raises(KeyError, match="Goal Position"):
        load_table("XM430-W350")["Goal Positon"]
    with pytest.raises(KeyError, match="address 5000"):
        load_table("XM430-W350").at(5000)


def test_an_unknown_model_is_answered_with_those_there_are():
    with pytest.raises(ValueError, match="XM430-W350"):
        load_table("XM430")


def test_limits_follow_the_registers_that_hold_them():
    table = load_table("XM430-W350")
    values = {"Min Position Limit": 819, "Max Position Limit": 3345, "PWM Limit": 885}
    assert table.limits("Goal Position", values.__getitem__) == (819, 3345)
    assert table.limits("Goal PWM", values.__getitem__) == (-885, 885)
    assert table.limits("Shutdown", values.__getitem__) == (0, 255)
    assert resolve(None, values.__getitem__) is None


def test_registers_that_overlap_are_refused():
    def at(name, address):
        return Register(name=name, address=address, size=2, area=Area.RAM, access=Access.READ)

    with pytest.raises(ValueError, match="B lies upon A"):
        ControlTable("X", [at("A", 0), at("B", 1)])
    with pytest.raises(ValueError, match="two registers"):
        ControlTable("X", [at("A", 0), at("A", 4)])
