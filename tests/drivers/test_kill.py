"""A controller that is killed in the middle of a motion: its servos stop by themselves."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from splinearm.backends import centred
from splinearm.config import load_cell
from splinearm.sim.event import EventKind
from splinearm.sim.trace import Trace
from splinearm.sim.virtual_bus import VirtualBus
from splinearm.units import DEG

pytestmark = pytest.mark.bus

STILL = 0.1
"""Speed below which a joint is at rest, rad/s: it still settles under its load."""
SETTLES = 0.5 * DEG
"""By how much it settles, rad."""

CONTROLLER = """
import sys, time
from contextlib import suppress
import numpy as np
from splinearm.backends import centred
from splinearm.config import load_cell
from splinearm.drivers.dynamixel import DynamixelBus
from splinearm.drivers.servo_arm import ServoArm
from splinearm.errors import BusError
from splinearm.joints import JointSetpoint

cell = load_cell(sys.argv[1])
chain = centred(cell.chain)
bus = DynamixelBus(sys.argv[2], chain.baud)
with ServoArm(chain, cell.arm.joint_names, cell.arm.limits, bus) as arm:
    start, begun = arm.goal, time.monotonic()
    speed = np.full(arm.n, 0.8)
    while True:
        t = time.monotonic() - begun
        with suppress(BusError):  # a busy computer may lose an answer
            arm.read()
        arm.write(JointSetpoint(t=t, q=start + speed * t, qd=speed, qdd=0.0 * speed))
        if t > 0.25:
            print("moving", flush=True)
        time.sleep(0.01)
"""


@pytest.mark.parametrize("transport", ["socket", "pty"])
@pytest.mark.parametrize("name", ["planar_2r", "wx250s"])
def test_every_joint_rests_60_ms_after_the_controller_was_killed(name, transport):
    cell = load_cell(name)
    chain = centred(cell.chain)
    joints = {servo.servo_id for servo in chain.servos if servo.joint is not None}
    with VirtualBus(cell.arm, chain, cell.poses["home"], transport=transport) as bus:
        moved = [servo for servo in bus.all_servos if servo.servo_id in joints]
        command = [sys.executable, "-c", CONTROLLER, name, bus.port]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as controller:
            assert controller.stdout is not None
            assert controller.stdout.readline() == "moving\n"
            with bus.lock:
                for servo in moved:
                    servo.trace = Trace()
            time.sleep(0.05)
            os.kill(controller.pid, signal.SIGKILL)
            time.sleep(0.4)
        for servo in moved:
            with bus.lock:
                trips = [e for e in servo.events if e.kind is EventKind.WATCHDOG_TRIP]
                motion = servo.trace.motion()
            # it was killed after its last packet, 40 ms before the watchdog tripped
            last_packet = trips[-1].time - 0.04
            before, after = motion.angle[motion.t < last_packet], motion.after(last_packet + 0.06)
            assert np.ptp(before) > 0.005
            assert np.abs(after.speed).max() < STILL
            assert np.ptp(after.angle) < SETTLES
            assert servo.torque_on
