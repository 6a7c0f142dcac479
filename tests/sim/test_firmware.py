"""What a firmware version decides."""

import pytest

from splinearm.drivers.model import servo_model
from splinearm.sim.firmware import knows_clear, newest_firmware, table_of
from splinearm.sim.rule import Refusal


def test_an_old_xl330_has_twenty_indirect_items_with_data_at_208():
    table = table_of(servo_model("XL330-M288"), 52)
    assert table["Indirect Data 1"].address == 208
    assert table["Indirect Data 20"].address == 227
    assert table["Indirect Address 20"].initial == 227
    assert table["Indirect Address 1"].maximum == 227
    assert "Indirect Address 21" not in table
    assert table_of(servo_model("XL330-M288"), 53)["Indirect Data 1"].address == 224


def test_indirect_data_of_an_old_xl330_work(make_bench):
    bench = make_bench("XL330-M288", Firmware_Version=52)
    for k in range(4):
        assert bench.set(f"Indirect Address {k + 1}", 116 + k) == 0
    assert bench.servo.write(208, (1234).to_bytes(4, "little")) == 0
    assert bench.get("Goal Position") == 1234
    assert bench.servo.read(228, 4)[0] == Refusal.ACCESS
    assert bench.servo.write(224, bytes(4)) == Refusal.NONE  # four items of their own


def test_a_new_firmware_moves_the_indirect_data(make_bench):
    bench = make_bench("XL330-M288", Firmware_Version=52)
    bench.servo.reflash(53)
    assert bench.servo.write(208, b"\x01") == Refusal.DATA_LENGTH  # half of an Indirect Address
    assert bench.get("Indirect Data 28") == 0


@pytest.mark.parametrize(
    ("model", "firmware", "known"),
    [("XM430-W350", 42, True), ("XM430-W350", 41, False), ("AX-12A", 99, False),
     ("XL320", 99, False), ("PH42-020-S300", 12, True)],
)  # fmt: skip
def test_clear_came_with_a_firmware(model, firmware, known):
    assert knows_clear(servo_model(model), firmware) is known


def test_a_virtual_servo_has_a_firmware_that_reads_fast_if_its_model_ever_does():
    for name in ("XM430-W350", "XL330-M077", "PH42-020-S300"):
        model = servo_model(name)
        assert model.has_fast_read(newest_firmware(model))


@pytest.mark.parametrize(
    ("model", "firmware", "bits"),
    [("XM430-W350", 45, 0x0D), ("XM430-W350", 44, 0x05), ("XM430-W350", 41, 0x01),
     ("XL330-M288", 45, 0x05), ("XL330-M288", 46, 0x0D), ("PH42-020-S300", 12, 0x0D)],
)  # fmt: skip
def test_drive_mode_has_the_bits_of_its_firmware(make_bench, model, firmware, bits):
    bench = make_bench(model, zero=None, Firmware_Version=firmware)
    for bit in (0x01, 0x04, 0x08):
        refused = 0 if bits & bit else Refusal.DATA_RANGE
        assert bench.set("Drive Mode", bit) == refused
