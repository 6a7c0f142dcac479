"""The setpoints that an arm will get if nothing more is wished: its way to rest.

A wish changes them only if all of them, down to rest, still keep every bound. So whatever happens
next, a way to rest that keeps all bounds is always at hand, and a stop is to follow it.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointSetpoint
from splinearm.kinematics.arm import Arm, Frame

from . import hindrance
from .bound import PAST, Bounds, Breach
from .hindrance import Broken, Hindrance
from .ramp import COMMITTED, Ramp
from .steering import Steering

_HALVINGS = 2
"""So often a wish that cannot be fulfilled is halved within a cycle."""
_LEAST = 2.0**-5
"""Slower than this share of what was wished nothing goes: the arm would creep into a singularity,
and hardly come out of it."""
_TINY = 1e-12
_ALL = 0.99
"""A wish of which this much is fulfilled is."""
_ROUNDING, _UNFORESEEN = 4e-3, 0.02
"""Shares of the tool's speed that are left: for rounding and what ``Bounds`` leaves, and for what
it gains while joints turn at the speeds that are known now."""


class Stopway:
    """The setpoints to come.

    Args:
        bounds: What they must keep.
        ramp: How wishes come in.
        q: Where the arm is held, shape (n,), rad or m.
    """

    def __init__(self, bounds: Bounds, ramp: Ramp, q: FloatArray) -> None:
        self._bounds = bounds
        self._arm: Arm = bounds.arm
        self._steering = Steering(bounds.arm)
        self._shares = ramp.weights
        # the last setpoints that were sent, then those to come, shape (m, n)
        self._rows = np.tile(q, (PAST + ramp.weights.size, 1))
        self._pace = 1.0
        self._t = 0.0

    @property
    def rests(self) -> bool:
        """Whether the arm rests and will."""
        return not np.ptp(self._rows[PAST - 1 :], axis=0).any()

    def stand(self) -> None:
        """Stay where the last setpoint has the arm; for one that stands there by now."""
        self._rows[:] = self._rows[PAST - 1]

    def next(self) -> JointSetpoint:
        """Give the next setpoint, which is sent from here on."""
        dt = self._bounds.period
        before, here, after = self._rows[PAST - 1 : PAST + 2]
        self._t += dt
        setpoint = JointSetpoint(
            t=self._t,
            q=here,
            qd=(after - before) / (2.0 * dt),
            qdd=(after - 2.0 * here + before) / dt**2,
        )
        self._rows = np.concatenate((self._rows[1:], self._rows[-1:]))
        return setpoint

    def move_joints(self, way: FloatArray) -> tuple[float, Hindrance | None]:
        """Let the joints go a way more; each stops at its limits.

        Args:
            way: As much as is wished in one cycle, shape (n,), rad or m.

        Returns:
            Which share of it they will go, and what is in the way of more.
        """
        limits, end = self._arm.limits, self._rows[-1]
        inside = np.clip(end + way, limits.q_min, limits.q_max) - end
        cut = np.abs(inside - way) > _TINY
        found: Hindrance | None = None
        if cut.any():
            joint = int(np.argmax(cut))
            found = hindrance.position(self._arm, joint, bool(way[joint] > 0.0), tool=False)
            if not (np.abs(inside) > _TINY).any():
                return 0.0, found

        def moved(share: float) -> FloatArray:
            new: FloatArray = self._rows[PAST:] + self._shares[:, None] * (share * inside)
            return new

        linear = self._arm.jacobian(end)[:3] @ inside
        share, other = self._go(moved, None, self._slowed(linear, _UNFORESEEN))
        return share, other if found is None or share == 0.0 else found

    def move_tool(self, way: FloatArray, frame: Frame) -> tuple[float, Hindrance | None]:
        """Let the tool go a way more, straight and without turning unless that is wished.

        Args:
            way: As much as is wished in one cycle: translation, m, and turn about the tool's point,
                rad, shape (6,).
            frame: Along whose axes: "base" or "tool".

        Returns:
            Which share of it it will go, and what is in the way of more.
        """
        free = self._rows[PAST + COMMITTED :]

        def moved(share: float) -> FloatArray | Broken:
            new = self._steering.steer(free, share * way, self._shares[COMMITTED:], frame)
            if isinstance(new, Broken):
                return new
            return np.concatenate((self._rows[PAST : PAST + COMMITTED], new))

        return self._go(moved, way, self._slowed(way[:3], _ROUNDING))

    def _slowed(self, way: FloatArray, reserve: float) -> float:
        """Give the share of a way of one cycle with which the tool is not too fast."""
        speed = float(np.linalg.norm(way)) / self._bounds.period
        most = (1.0 - reserve) * self._bounds.tool_speed
        return 1.0 if speed <= most else most / speed

    def _go(
        self,
        moved: Callable[[float], FloatArray | Broken],
        way: FloatArray | None,
        most: float,
    ) -> tuple[float, Hindrance | None]:
        """Take the largest share of a wish that keeps every bound, of some."""
        share: float = most * min(1.0, 2.0 * self._pace)
        why: Breach | None = None
        if most < _ALL:
            why = Breach(broken=Broken.TOOL)
        for _ in range(1 + _HALVINGS):
            found = self._try(moved(share))
            if found is None:
                self._pace = share / most
                return share, None if why is None else self._explain(why, way, share)
            why = found if why is None or why.broken is Broken.TOOL else why
            share *= 0.5
            if share < _LEAST * most:
                break
        self._pace = max(share / most, _LEAST)
        return 0.0, None if why is None else self._explain(why, way, 0.0)

    def _try(self, new: FloatArray | Broken) -> Breach | None:
        """Take setpoints to come if they keep every bound; else say which they break."""
        if isinstance(new, Broken):
            return Breach(broken=new)
        rows = np.concatenate((self._rows[:PAST], new))
        breach = self._bounds.breach(rows)
        if breach is None:
            self._rows = rows
        return breach

    def _explain(self, why: Breach, way: FloatArray | None, share: float) -> Hindrance:
        """Say in words what is in the way."""
        arm, q, tool = self._arm, self._rows[-1], way is not None
        match why.broken:
            case Broken.POSITION:
                found = hindrance.position(arm, why.joint, why.upper, tool=tool)
            case Broken.VELOCITY:
                found = hindrance.speed(arm, q, why.joint, share, tool=tool)
            case Broken.TOOL:
                found = hindrance.tool_speed(share)
            case Broken.ABILITY:
                found = hindrance.ability(arm, _named(way))
            case Broken.REACH:
                found = hindrance.reach(arm, q)
            case _:
                found = hindrance.passing(why.broken, arm.joint_names[why.joint])
        return replace(found, share=share)


def _named(way: FloatArray | None) -> str:
    """Name a way of the tool by its largest part."""
    if way is None:
        return "do that"
    part = 3 * int(way[3:].any()) + int(np.argmax(np.abs(way[3:] if way[3:].any() else way[:3])))
    axis = "xyz"[part % 3]
    return f"turn its tool about {axis} alone" if part >= 3 else f"move its tool along {axis}"
