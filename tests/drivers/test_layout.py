import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers.layout import (
    block_length,
    common_place,
    indirect_items,
    own_place,
    side_by_side,
)
from splinearm.drivers.model import servo_model, servo_models

XM, XL, PH = (servo_model(name) for name in ("XM430-W350", "XL430-W250", "PH42-020-S300"))
MOTION = ("Present Velocity", "Present Position")
NEW = 60


def fields(model, *names):
    return tuple(model.table[name] for name in names)


def items(*models, firmware=NEW):
    return {k: indirect_items(model, firmware) for k, model in enumerate(models)}


def test_registers_side_by_side_are_found_where_they_are():
    assert side_by_side(fields(XM, "Present Current", *MOTION)) == 126
    assert side_by_side(fields(XM, "Present Position", "Present Velocity")) is None
    assert side_by_side((*fields(XM, "Goal Position"), 2)) is None
    assert side_by_side((*fields(XM, "Goal Position"), 0)) == 116


def test_models_of_one_family_need_no_indirect_data():
    wanted = {0: fields(XM, *MOTION), 1: fields(XL, *MOTION)}
    places = common_place(wanted, items(XM, XL))
    assert {k: (p.address, p.length, p.pointers) for k, p in places.items()} == {
        0: (128, 8, ()),
        1: (128, 8, ()),
    }


def test_models_of_different_families_meet_in_their_indirect_data():
    wanted = {0: fields(XM, *MOTION), 1: fields(PH, *MOTION)}
    places = common_place(wanted, items(XM, PH))
    assert {p.address for p in places.values()} == {634}
    assert [p.target for p in places[0].pointers] == list(range(128, 136))
    assert [p.target for p in places[1].pointers] == list(range(576, 584))
    assert [p.address for p in places[1].pointers] == list(range(168, 184, 2))


def test_a_second_block_takes_no_byte_of_the_first():
    wanted = {0: fields(XM, *MOTION), 1: fields(PH, *MOTION)}
    first = common_place(wanted, items(XM, PH))
    second = common_place(wanted, items(XM, PH), first)
    for k in wanted:
        assert not set(first[k].span) & set(second[k].span)
        own = {p.address for p in first[k].pointers}
        assert not own & {p.address for p in second[k].pointers}


def test_blocks_of_other_lengths_and_models_without_indirect_data_do_not_meet():
    other = servo_model("XL320")
    mixed = {0: fields(XM, "Goal Position"), 1: fields(other, "Goal Position")}
    assert common_place(mixed, items(XM, other)) is None
    same = {0: fields(XM, "Goal PWM"), 1: fields(other, "Goal Position")}
    assert common_place(same, items(XM, other)) is None
    assert indirect_items(other, NEW) == {}


def test_bytes_that_mean_nothing_stand_for_themselves():
    place = own_place((*fields(XL, "Goal Position"), 2), indirect_items(XL, NEW))
    tail = place.pointers[-2:]
    assert [p.target for p in tail] == list(place.span)[-2:]


def test_old_firmware_of_the_xl330_has_a_bank_of_its_own():
    model = servo_model("XL330-M288")
    old = indirect_items(model, 52)
    assert (min(old), len(old), old[208]) == (208, 20, 168)
    new = indirect_items(model, 53)
    assert (min(new), len(new), new[224]) == (224, 28, 168)


indirect = [m for m in servo_models() if indirect_items(m, NEW)]


@pytest.mark.property
@given(model=st.sampled_from(indirect), data=st.data())
def test_the_bytes_of_a_place_are_those_of_its_fields(model, data):
    readable = [r for r in model.table.registers if not r.name.startswith("Indirect")]
    chosen = data.draw(st.lists(st.sampled_from(readable), min_size=1, max_size=5, unique=True))
    bank = indirect_items(model, NEW)
    place = own_place(chosen, bank)
    assert place.length == block_length(chosen)
    wanted = [a for r in chosen for a in range(r.address, r.end)]
    if place.pointers:
        target = {p.address: p.target for p in place.pointers}
        assert [target[bank[at]] for at in place.span] == wanted
    else:
        assert list(place.span) == wanted
