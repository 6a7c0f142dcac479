"""Scenes for the tests of this folder: an arm in a time of its own, and what goes wrong with it."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # fault_scene, fault_table and the like

from fault_scene import Scene
from fault_time import TIMED


@pytest.fixture
def scene(monkeypatch):
    """Make scenes; each lets the whole product live in its own time."""

    def make(arm: str = "planar_2r", **options) -> Scene:
        one = Scene(arm, **options)
        for module in TIMED:
            monkeypatch.setattr(f"splinearm.{module}.time", one.clock)
        return one

    return make
