"""Zero and wrap point of servos that are no plain leader, and refusals."""

from collections import Counter
from dataclasses import replace
from math import pi

import numpy as np
import pytest
from calibration_scene import MemoryBus, cell_of, mounted, new_shaft, scene_of, spec_of

from splinearm.commissioning.calibration_bench import CalibrationBench, as_calibration
from splinearm.commissioning.calibration_placement import Seen, place
from splinearm.config.calibration_table import Calibration, apply_calibration
from splinearm.drivers.chain import ServoRole, ServoSpec
from splinearm.drivers.scaling import operating_mode
from splinearm.drivers.startup import is_coupled
from splinearm.drivers.turn import unwrapped_zero
from splinearm.errors import CalibrationError, ConfigError, ServoError
from splinearm.units import DEG

XM = "XM430-W350"
TICK = 2.0 * pi / 4096


def pair(seed, coupled):
    """A joint with two servos, both mounted anyhow, facing each other or not."""
    rng = np.random.default_rng(seed)
    low = float(rng.uniform(-170.0, -30.0)) * DEG
    high = low + float(rng.uniform(60.0, 250.0)) * DEG
    settings = {"Secondary(Shadow) ID": 1} if coupled else {}
    registers = {"Homing Offset": int(rng.integers(-1000, 1000)), **settings}
    specs = [
        spec_of(XM),
        spec_of(XM, name="shadow", servo_id=2, role=ServoRole.SHADOW, settings=settings),
    ]
    shafts = [new_shaft(0.5 * (low + high)) for _ in specs]
    servos = [
        mounted(specs[0], rng, shafts[0], **{"Drive Mode": int(rng.integers(2))}),
        mounted(specs[1], rng, shafts[1], **{**registers, "Drive Mode": int(rng.integers(2))}),
    ]
    return scene_of(specs, servos, (low, high), rng, shafts), (low, high), rng


def calibrate(scene, stops):
    """Turn the joint from end to end, and give the specs as calibrated."""
    scene.turn_to(stops[0])
    scene.turn_to(stops[1])
    up = scene.bench.sweep_of("elbow").now
    middle = 0.5 * (stops[0] + stops[1])
    scene.turn_to(middle)
    sign = 1 if scene.bench.sweep_of("elbow").now < up else -1
    count = scene.rest()[1]
    zero = count - sign * middle * scene.bench.model_of("elbow").pulses_per_rad
    placements = scene.bench.place("elbow", zero, sign)
    for placement in placements:
        scene.bench.write(placement)
    own = tuple(map(as_calibration, placements))
    made = Calibration(arm="one", name="default", date=None, servos=own)
    return apply_calibration(scene.cell, made, "file").chain.servos


def powered_off_and_on(scene, q):
    for servo_id, shaft in enumerate(scene.shafts, start=1):
        shaft.angle = float(q)
        scene.bus.servos[servo_id].power_cycle()
    return [scene.bus.servos[servo_id].position for servo_id in (1, 2)]


def test_a_shadow_says_what_its_leader_says_everywhere_or_gets_goals_of_its_own():
    seen = Counter()
    for seed in range(120):
        scene, stops, rng = pair(seed, coupled=True)
        leader, shadow = calibrate(scene, stops)
        together = is_coupled(shadow)
        seen[together, operating_mode(leader)] += 1
        assert scene.bus.servos[2].secondary_id == (1 if together else 255)
        if together:
            assert operating_mode(leader) == operating_mode(shadow)
            assert leader.zero_ticks == shadow.zero_ticks
            if operating_mode(shadow) == 3:
                assert abs(shadow.settings["Homing Offset"]) <= 1024
        for q in (*stops, *rng.uniform(*stops, size=3)):
            first, second = powered_off_and_on(scene, q)
            if together:
                assert abs(first - second) <= 3
            for spec, ticks in ((leader, first), (shadow, second)):
                assert angle_of(spec, ticks, stops) == pytest.approx(q, abs=4 * TICK)
    assert min(seen[True, 3], seen[True, 4], seen[False, 3], seen[False, 4]) > 5


def angle_of(spec, ticks, stops):
    zero = unwrapped_zero(spec, spec.zero_ticks, ticks, *stops)
    return (ticks - zero) / spec.servo_model.pulses_per_rad


