"""Which bytes are read of a model, and what they mean, over random control tables."""

import numpy as np
import pytest

from splinearm.drivers.ability import HARDWARE_ERROR
from splinearm.drivers.model import servo_models
from splinearm.monitoring.block import TORQUE, VOLTAGE, MotionBlock, slow_blocks, slow_values
from splinearm.units import RPM

OLD = ("AX-12A", "XL320")  # speed and load are ten bits and a direction


def control_tables(model, count=15):
    """Random bytes where the registers of a model are."""
    rng = np.random.default_rng(model.number)
    for _ in range(count):
        yield rng.integers(0, 256, model.table.size, dtype=np.uint8).tobytes()


def said(model, image, name):
    register = model.table[name]
    return register.decode(image[register.address : register.end])


@pytest.fixture(params=servo_models(), ids=lambda model: model.name)
def model(request):
    return request.param


def test_a_motion_is_what_the_registers_say(model):
    motion = MotionBlock(model)
    block = motion.block
    speed, load = (
        ("Present Speed", "Present Load")
        if model.name in OLD
        else ("Present Velocity", "Present Current" if model.has_current else "Present Load")
    )
    for image in control_tables(model):
        seen = motion.read(image[block.address : block.address + block.length])
        assert seen.ticks == said(model, image, "Present Position")
        raw = {name: said(model, image, name) for name in (speed, load)}
        if model.name in OLD:
            raw = {k: (-1 if v & 0x400 else 1) * (v & 0x3FF) for k, v in raw.items()}
        assert seen.velocity == pytest.approx(raw[speed] * model.table[speed].scale * RPM)
        if model.has_current:
            assert seen.current == pytest.approx(raw[load] * model.table[load].scale * 1e-3)
            assert np.isnan(seen.load)
        else:
            assert seen.load == pytest.approx(raw[load] * 1e-3)
            assert np.isnan(seen.current)
        assert seen.moving is bool(said(model, image, "Moving") & 0xFF)


def test_what_changes_slowly_is_what_the_registers_say(model):
    for image in control_tables(model):
        found = {}
        for block in slow_blocks(model):
            data = image[block.address : block.address + block.length]
            found |= slow_values(model, block, data)
        assert found["Present Temperature"] == said(model, image, "Present Temperature")
        supply = "Present Voltage" if model.name in OLD else "Present Input Voltage"
        assert found[VOLTAGE] == said(model, image, supply)
        on = said(model, image, "Torque Enable") != 0
        if "Torque Limit" in model.table:
            on = on and said(model, image, "Torque Limit") != 0
        assert found[TORQUE] == on
        if HARDWARE_ERROR in model.table:
            assert found[HARDWARE_ERROR] == said(model, image, HARDWARE_ERROR)


def test_the_motion_of_a_servo_is_one_short_read_and_the_rest_two_at_most(model):
    assert MotionBlock(model).block.length <= 20
    assert len(slow_blocks(model)) <= 2


def test_nothing_is_read_of_indirect_data(model):
    for block in (MotionBlock(model).block, *slow_blocks(model)):
        read = range(block.address, block.address + block.length)
        for register in model.table.registers:
            if register.name.startswith("Indirect"):
                assert register.address not in read
