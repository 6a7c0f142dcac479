"""The torques that move an arm and the motion that torques cause."""

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, field

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array

from .arm import Arm
from .body import moved
from .forward import answer
from .link import Inertia
from .mover import Mover, Single, load_mover, single


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Drives:
    """What motors and gears add to an arm's dynamics, one number a joint."""

    rotor_inertia: FloatArray | None = None
    """Inertia of each motor's rotor about its own axis, shape (n,), kg m2; None: none."""
    gear: FloatArray | None = None
    """Turns of the motor a turn of the joint, shape (n,) (rad/m where it slides); None: 1."""
    viscous: FloatArray | None = None
    """Friction in proportion to the joint's speed, shape (n,), N m s/rad (N s/m); None: none."""
    coulomb: FloatArray | None = None
    """Friction against the joint's motion whatever its speed, shape (n,), N m (N); None: none."""

    def __post_init__(self) -> None:
        for name in ("rotor_inertia", "gear", "viscous", "coulomb"):
            if getattr(self, name) is None:
                continue
            value = frozen_array(getattr(self, name), (None,), name)
            if name != "gear" and (value < 0.0).any():
                raise ValueError(f"{name}: want numbers of at least zero, got {value.tolist()}")
            object.__setattr__(self, name, value)

    def numbers(self, n: int) -> FloatArray:
        """Give reflected inertia, viscous and Coulomb friction of n joints, shape (n, 3).

        Raises:
            ValueError: If there are not n of each.
        """
        columns = []
        for name, usual in (
            ("rotor_inertia", 0.0),
            ("gear", 1.0),
            ("viscous", 0.0),
            ("coulomb", 0.0),
        ):
            value = getattr(self, name)
            value = np.full(n, usual) if value is None else value
            if value.shape != (n,):
                raise ValueError(f"{name}: want {n} numbers, one a joint, got {len(value)}")
            columns.append(value)
        rotor_inertia, gear, viscous, coulomb = columns
        # the rotor turns `gear` times as fast, and its torque counts `gear` times at the joint:
        # Siciliano et al., Robotics: Modelling, Planning and Control, 2009, section 7.1.1; the
        # turning of the rotor with its link is neglected
        return np.stack([gear**2 * rotor_inertia, viscous, coulomb], axis=1)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Dynamics:
    """The rigid-body dynamics of an arm, with what it carries and what its drives add.

    Making one loads compiled kernels: about 0.2 s, some seconds the first time on a machine; no
    later call waits. Every method takes one state or many: joint arrays of shape (..., n), whose
    leading axes are broadcast against each other. Torques are N m, N where a joint slides.
    """

    arm: Arm
    """The arm; each of its links must have an inertia."""
    _: KW_ONLY
    gravity: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, -9.81]))
    """Acceleration of free fall in the world, shape (3,), m/s2."""
    payload: Inertia | None = None
    """What the arm carries, in the tool frame; None: nothing."""
    drives: Drives | None = None
    """What motors and gears add; None: nothing."""
    _model: FloatArray = field(init=False)
    _mover: Mover = field(init=False)
    _single: Single = field(init=False)

    def __post_init__(self) -> None:
        gravity = frozen_array(self.gravity, (3,), "gravity")
        object.__setattr__(self, "gravity", gravity)
        # laid out as `dynamics_kernel` says
        model = np.zeros((self.arm.n + 1, 26))
        model[:, :13] = self.arm.numbers
        model[:-1, 13:23] = _bodies(self.arm, self.payload)
        model[:-1, 23:] = (self.drives or Drives()).numbers(self.arm.n)
        model[-1, 13:16] = self.arm.T_world_base[:3, :3].T @ gravity
        object.__setattr__(self, "_model", model)
        object.__setattr__(self, "_mover", load_mover())
        object.__setattr__(self, "_single", single(model))

    def __repr__(self) -> str:
        return f"Dynamics({self.arm!r}, payload {self.payload.mass if self.payload else 0.0:g} kg)"

    def inverse(
        self, q: ArrayInput, qd: ArrayInput, qdd: ArrayInput, *, out: FloatArray | None = None
    ) -> FloatArray:
        """Give the torques that a motion needs, shape (..., n): inverse dynamics.

        Coulomb friction acts against the motion; a joint at rest has none.

        Args:
            q: Positions, shape (..., n), rad (m where a joint slides).
            qd: Velocities, shape (..., n), rad/s (m/s).
            qdd: Accelerations, shape (..., n), rad/s2 (m/s2).
            out: A contiguous array of float64 of the answer's shape to write it to; None: a new
                one.

        Raises:
            TypeError: If ``out`` is not an array of float64.
            ValueError: If an array's last axis is not n long, a number is not finite, the leading
                axes do not fit each other, or ``out`` does not fit.
        """
        tau = np.empty(len(self.arm.links)) if out is None else out
        if self._single.inverse(q, qd, qdd, tau):
            return tau
        # many states, or not as the kernel takes them: converted, or refused
        shape, rows = self._rows(q=q, qd=qd, qdd=qdd)
        tau = answer(out, shape)
        self._mover.inverse_batch(self._model, *rows, tau.reshape(-1, self.arm.n))
        return tau

    def bare_inverse(self) -> Callable[[FloatArray, FloatArray, FloatArray, FloatArray], bool]:
        """Give inverse dynamics as ``function(q, qd, qdd, out) -> done``, for the tightest loops.

        It takes four contiguous arrays of float64, shape (n,), and answers False, having written
        nothing of use, where one is anything else or a number is not finite.
        """
        return self._single.inverse

    def gravity_torque(self, q: ArrayInput) -> FloatArray:
        """Give the torques that hold the arm at rest, shape (..., n).

        Args:
            q: Positions, shape (..., n), rad (m where a joint slides).

        Raises:
            ValueError: If the last axis is not n long or a number is not finite.
        """
        still = np.zeros(self.arm.n)
        return self.inverse(q, still, still)

    def mass_matrix(self, q: ArrayInput) -> FloatArray:
        """Give the inertia that the joints feel, M(q), shape (..., n, n), symmetric.

        The reflected inertia of the rotors stands on its diagonal.

        Args:
            q: Positions, shape (..., n), rad (m where a joint slides).

        Raises:
            ValueError: If the last axis is not n long or a number is not finite.
        """
        n = self.arm.n
        M = np.empty((n, n))
        if self._single.mass_matrix(q, M):
            return M
        shape, rows = self._rows(q=q)
        M = np.empty((len(rows[0]), n, n))
        self._mover.mass_matrix_batch(self._model, *rows, M)
        return M.reshape(*shape, n)

    def coriolis_matrix(self, q: ArrayInput, qd: ArrayInput) -> FloatArray:
        """Give the matrix C(q, qd) of Coriolis and centrifugal torques, shape (..., n, n).

        ``C @ qd`` is the torque. Of the many such matrices this is the one of Christoffel symbols,
        for which dM/dt - 2 C is skew-symmetric.

        Args:
            q: Positions, shape (..., n), rad (m where a joint slides).
            qd: Velocities, shape (..., n), rad/s (m/s).

        Raises:
            ValueError: As in `inverse`.
        """
        n = self.arm.n
        C = np.empty((n, n))
        if self._single.coriolis(q, qd, C):
            return C
        shape, rows = self._rows(q=q, qd=qd)
        C = np.empty((len(rows[0]), n, n))
        self._mover.coriolis_batch(self._model, *rows, C)
        return C.reshape(*shape, n)

    def coriolis_torque(self, q: ArrayInput, qd: ArrayInput) -> FloatArray:
        """Give the Coriolis and centrifugal torques C(q, qd) qd, shape (..., n).

        Args:
            q: Positions, shape (..., n), rad (m where a joint slides).
            qd: Velocities, shape (..., n), rad/s (m/s).

        Raises:
            ValueError: As in `inverse`.
        """
        shape, rows = self._rows(q=q, qd=qd)
        tau = np.empty(rows[0].shape)
        bare = self._model.copy()
        bare[:-1, 23:], bare[-1, 13:16] = 0.0, 0.0
        self._mover.inverse_batch(bare, *rows, np.zeros_like(tau), tau)
        return tau.reshape(shape)

    def forward(self, q: ArrayInput, qd: ArrayInput, tau: ArrayInput) -> FloatArray:
        """Give the accelerations that torques cause, shape (..., n): forward dynamics.

        Args:
            q: Positions, shape (..., n), rad (m where a joint slides).
            qd: Velocities, shape (..., n), rad/s (m/s).
            tau: Torques at the joints, before friction, shape (..., n), N m (N).

        Raises:
            ValueError: As in `inverse`, or if a joint moves nothing that has an inertia.
        """
        qdd = np.empty(self.arm.n)
        if self._single.forward(q, qd, tau, qdd):
            return qdd
        shape, rows = self._rows(q=q, qd=qd, tau=tau)
        qdd = np.empty(rows[0].shape)
        if not self._mover.forward_batch(self._model, *rows, qdd):
            raise ValueError(
                f"arm {self.arm.name!r}: a joint moves nothing that has an inertia, so no finite "
                "acceleration follows; give its links, its payload or its rotors some"
            )
        return qdd.reshape(shape)

    def _rows(self, **states: ArrayInput) -> tuple[tuple[int, ...], list[FloatArray]]:
        """Give the common shape of joint arrays, and each as contiguous rows, shape (m, n)."""
        checked = [self.arm.joint_array(value, name) for name, value in states.items()]
        alike = checked
        if len({array.shape for array in checked}) > 1:
            try:
                alike = list(np.broadcast_arrays(*checked))
            except ValueError as error:
                came = ", ".join(f"{name} {np.shape(value)}" for name, value in states.items())
                raise ValueError(f"want shapes that fit each other, got {came}") from error
        rows = [np.ascontiguousarray(array.reshape(-1, self.arm.n)) for array in alike]
        return alike[0].shape, rows


def _bodies(arm: Arm, payload: Inertia | None) -> FloatArray:
    """Give each body in its moved joint frame as the kernels take it, shape (n, 10)."""
    unknown = [link.name for link in arm.links if link.inertia is None]
    if unknown:
        raise ValueError(
            f"arm {arm.name!r}: want an inertia of each link, got none of the links that joints "
            f"{', '.join(unknown)} move"
        )
    numbers = np.zeros((arm.n, 10))
    for k, link in enumerate(arm.links):
        if link.inertia is not None:
            numbers[k] = _numbers(moved(link.inertia, link.T_joint_link))
    if payload is not None:
        numbers[-1] += _numbers(moved(payload, arm.packed.fixed[-1]))
    return numbers


def _numbers(body: Inertia) -> FloatArray:
    """Give mass, first moment and inertia about the frame's origin, shape (10,)."""
    # parallel axes: Siciliano et al., Robotics, 2009, eq. B.60
    c = body.com
    about_origin = body.tensor + body.mass * ((c @ c) * np.eye(3) - np.outer(c, c))
    rows, columns = np.triu_indices(3)
    return np.concatenate(([body.mass], body.mass * c, about_origin[rows, columns]))