def test_a_shadow_with_goals_of_its_own_has_a_zero_of_its_own():
    for seed in range(50):
        scene, stops, rng = pair(seed, coupled=False)
        specs = calibrate(scene, stops)
        for q in rng.uniform(*stops, size=3):
            for spec, ticks in zip(specs, powered_off_and_on(scene, q), strict=True):
                assert angle_of(spec, ticks, stops) == pytest.approx(q, abs=4 * TICK)


def test_a_shadow_that_slips_is_found_out():
    scene, stops, _ = pair(3, coupled=True)
    scene.turn_to(stops[0])
    scene.bus.servos[2].slip(0.2)
    scene.turn_to(stops[1])
    with pytest.raises(CalibrationError, match="does not turn as its leader does"):
        scene.bench.place("elbow", 2048.0, 1)


def test_a_shadow_cannot_be_compared_where_nothing_was_turned():
    scene, _, _ = pair(3, coupled=True)
    scene.bench.poll()
    with pytest.raises(CalibrationError, match="hardly turned"):
        scene.bench.place("elbow", 2048.0, 1)


@pytest.mark.parametrize("model", ["AX-12A", "XL320"])
def test_old_servos_see_part_of_a_turn_and_have_no_other_direction(model):
    seen = Counter()
    for seed in range(60):
        rng = np.random.default_rng(seed)
        spec = spec_of(model)
        low, high = -60.0 * DEG, float(rng.uniform(20.0, 60.0)) * DEG
        shaft = new_shaft(0.0)
        at_zero = int(rng.integers(250, 750))
        servo = mounted(spec, rng, shaft, at_zero=at_zero)
        scene = scene_of([spec], [servo], (low, high), rng, [shaft])
        (calibrated,) = calibrate(scene, (low, high))
        assert abs(calibrated.zero_ticks - at_zero) <= 2
        seen[tuple(sorted(calibrated.settings))] += 1
        for q in (low, high):
            shaft.angle = q
            assert (servo.position - calibrated.zero_ticks) / spec.servo_model.pulses_per_rad == (
                pytest.approx(q, abs=2.5 / spec.servo_model.pulses_per_rad)
            )
    assert set(seen) == {("CCW Angle Limit", "CW Angle Limit")}


def seen_of(model=XM, **changes):
    facts = {
        "spec": spec_of(model),
        "registers": {"Operating Mode": 3, "Homing Offset": 0, "Drive Mode": 0},
        "low": 1000,
        "high": 3000,
        "zero": 2048.0,
        "sign": 1,
        "q_min": -1.5,
        "q_max": 1.4,
    }
    return Seen(**{**facts, **changes})


def test_an_old_servo_that_counts_against_its_joint_is_refused():
    with pytest.raises(CalibrationError, match="no Drive Mode"):
        place(seen_of("AX-12A", registers={}, sign=-1, low=300, high=700, zero=500.0))


def test_an_old_servo_that_was_turned_through_its_gap_is_refused():
    with pytest.raises(CalibrationError, match="does not see; it sees 300 deg"):
        place(seen_of("AX-12A", registers={}, torn=True, low=300, high=700, zero=500.0))


def test_an_old_servo_whose_range_ends_within_the_limits_is_to_be_mounted_anew():
    facts = {"registers": {}, "low": 800, "high": 1000, "zero": 900.0, "q_min": -0.5, "q_max": 1.5}
    with pytest.raises(CalibrationError, match=r"mount its horn anew, \d+ deg from where it is"):
        place(seen_of("AX-12A", **facts))
    with pytest.raises(CalibrationError, match="more than it has: narrow"):
        place(seen_of("AX-12A", **{**facts, "q_min": -3.0, "q_max": 3.0}))


def test_limits_far_from_where_the_joint_was_turned_are_refused_if_turns_could_be_taken_wrongly():
    with pytest.raises(CalibrationError, match="far outside its limits"):
        place(seen_of(low=2048, high=2048 + 2800, q_min=-1.0, q_max=0.5))


def test_limits_beyond_the_travel_are_told():
    notes = place(seen_of(low=1800, high=2300)).notes
    assert [note[:15] for note in notes] == ["its lower limit", "its upper limit"]


def test_an_endless_joint_may_be_turned_as_far_as_one_likes():
    placement = place(seen_of(spec=spec_of(XM, mode=4), high=90_000, q_min=-np.inf, q_max=np.inf))
    assert placement.zero_ticks % 4096 == 2048
    assert "forgotten with the power" in placement.notes[0]


