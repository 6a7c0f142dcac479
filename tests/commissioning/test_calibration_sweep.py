"""A thousand joints, mounted anyhow, turned by hand, calibrated: every angle is right."""

import re
from collections import Counter
from math import tau

import numpy as np
import pytest
from calibration_scene import mounted, new_shaft, scene_of, spec_of

from splinearm.commissioning.calibration_bench import as_calibration
from splinearm.commissioning.calibration_zero import zero_by_ends, zero_by_pose
from splinearm.config.calibration_table import Calibration, apply_calibration
from splinearm.drivers.model import servo_model
from splinearm.drivers.scaling import ONE_TURN_MODE, JointScale, operating_mode
from splinearm.drivers.turn import fold, unwrapped_zero
from splinearm.errors import CalibrationError, ServoError
from splinearm.units import DEG

TICKS = 2.5
"""How far an angle may be off: a tick's trembling at both ends of the travel (of a pose two dozen
readings are taken, which leaves less), and half a tick each for the rounding of the reading then,
of zero, and of the reading now. 2.5 ticks are 0.22 deg."""


def joint(seed, model="XM430-W350"):
    """One case: a scene, the stops of its joint, and how zero is to be found."""
    rng = np.random.default_rng(seed)
    modes = [mode for mode in (3, 4, 5) if mode in servo_model(model).modes]
    spec = spec_of(model, mode=int(rng.choice([3, *modes])))
    by = ("pose", "ends")[int(rng.integers(2))]
    low = float(rng.uniform(-300.0, 0.0)) * DEG
    span = rng.uniform(40.0, 400.0) if rng.random() < 0.9 else rng.uniform(356.0, 364.0)
    high = low + float(span) * DEG
    shy = float(rng.uniform(0.0, 8.0)) * DEG if by == "pose" else 0.0
    shaft = new_shaft(float(rng.uniform(low, high)))
    registers = {
        "Drive Mode": int(rng.integers(2)),
        "Operating Mode": int(rng.choice(modes)),
        "Homing Offset": int(rng.choice([0, rng.integers(-1024, 1025), rng.integers(-9999, 9999)])),
    }
    servo = mounted(spec, rng, shaft, **registers)
    scene = scene_of([spec], [servo], (low + shy, high - shy), rng, [shaft])
    return scene, (low, high), by, rng


def calibrate(scene, stops, by, rng):
    """Do what a person does, and give the servo's spec as calibrated."""
    bench = scene.bench
    for q in (stops[0], stops[1]) if rng.integers(2) else (stops[1], stops[0]):
        scene.turn_to(q)
    before, here = bench.sweep_of("elbow").now, scene.shafts[0].angle
    away = (20.0 if here < sum(stops) / 2.0 else -20.0) * DEG
    scene.turn_to(here + away)
    sign = 1 if (bench.sweep_of("elbow").now - before) * away > 0.0 else -1
    turned = bench.turned("elbow", sign)
    if by == "ends":
        zero = zero_by_ends(turned)
    else:
        q = float(rng.uniform(*stops))
        scene.turn_to(q)
        zero = zero_by_pose(scene.rest()[1], q, sign, turned.model)
    (placement,) = bench.place("elbow", zero, sign)
    bench.write(placement)
    calibration = Calibration(
        arm="one", name="default", date=None, servos=(as_calibration(placement, by),)
    )
    return apply_calibration(scene.cell, calibration, "file").chain.servos[0], placement


def angle_of(spec, ticks, zero):
    return (ticks - zero) / spec.servo_model.pulses_per_rad


def beyond(q, q_min, q_max):
    return max(q_min - q, q - q_max, 0.0)


def check_angles(scene, spec, stops, rng):
    """The joint says where it is, all over its travel: as it is, and after a loss of power."""
    servo, (shaft,) = scene.servo, scene.shafts
    limits = scene.cell.arm.limits
    q_min, q_max = float(limits.q_min[0]), float(limits.q_max[0])
    asked = 0
    places = np.concatenate(([q_min, q_max], rng.uniform(*stops, size=4)))
    for start in places:
        shaft.angle = float(start)
        servo.power_cycle()
        ticks = fold(spec, servo.position)
        try:
            zero = unwrapped_zero(spec, spec.zero_ticks, ticks, q_min, q_max)
        except ServoError:
            # nearly a whole turn, and near its ends: it asks to be moved instead of guessing
            aliases = (start - tau, start + tau)
            rival = min(beyond(alias, q_min, q_max) for alias in aliases)
            assert rival - beyond(start, q_min, q_max) < 2.3 * DEG
            asked += 1
            continue
        if operating_mode(spec) == ONE_TURN_MODE:
            servo.forget_turns()  # as when its torque comes on
        for q in (start, *places):
            shaft.angle = float(q)
            off = angle_of(spec, servo.position, zero) - q
            assert abs(off) * spec.servo_model.pulses_per_rad <= TICKS
    return asked


def check_goals(scene, spec):
    """The servo takes every goal within the joint's limits, and its registers are as recorded."""
    limits = scene.cell.arm.limits
    JointScale.of([spec]).to_ticks(np.array([limits.q_min[0]]))
    JointScale.of([spec]).to_ticks(np.array([limits.q_max[0]]))
    for name in ("Drive Mode", "Operating Mode", "Homing Offset"):
        assert scene.servo.memory[name] == spec.settings[name]


def is_refused(seed, model):
    """Whether a travel of one turn, but for the trembling of its ends, counts as more."""
    try:
        calibrate(*joint(seed, model))
    except CalibrationError:
        return True
    return False


def one_case(seed, seen, model="XM430-W350"):
    scene, stops, by, rng = joint(seed, model)
    turn = servo_model(model).pulses
    travel = (stops[1] - stops[0]) * turn / tau
    if travel > turn + 3 or (travel > turn - 3 and is_refused(seed, model)):
        with pytest.raises(CalibrationError, match="more than one turn") as caught:
            calibrate(scene, stops, by, rng)
        said = float(re.search(r"by ([\d.]+) deg", caught.value.reason)[1])
        assert said == pytest.approx(travel * 360 / turn, abs=0.4)
        assert scene.bus.writes == []
        seen["refused"] += 1
        return
    spec, placement = calibrate(scene, stops, by, rng)
    seen["mode", operating_mode(spec)] += 1
    seen["turned"] += placement.turned < 0
    seen["asked"] += check_angles(scene, spec, stops, rng)
    seen["nearly a turn"] += stops[1] - stops[0] > tau - 2.0 * DEG
    check_goals(scene, spec)


@pytest.mark.parametrize("block", range(4))
def test_a_thousand_joints_mounted_anyhow_say_where_they_are(block):
    seen = Counter()
    for seed in range(250 * block, 250 * (block + 1)):
        one_case(seed, seen)
    assert seen["refused"] > 10
    assert seen["turned"] > 60
    assert seen["mode", 3] > 20
    assert seen["mode", 4] > 20
    assert seen["mode", 5] > 20
    assert seen["nearly a turn"] > 2


@pytest.mark.slow
@pytest.mark.parametrize(
    "model", ["XL330-M288", "XL430-W250", "MX-28-2", "XH540-W270", "PH42-020-S300"]
)
def test_joints_of_other_models_do_too(model):
    seen = Counter()
    for seed in range(10_000, 11_000):
        one_case(seed, seen, model)
    assert seen["refused"] > 40


@pytest.mark.slow
def test_ten_thousand_more():
    seen = Counter()
    for seed in range(20_000, 30_000):
        one_case(seed, seen)
    assert seen["refused"] > 400
