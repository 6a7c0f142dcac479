"""Thresholds of a servo's health, as an arm's file says them."""

from math import isnan

import pytest

from splinearm.config import load_cell

ELBOW = 'joint = "elbow"\nzero_ticks = 2048'


def elbow_with(health: str) -> str:
    return f"{ELBOW}\n[servo.health]\n{health}\n"


def test_a_file_that_says_nothing_leaves_all_to_the_servo(arm_text, written):
    health = load_cell(written(arm_text)).chain.servos[2].health
    assert isnan(health.temperature_stop)
    assert isnan(health.load_warn)


def test_thresholds_stand_in_a_table_of_their_own(arm_text, written, edited):
    said = elbow_with(
        "warn_temperature_degc = 50\nstop_temperature_degc = 60.5\nstop_low_supply_v = 11.1\n"
        "stop_load_percent = 80"
    )
    health = load_cell(written(edited(arm_text, ELBOW, said))).chain.servos[2].health
    assert (health.temperature_warn, health.temperature_stop) == (50.0, 60.5)
    assert health.voltage_low_stop == 11.1
    assert health.load_stop == 0.8
    assert isnan(health.current_stop)


@pytest.mark.parametrize(
    ("said", "key", "remedy"),
    [
        ("stop_current_a = 2.0", "stop_current_a", "which measures a load and no current"),
        ("stop_temperature_degf = 140", "stop_temperature_degf", "degrees Celsius"),
        ("stop_heat = 140", "stop_heat", "is no threshold of XL430-W250"),
        ("stop_temperature_degc = 50\nwarn_temperature_degc = 60", "", "want it below"),
        ("warn_low_supply_v = -1", "warn_low_supply_v", "above 0"),
    ],
)
def test_thresholds_that_make_no_sense_are_refused(said, key, remedy, arm_text, edited, refusal):
    text = edited(arm_text, ELBOW, elbow_with(said))
    refusal(load_cell, text, f"servo[2].health.{key}".removesuffix("."), remedy)