def test_other_bits_of_drive_mode_are_those_of_the_file():
    seen = seen_of(spec=spec_of(XM, settings={"Drive Mode": 4}), sign=-1)
    assert place(seen).settings["Drive Mode"] == 5


def gripper_scene(at_zero, travel):
    rng = np.random.default_rng(1)
    finger = ServoSpec(name="gripper", servo_id=2, model=XM, role=ServoRole.GRIPPER)
    specs, shafts = [spec_of(XM), finger], [new_shaft(0.0), new_shaft(0.0)]
    servos = [
        mounted(spec, rng, shaft, at_zero=at_zero)
        for spec, shaft in zip(specs, shafts, strict=True)
    ]
    bus = MemoryBus(servos, rng, noise=0)
    bench = CalibrationBench(bus, cell_of(specs, -1.0, 1.0), ["gripper"])
    bench.survey()
    for angle in np.linspace(0.0, travel, 12):
        shafts[1].angle = float(angle)
        bench.poll()
    return bench, servos[1], shafts[1]


@pytest.mark.parametrize(("at_zero", "mode"), [(1000, 3), (3900, 4)])
def test_a_gripper_knows_where_it_is_open_and_closed(at_zero, mode):
    bench, servo, _ = gripper_scene(at_zero, 0.7)
    opened = bench.sweep_of("gripper").now
    placement, open_ticks, closed_ticks = bench.place_gripper(opened, opened - 400)
    bench.write(placement)
    assert placement.settings["Operating Mode"] == servo.memory["Operating Mode"] == mode
    assert open_ticks - closed_ticks == 400
    assert (servo.position - open_ticks) % 4096 == 0
    assert servo.memory["Max Position Limit"] == 4095


def test_a_gripper_that_hardly_moves_is_refused():
    bench, _, _ = gripper_scene(1000, 0.7)
    with pytest.raises(CalibrationError, match="open where it is closed"):
        bench.place_gripper(1000.0, 1020.0)


def test_nothing_is_written_to_servos_that_are_right_already():
    bench, _, _ = gripper_scene(1000, 0.7)
    bench.write(bench.place_gripper(1400, 1000)[0])
    assert bench._bus.writes == []


def test_a_joint_that_is_moved_while_it_is_set_is_calibrated_anew():
    scene, stops, _ = pair(5, coupled=False)
    scene.turn_to(stops[0])
    scene.turn_to(stops[1])
    (first, _) = scene.bench.place("elbow", 2048.0, 1)
    wrong = replace(first, shift=first.shift + 100.0)
    with pytest.raises(CalibrationError, match="hold the joint still"):
        scene.bench.write(wrong)


def test_a_moved_cable_may_fail_for_a_moment(monkeypatch):
    scene, _, _ = pair(5, coupled=False)
    scene.bench.poll()
    scene.bus.failing = 6
    scene.bench.poll()
    scene.bench.poll()
    assert scene.bench.sweep_of("elbow").readings == 1
    scene.bench.poll()
    assert scene.bench.sweep_of("elbow").readings == 2
    scene.bus.failing = 10**9
    monkeypatch.setattr("time.monotonic", iter((0.0, 10.0, 12.0)).__next__)
    scene.bench.poll()
    with pytest.raises(TimeoutError):
        scene.bench.poll()


def test_a_joint_that_is_not_there_is_refused():
    with pytest.raises(ConfigError, match="'knee' is not one of elbow"):
        CalibrationBench(None, cell_of([spec_of(XM)], -1.0, 1.0), ["knee"])


def test_a_servo_of_another_model_is_refused_before_anything_is_turned():
    rng = np.random.default_rng(0)
    servo = mounted(spec_of("XM430-W210"), rng, new_shaft(0.0))
    with pytest.raises(ServoError, match="found a XM430-W210"):
        scene_of([spec_of(XM)], [servo], (-1.0, 1.0), rng, [servo.shaft])


def test_where_it_rests_is_never_what_was_heard_before_the_cable_failed():
    scene, _, _ = pair(5, coupled=False)
    scene.turn_to(0.0)
    for shaft in scene.shafts:
        shaft.angle = 0.2
    scene.bus.failing = 3 * 4
    there = scene.rest()[1]
    assert there == pytest.approx(scene.servo.position, abs=1.0)


def test_a_look_writes_nothing():
    scene, _, _ = pair(5, coupled=False)
    assert (scene.bus.writes, scene.bus.group_writes) == ([], 0)
