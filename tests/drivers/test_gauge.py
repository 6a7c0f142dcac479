import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.drivers.gauge import MARK_VALUE, Gauge, Measured
from splinearm.drivers.model import servo_model, servo_models

XM, AX = servo_model("XM430-W350"), servo_model("AX-12A")


def block(model, load: int, velocity: int, position: int, *, mark: bytes = b"") -> bytes:
    names = {"Present Current": load, "Present Load": load, "Present Position": position}
    names |= {"Present Velocity": velocity, "Present Speed": velocity}
    gauge = Gauge.of(model)
    return b"".join(r.encode(names[r.name]) for r in gauge.registers) + mark


@pytest.mark.parametrize("model", servo_models(), ids=lambda model: model.name)
def test_every_model_has_one(model):
    gauge = Gauge.of(model)
    assert gauge.length == sum(register.size for register in gauge.registers)
    assert gauge.read(block(model, 3, 2, 1)) == Measured(3.0, 2.0, 1.0)


@pytest.mark.property
@given(
    load=st.integers(-(2**15), 2**15 - 1),
    velocity=st.integers(-(2**31), 2**31 - 1),
    position=st.integers(-(2**31), 2**31 - 1),
)
def test_numpy_reads_the_same_from_blocks_in_a_row(load, velocity, position):
    gauge = Gauge.of(XM, marked=True)
    data = block(XM, load, velocity, position, mark=bytes((MARK_VALUE,)))
    row = b"xx" + data + b"yy" + b"xx" + data + b"yy"
    blocks = np.frombuffer(row, gauge.dtype(len(row) // 2, 2))
    for each in blocks:
        found = Measured(*(float(each[name]) for name in Measured._fields))
        assert found == gauge.read(data) == Measured(load, velocity, position)
        assert each["mark"] == MARK_VALUE


def test_old_models_give_ten_bits_and_a_direction():
    gauge = Gauge.of(AX)
    assert not gauge.plain
    assert gauge.read(block(AX, 0x400 | 250, 0x400 | 7, 512)) == Measured(-250.0, -7.0, 512.0)
    assert gauge.read(block(AX, 250, 7, 512)) == Measured(250.0, 7.0, 512.0)


def test_a_mark_that_is_not_there_tells_that_the_bytes_are_others():
    gauge = Gauge.of(XM, marked=True)
    assert gauge.is_marked_well(block(XM, 0, 0, 0, mark=bytes((MARK_VALUE,))))
    assert not gauge.is_marked_well(bytes(gauge.length))
    assert Gauge.of(XM).is_marked_well(bytes(10))


def test_gauges_that_read_the_same_bytes_alike_are_of_one_kind():
    assert Gauge.of(XM).kind == Gauge.of(servo_model("XL430-W250")).kind
    assert Gauge.of(XM).kind != Gauge.of(XM, marked=True).kind
    assert Gauge.of(XM).kind != Gauge.of(AX).kind
