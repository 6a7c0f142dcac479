"""An arm in MuJoCo, moved like any other and stepped by whoever holds it."""

from collections.abc import Sequence
from types import TracebackType
from typing import Self

import mujoco
import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array
from splinearm.joints import JointSetpoint, JointState
from splinearm.kinematics.arm import Arm

from .model import add_servos, build_spec, compile_model
from .motor import Motor

STIFFNESS_TIME = 0.01
"""The servos give their stall torque at an error of what the unloaded motor runs through in this
time, s: 0.05 rad for an XM430-W350."""

HOLD_TOLERANCE = 0.05
"""How far from its goal a joint may be for ``hold`` to keep that goal, rad (m where it slides)."""


class MujocoArm:
    """An arm whose joints are position servos in a MuJoCo simulation; fulfils ``ArmDriver``.

    Its time stands still until ``advance``. A setpoint is held until the next: its position is the
    servo's goal, its velocity is fed forward to the servo's damping and, unless ``feedforward`` is
    off, the torque that the model itself needs for position, velocity and acceleration is fed
    forward too. That inverse dynamics knows every mass exactly, so such an arm follows better than
    one of metal; without it the servos lag and droop as plain position servos do. In either case
    no motor gives more than its torque-speed line.

    The current it reads is that of the line's torque: torque / stall torque times stall current;
    NaN where the stall current is not known.
    """

    def __init__(
        self,
        arm: Arm,
        motors: Sequence[Motor],
        q_start: ArrayInput | None = None,
        *,
        timestep: float = 1e-3,
        feedforward: bool = True,
    ) -> None:
        """Build the simulation; the arm stands still, its motors off, until it is entered.

        Args:
            arm: The arm.
            motors: The motor of each joint.
            q_start: Where it stands, shape (n,), rad; None: joint zero, or the nearest within
                the limits.
            timestep: Time of one step, s.
            feedforward: Whether the model's own inverse dynamics helps the servos.

        Raises:
            ValueError: If sizes do not fit, numbers are not finite, or MuJoCo refuses the model.
            LimitError: If ``q_start`` is outside the limits.
        """
        self._arm = arm
        self._feedforward = feedforward
        self._released = True
        if q_start is None:
            q_start = np.clip(np.zeros(arm.n), arm.limits.q_min, arm.limits.q_max)
        start = frozen_array(q_start, (arm.n,), "q_start")
        arm.limits.check(start)
        gains = _gains(arm, motors, start, timestep)
        spec = build_spec(arm, motors, timestep=timestep)
        add_servos(spec, arm.joint_names, motors, gains)
        self._model = compile_model(spec)
        self._data = mujoco.MjData(self._model)
        self._wanted = mujoco.MjData(self._model)
        self._inputs = self._data.ctrl.reshape(arm.n, 3)
        self._ampere = np.array([_ampere_per_torque(motor) for motor in motors])
        self._data.qpos[:] = start
        mujoco.mj_forward(self._model, self._data)
        self.release()

    @property
    def n(self) -> int:
        """Number of joints."""
        return self._arm.n

    @property
    def now(self) -> float:
        """Time in the simulation, s."""
        return float(self._data.time)

    @property
    def model(self) -> mujoco.MjModel:
        """The MuJoCo model, for viewers."""
        return self._model

    @property
    def data(self) -> mujoco.MjData:
        """The state of the simulation, for viewers."""
        return self._data

    @property
    def torque(self) -> FloatArray:
        """What each motor gives in the present step, shape (n,), N m."""
        return np.array(self._data.qfrc_actuator)

    @property
    def goal(self) -> FloatArray:
        """Where the servos were last told to be, shape (n,), rad."""
        return np.array(self._inputs[:, 0])

    def __enter__(self) -> Self:
        """Hold where the arm stands."""
        self.hold()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Hold, unless the arm was released: what hangs limp is not jerked up."""
        if not self._released:
            self.hold()

    def advance(self, duration: float) -> None:
        """Let the arm live on for at least ``duration`` seconds, in whole steps.

        Raises:
            ValueError: If the duration is negative or not finite.
        """
        if not (np.isfinite(duration) and duration >= 0.0):
            raise ValueError(f"duration: want a finite time of at least zero, got {duration}")
        steps = int(np.ceil(duration / self._model.opt.timestep - 1e-6))
        if steps:
            mujoco.mj_step(self._model, self._data, nstep=steps)

    def read(self) -> JointState:
        """Measure the joints."""
        return JointState(
            t=self.now,
            q=self._data.qpos,
            qd=self._data.qvel,
            current=self.torque * self._ampere,
        )

    def write(self, setpoint: JointSetpoint) -> None:
        """Give the servos a setpoint; motors that were released stay off.

        Raises:
            ValueError: If it is of another number of joints.
        """
        if setpoint.q.shape != (self.n,):
            raise ValueError(f"setpoint: want {self.n} joints, got {setpoint.q.size}")
        self._inputs[:, 0] = setpoint.q
        self._inputs[:, 1] = setpoint.qd
        self._inputs[:, 2] = self._torque_for(setpoint.q, setpoint.qd, setpoint.qdd)

    def hold(self) -> None:
        """Stay where the arm stands, with torque.

        Joints near their goal keep it: made their goal, the place to which they have drooped would
        let them droop once more.
        """
        here, goal, still = np.array(self._data.qpos), self._inputs[:, 0], np.zeros(self.n)
        keeps = (np.abs(goal - here) < HOLD_TOLERANCE) & (not self._released)
        goal = np.where(keeps, goal, here)
        self._released = False
        self._model.opt.disableactuator = 0
        self._inputs[:, 0] = goal
        self._inputs[:, 1] = still
        self._inputs[:, 2] = self._torque_for(goal, still, still)
        mujoco.mj_forward(self._model, self._data)

    def release(self) -> None:
        """Switch the motors off; the arm falls."""
        self._released = True
        self._model.opt.disableactuator = 1
        mujoco.mj_forward(self._model, self._data)

    def _torque_for(self, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """Give the torque that the model needs for a motion, shape (n,), N m."""
        if not self._feedforward:
            return np.zeros(self.n)
        wanted = self._wanted
        wanted.qpos[:], wanted.qvel[:], wanted.qacc[:] = q, qd, qdd
        mujoco.mj_inverse(self._model, wanted)
        # stops and friction are not to be pushed against, so without the constraint forces
        return np.array(wanted.qfrc_inverse + wanted.qfrc_constraint)


def _ampere_per_torque(motor: Motor) -> float:
    return np.nan if motor.stall_current is None else motor.stall_current / motor.stall_torque


def _gains(
    arm: Arm, motors: Sequence[Motor], q: FloatArray, timestep: float
) -> list[tuple[float, float]]:
    """Give stiffness and damping of each servo: critical for the inertia it has at ``q``."""
    model = compile_model(build_spec(arm, motors, timestep=timestep))
    data = mujoco.MjData(model)
    data.qpos[:] = q
    mujoco.mj_forward(model, data)
    inertia = np.zeros((arm.n, arm.n))
    mujoco.mj_fullM(model, data, inertia)
    stiffness = [m.stall_torque / (m.no_load_speed * STIFFNESS_TIME) for m in motors]
    return [
        (kp, 2.0 * float(np.sqrt(kp * own)))
        for kp, own in zip(stiffness, np.diag(inertia), strict=True)
    ]
