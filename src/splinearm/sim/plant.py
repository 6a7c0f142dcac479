"""What servos turn: the joints of an arm in MuJoCo, or a horn with nothing on it."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import copysign, inf

import mujoco
import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.kinematics.arm import Arm

from .model import add_duty_motor, build_spec, compile_model
from .motor import Motor, together
from .shaft import TIMESTEP, Shaft

STUCK_DAMPING = 1e6
"""Damping of a joint that is held fast, N m s/rad."""

_MOST_SERVOS = 31  # MuJoCo's actuator groups that can be cut off


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """A servo's motor at a joint."""

    joint: str
    """The joint."""
    motor: Motor
    """The motor."""
    shaft: Shaft
    """Its shaft."""


class ArmPlant:
    """An arm in MuJoCo, each joint driven by one or more servos."""

    def __init__(self, arm: Arm, drives: Sequence[Drive], q_start: FloatArray) -> None:
        """Let the arm stand at ``q_start``, shape (n,), rad, at rest.

        Raises:
            ValueError: If a joint has no servo, or there are more than MuJoCo can cut off.
        """
        if len(drives) > _MOST_SERVOS:
            raise ValueError(f"drives: want at most {_MOST_SERVOS} servos, got {len(drives)}")
        idle = set(arm.joint_names) - {drive.joint for drive in drives}
        if idle:
            raise ValueError(f"drives: no servo moves {', '.join(sorted(idle))}")
        self._drives = tuple(drives)
        self._joints = [arm.joint_names.index(drive.joint) for drive in drives]
        motors = [
            together(drive.motor for drive in drives if drive.joint == name)
            for name in arm.joint_names
        ]
        spec = build_spec(arm, motors, timestep=TIMESTEP)
        for group, drive in enumerate(drives):
            add_duty_motor(spec, f"servo {group}", drive.joint, drive.motor, group)
        self._model = compile_model(spec)
        self._damping = self._model.dof_damping.tolist()
        self._stuck = [False] * len(drives)
        self._data = mujoco.MjData(self._model)
        self.stand(q_start)

    def stand(self, q: ArrayInput) -> None:
        """Let the arm stand somewhere, at rest, as if a hand had put it there, shape (n,), rad."""
        self._data.qpos[:] = frozen_array(q, (self._model.nq,), "q")
        self._data.qvel[:] = 0.0
        mujoco.mj_forward(self._model, self._data)
        self._report()

    @property
    def q(self) -> FloatArray:
        """Where the joints are, shape (n,), rad."""
        return np.array(self._data.qpos)

    @property
    def speed(self) -> float:
        """How fast the quickest joint moves, rad/s."""
        return max(map(abs, self._qd))

    def push(self, torques: ArrayInput | None) -> None:
        """Push the joints from outside from here on, shape (n,), N m; None: no more."""
        pushed = 0.0 if torques is None else frozen_array(torques, self.q.shape, "torques")
        self._data.qfrc_applied[:] = pushed

    def step(self) -> None:
        """Let ``TIMESTEP`` go by."""
        cut_off = 0
        control = self._data.ctrl
        for group, drive in enumerate(self._drives):
            shaft = drive.shaft
            if shaft.stuck is not self._stuck[group]:
                self._catch()
            duty = shaft.duty
            if duty is None:
                cut_off |= 1 << group
            else:
                control[group] = duty
        self._model.opt.disableactuator = cut_off
        mujoco.mj_step(self._model, self._data)
        self._report()

    def _catch(self) -> None:
        """Hold the joints fast whose shafts are stuck, and let the others go."""
        self._stuck = [drive.shaft.stuck for drive in self._drives]
        held = {joint for joint, stuck in zip(self._joints, self._stuck, strict=True) if stuck}
        for joint, damping in enumerate(self._damping):
            self._model.dof_damping[joint] = STUCK_DAMPING if joint in held else damping
            if joint in held:
                self._data.qvel[joint] = 0.0

    def _report(self) -> None:
        """Tell the shafts where they are."""
        q, qd = self._data.qpos.tolist(), self._data.qvel.tolist()
        self._qd: list[float] = qd
        for joint, drive in zip(self._joints, self._drives, strict=True):
            drive.shaft.angle = q[joint]
            drive.shaft.speed = qd[joint]


class FreePlant:
    """A motor with nothing to carry but its own rotor and friction: a gripper's servo."""

    def __init__(self, motor: Motor, shaft: Shaft) -> None:
        self._motor = motor
        self._shaft = shaft
        self.between = (-inf, inf)
        """Angles that the shaft cannot pass, rad: what is between a gripper's fingers, or their
        ends. It stops there without a rebound."""

    @property
    def speed(self) -> float:
        """How fast it turns, rad/s."""
        return abs(self._shaft.speed)

    def step(self) -> None:
        """Let ``TIMESTEP`` go by."""
        motor, shaft = self._motor, self._shaft
        if shaft.stuck:
            shaft.speed = 0.0
            return
        speed = shaft.speed
        if shaft.duty is not None:
            # J dw/dt = stall (duty - w / no_load), implicit in w so that any step is stable
            slope = motor.stall_torque / motor.no_load_speed
            push = motor.armature * speed + TIMESTEP * motor.stall_torque * shaft.duty
            speed = push / (motor.armature + TIMESTEP * slope)
        brake = TIMESTEP * motor.friction / motor.armature
        shaft.speed = copysign(max(abs(speed) - brake, 0.0), speed)
        shaft.angle += TIMESTEP * shaft.speed
        low, high = self.between
        if not low <= shaft.angle <= high:
            shaft.angle = min(max(shaft.angle, low), high)
            shaft.speed = 0.0
