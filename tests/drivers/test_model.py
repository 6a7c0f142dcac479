from math import pi, radians

import pytest

from splinearm.drivers.model import servo_model, servo_model_by_number, servo_models


@pytest.mark.parametrize("model", servo_models(), ids=lambda model: model.name)
def test_a_model_is_found_by_name_and_number(model):
    assert servo_model(model.name.lower()) is model
    assert servo_model_by_number(model.number) is model
    assert model.table["Model Number"].initial == model.number


def test_figures_are_in_si():
    model = servo_model("XM430-W350")
    assert model.pulses_per_rad == pytest.approx(4096 / (2 * pi))
    assert model.no_load[1].speed == pytest.approx(46 * 2 * pi / 60)
    assert model.stall[1].torque == pytest.approx(4.1)
    assert model.mass == pytest.approx(0.082)
    assert servo_model("AX-12A").span == pytest.approx(radians(300))


def test_fast_reads_depend_on_the_firmware():
    assert not servo_model("XM430-W350").has_fast_read(44)
    assert servo_model("XM430-W350").has_fast_read(45)
    assert not servo_model("MX-28-2").has_fast_read(250)


def test_hardware_errors_have_names():
    model = servo_model("XM430-W350")
    assert model.hardware_errors(0x24) == ("overheating", "overload")
    assert model.hardware_errors(0x80) == ("bit 0x80",)
    assert model.hardware_errors(0) == ()


def test_baud_rates_have_codes():
    assert servo_model("XM430-W350").baud_code(1_000_000) == 3
    assert servo_model("AX-12A").baud_code(1_000_000) == 1
    with pytest.raises(ValueError, match="57600"):
        servo_model("XM430-W350").baud_code(12345)


def test_unknown_models_are_answered_with_those_there_are():
    with pytest.raises(ValueError, match="XL430-W250"):
        servo_model("SG90")
    with pytest.raises(ValueError, match=r"1020 \(XM430-W350\)"):
        servo_model_by_number(4711)
