"""Even turns from orientation to orientation: chains of slerps, with corners rounded or not."""

from dataclasses import dataclass, field

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array

from . import rotation_table
from .rotation_bspline import shorter
from .turning import Turning, checked_quats, equal_signs

_CRUMB = 1e-9
"""An even turn below this share of the whole is none: the roundings on both sides touch."""


@dataclass(frozen=True, slots=True, eq=False)
class RotationPolyline:
    """Even turns from orientation to orientation, with rounded corners between them.

    Rounded it is C2 and passes by its inner orientations. With half widths of 0 it is a chain of
    slerps: it passes all of them and its angular velocity jumps there; it is then given from
    behind.
    """

    u: FloatArray
    """Parameters of the orientations, rising, shape (k + 1,), at least 2."""
    quats: FloatArray
    """The orientations, unit quaternions w x y z of either sign, shape (k + 1, 4)."""
    half_widths: FloatArray
    """How far before and behind a corner it is rounded, shape (k + 1,), 0 at the ends."""
    _table: FloatArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        quats = equal_signs(checked_quats(self.quats))
        quats.flags.writeable = False
        u = frozen_array(self.u, (len(quats),), "u")
        if len(u) < 2 or (np.diff(u) <= 0.0).any():
            raise ValueError(f"u: want at least 2 rising parameters, got {u.tolist()}")
        widths = frozen_array(self.half_widths, (len(quats),), "half_widths")
        room = np.diff(u) * (1.0 + _CRUMB) - widths[:-1] - widths[1:]
        if (widths < 0.0).any() or widths[0] or widths[-1] or (room < 0.0).any():
            raise ValueError(
                "half_widths: want 0 at the ends and what finds room beside its neighbours inside, "
                f"got {widths.tolist()} for steps {np.diff(u).tolist()}"
            )
        for name, value in (("u", u), ("quats", quats), ("half_widths", widths)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "_table", _table_of(u, quats, widths))

    @property
    def domain(self) -> tuple[float, float]:
        """First and last parameter."""
        return rotation_table.domain_of(self._table)

    @property
    def breaks(self) -> FloatArray:
        """Where rounding begins and ends, and the ends of the domain."""
        return self._table[:, 0].copy()

    def at(self, u: ArrayInput) -> Turning:
        """Give orientations, angular velocities and accelerations.

        Args:
            u: Parameters in the domain, shape (m,).

        Raises:
            CurveError: If one lies outside.
        """
        return rotation_table.sample(self._table, u)

    def into(self, u: float, state: FloatArray) -> None:
        """Write orientation, angular velocity and acceleration at one parameter, for tight loops.

        Arguments and errors are those of ``RotationBSpline.into``.
        """
        rotation_table.sample_into(self._table, u, state)


def _table_of(u: FloatArray, quats: FloatArray, widths: FloatArray) -> FloatArray:
    """Give what samples a chain: turns before and behind each corner, or one between corners."""
    rates = shorter(quats) / np.diff(u)[:, None]
    crumb = _CRUMB * (u[-1] - u[0])
    begins, starts, turns, shares = [], [], [], []
    nothing = np.zeros(3)
    for i in range(len(rates)):
        if widths[i] > 0.0:
            begins.append(u[i] - widths[i])
            starts.append(quats[i])
            turns.append((rates[i - 1], rates[i]))
            shares.append(_corner(widths[i]))
        if u[i + 1] - widths[i + 1] - u[i] - widths[i] > crumb:
            begins.append(u[i] + widths[i])
            starts.append(quats[i])
            turns.append((rates[i], nothing))
            shares.append(np.array(((0.0, 0.0, 0.0, 1.0, widths[i]), (0.0,) * 5)))
    breaks = np.append(begins, u[-1])
    return rotation_table.make(breaks, np.array(starts), np.array(turns), np.array(shares))


def _corner(half_width: float) -> FloatArray:
    """Give by how much it has turned at the rate before a corner, and at that behind it, (2, 5)."""
    # with x from the corner on, x - r and r, where r is the ramp of ``curves.corner``:
    # t^3 / w^2 - t^4 / (2 w^3) for t from the start of the rounding on and w its whole width
    width = 2.0 * half_width
    quartic, cubic = 0.5 / width**3, 1.0 / width**2
    return np.array(((quartic, -cubic, 0.0, 1.0, -half_width), (-quartic, cubic, 0.0, 0.0, 0.0)))
