import pytest
from dynamixel_sdk import PacketHandler
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers.crc import crc16, crc16_numpy, crc16_plain


def test_the_crc_has_the_check_value_of_crc_16_umts():
    assert crc16(b"123456789") == 0xFEE8  # the catalogue's check value (CRC-16/UMTS)


@pytest.mark.property
@given(data=st.binary(max_size=300))
def test_the_crc_agrees_with_the_makers(data):
    assert crc16(data) == PacketHandler(2.0).updateCRC(0, data, len(data))


@pytest.mark.property
@given(first=st.binary(max_size=40), second=st.binary(max_size=40))
def test_a_crc_goes_on_where_another_ended(first, second):
    assert crc16(second, crc16(first)) == crc16(first + second)


@pytest.mark.property
@given(data=st.binary(max_size=700), start=st.integers(0, 0xFFFF))
def test_all_ways_to_a_crc_agree(data, start):
    assert crc16(data, start) == crc16_plain(data, start) == crc16_numpy(data, start)
