"""Servos in memory, and backups that need not outlive this computer's power."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # memory_line, setup_scenes, calibration_scene


@pytest.fixture(scope="session", autouse=True)
def _hurried_disk():
    """Hundreds of backups are written here: do not wait for the disk each time."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("os.fsync", lambda _: None)
        yield
