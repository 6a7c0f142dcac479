import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers import packets
from splinearm.drivers.packets import Instruction
from splinearm.drivers.registers import load_table
from splinearm.drivers.sending import Block, GroupWrite

IDS = (3, 7, 4)
XM = load_table("XM430-W350")
GOAL, VELOCITY, CURRENT = XM["Goal Position"], XM["Goal Velocity"], XM["Goal Current"]
FAR_GOAL = load_table("PH42-020-S300")["Goal Position"]


@pytest.mark.property
@given(goals=st.lists(st.integers(-(2**31), 2**31 - 1), min_size=3, max_size=3))
def test_a_sync_write_says_every_value_and_is_stuffed(goals):
    frame = GroupWrite([(i, GOAL) for i in IDS]).frame(goals)
    packet = packets.decode(frame)
    assert packet.instruction == Instruction.SYNC_WRITE
    entries = tuple((i, GOAL.encode(goal)) for i, goal in zip(IDS, goals, strict=True))
    assert packets.parse_sync_write(packet.params) == (116, 4, entries)


def test_different_places_make_a_bulk_write():
    frame = GroupWrite([(3, GOAL), (7, FAR_GOAL)]).frame([-5, 6])
    entries = packets.parse_bulk_write(packets.decode(frame).params)
    assert entries == ((3, 116, GOAL.encode(-5)), (7, 564, FAR_GOAL.encode(6)))


def test_values_that_do_not_fit_are_refused():
    writer = GroupWrite([(i, GOAL) for i in IDS])
    with pytest.raises(ValueError, match="want 3"):
        writer.frame([1, 2])
    with pytest.raises(ValueError, match="values"):
        writer.frame([1, 2, 2**31])


def test_writes_without_servos_or_with_twins_are_refused():
    for ids in ((), (1, 1)):
        with pytest.raises(ValueError, match="targets"):
            GroupWrite([(i, GOAL) for i in ids])


@pytest.mark.property
@given(
    rows=st.lists(
        st.tuples(st.integers(-(2**31), 2**31 - 1), st.integers(-(2**31), 2**31 - 1)),
        min_size=2,
        max_size=2,
    ),
    current=st.integers(-(2**15), 2**15 - 1),
)
def test_blocks_of_several_registers_are_sent_side_by_side(rows, current):
    blocks = [Block(3, 224, (GOAL, VELOCITY, CURRENT)), Block(7, 224, (GOAL, VELOCITY, 2))]
    frame = GroupWrite(blocks).frame([*rows[0], current, *rows[1]])
    packet = packets.decode(frame)
    assert packet.instruction == Instruction.SYNC_WRITE
    first = b"".join(r.encode(v) for r, v in zip((GOAL, VELOCITY), rows[0], strict=True))
    second = b"".join(r.encode(v) for r, v in zip((GOAL, VELOCITY), rows[1], strict=True))
    assert packets.parse_sync_write(packet.params) == (
        224,
        10,
        ((3, first + CURRENT.encode(current)), (7, second + b"\0\0")),
    )
