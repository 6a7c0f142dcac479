import pytest

from splinearm.drivers.registers import load_table
from splinearm.sim.memory import AddressError, LengthError, TableMemory


@pytest.fixture
def memory() -> TableMemory:
    return TableMemory(load_table("XM430-W350"))


def test_it_begins_with_the_factorys_values(memory):
    assert memory["Model Number"] == 1020
    assert memory["Position P Gain"] == 800
    assert memory["Min Position Limit"] == 0
    assert memory["Indirect Address 1"] == 224


def test_signed_registers_come_back_signed(memory):
    memory["Goal Velocity"] = -5
    assert memory["Goal Velocity"] == -5
    assert memory.read(104, 4) == b"\xfb\xff\xff\xff"


def test_a_read_over_a_gap_reads_zeros_there(memory):
    memory["LED"] = 1
    assert memory.read(64, 4) == b"\x00\x01\x00\x00"


@pytest.mark.parametrize(("address", "length"), [(66, 2), (14, 3), (661, 2), (2000, 1), (64, 0)])
def test_a_read_of_nothing_is_refused(memory, address, length):
    with pytest.raises(AddressError):
        memory.read(address, length)


def test_a_write_of_neighbours_is_a_change_of_each(memory):
    changes = memory.changes(108, (5).to_bytes(4, "little") + (7).to_bytes(4, "little"))
    assert [(c.register.name, c.value) for c in changes] == [
        ("Profile Acceleration", 5),
        ("Profile Velocity", 7),
    ]


def test_a_write_changes_nothing_by_itself(memory):
    memory.changes(65, b"\x01")
    assert memory["LED"] == 0


@pytest.mark.parametrize("data", [b"", b"\x00\x02", bytes(5)])
def test_a_write_of_part_of_a_register_is_refused(memory, data):
    with pytest.raises(LengthError):
        memory.changes(116, data)


@pytest.mark.parametrize("address", [66, 117, 2000])
def test_a_write_where_no_register_begins_is_refused(memory, address):
    with pytest.raises(AddressError):
        memory.changes(address, b"\x00")


def test_indirect_data_are_bytes_of_their_own_until_they_point_elsewhere(memory):
    (change,) = memory.changes(224, b"\x2a")
    assert change.register.name == "Indirect Data 1"


def test_indirect_data_stand_for_what_they_point_at(memory):
    for k in range(4):
        memory[f"Indirect Address {k + 1}"] = 116 + k
        memory[f"Indirect Address {k + 5}"] = 132 + k
    memory["Present Position"] = -7
    (change,) = memory.changes(224, (1234).to_bytes(4, "little"))
    assert (change.register.name, change.value) == ("Goal Position", 1234)
    assert memory.read(228, 4) == b"\xf9\xff\xff\xff"


def test_the_second_block_of_indirect_data_works_too(memory):
    memory["Indirect Address 29"] = 65
    (change,) = memory.changes(634, b"\x01")
    assert change.register.name == "LED"


def test_indirect_data_that_point_at_half_a_register_cannot_be_written(memory):
    memory["Indirect Address 1"] = 116
    with pytest.raises(LengthError):
        memory.changes(224, b"\x00")


def test_a_measured_value_stops_at_the_registers_end(memory):
    memory.show("Present Current", 1e9)
    assert memory["Present Current"] == 32767
    memory.show("Present Temperature", -3.0)
    assert memory["Present Temperature"] == 0


def test_it_tells_whose_bytes_a_read_shows_and_forgets_that_when_pointers_move(memory):
    for k in range(2):
        memory[f"Indirect Address {k + 1}"] = 126 + k
    assert memory.names_in(224, 2) == ("Present Current",)
    assert memory.names_in(126, 6) == ("Present Current", "Present Velocity")
    memory["Indirect Address 2"] = 146
    assert memory.names_in(224, 2) == ("Present Current", "Present Temperature")


def test_a_pointer_to_where_nothing_is_reads_zero(memory):
    memory["Indirect Address 1"] = 1023
    assert memory.read(224, 1) == b"\x00"


def test_a_register_that_there_is_not_is_named(memory):
    with pytest.raises(KeyError, match="XM430-W350 has no register 'Goal Speed'"):
        memory["Goal Speed"]
