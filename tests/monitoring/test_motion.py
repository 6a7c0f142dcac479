"""Cycles of a motion as datagrams."""

import json
import socket

import numpy as np
import pytest

from splinearm.control.cycle import Cycle
from splinearm.joints import JointKind, JointSetpoint, JointState
from splinearm.monitoring.motion import MotionDatagrams


def cycle(k, *, measured):
    state = JointState(
        t=0.0,
        q=np.array([0.5, 0.02]),
        qd=np.array([1.0, 0.0]),
        current=np.array([0.25, np.nan]),
    )
    wanted = np.array([np.pi / 4, 0.01])
    return Cycle(
        index=k,
        t=k * 0.01,
        lateness=1e-4,
        setpoint=JointSetpoint(t=k * 0.01, q=wanted, qd=wanted, qdd=wanted),
        state=state if measured else None,
        busy=2e-3,
    )


def test_a_datagram_has_what_was_wanted_and_what_was_measured():
    kinds = (JointKind.REVOLUTE, JointKind.PRISMATIC)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(5.0)
        observe = MotionDatagrams(f"127.0.0.1:{listener.getsockname()[1]}", ("arm", "rail"), kinds)
        observe(cycle(0, measured=True))
        observe(cycle(7, measured=False))
        observe.close()
        first, second = (json.loads(listener.recv(65536)) for _ in range(2))
    assert observe.unsent == 0
    assert first["joints"]["arm"] == {
        "wanted_deg": 45.0,
        "wanted_deg_s": 45.0,
        "measured_deg": pytest.approx(28.6479),
        "measured_deg_s": pytest.approx(57.296),
        "current_a": 0.25,
    }
    assert first["joints"]["rail"]["measured_mm"] == 20.0
    assert "current_a" not in first["joints"]["rail"]
    assert set(second["joints"]["arm"]) == {"wanted_deg", "wanted_deg_s"}
    assert second["timestamp"] - first["timestamp"] == pytest.approx(0.07, abs=2e-6)
    assert (second["motion_t_s"], second["lateness_ms"], second["busy_ms"]) == (0.07, 0.1, 2.0)
