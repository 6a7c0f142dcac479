"""Where a flat curve lies: an origin and two directions at right angles."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from splinearm.arrays import ArrayInput, FloatArray, frozen_array

_SQUARE = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """An origin and two unit directions at right angles, in the plane or in space.

    Directions of any length may be given; they are made unit.
    """

    origin: FloatArray
    """Origin, shape (dim,)."""
    x: FloatArray
    """First direction, shape (dim,)."""
    y: FloatArray
    """Second direction, shape (dim,)."""

    def __post_init__(self) -> None:
        origin = frozen_array(self.origin, (None,), "origin")
        if len(origin) < 2:
            raise ValueError(f"origin: want at least two coordinates, got {origin.tolist()}")
        x, y = (
            _unit(frozen_array(values, origin.shape, name), name)
            for values, name in ((self.x, "x"), (self.y, "y"))
        )
        if abs(float(x @ y)) > _SQUARE:
            raise ValueError(
                f"y: want it at a right angle to x = {x.tolist()}, got {y.tolist()}, whose cosine "
                f"with it is {float(x @ y)}"
            )
        y = _unit(y - (x @ y) * x, "y")
        for name, array in (("origin", origin), ("x", x), ("y", y)):
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    @classmethod
    def turned(cls, origin: ArrayInput = (0.0, 0.0), angle: float = 0.0) -> Self:
        """Give the plane of two coordinates, its directions turned by an angle, rad."""
        c, s = float(np.cos(angle)), float(np.sin(angle))
        return cls(frozen_array(origin, (2,), "origin"), np.array([c, s]), np.array([-s, c]))

    @classmethod
    def facing(cls, origin: ArrayInput, normal: ArrayInput, x: ArrayInput | None = None) -> Self:
        """Give a plane in space from its normal, which x and y turn about as a right-hand screw.

        Args:
            origin: Origin, shape (3,).
            normal: The normal, of any length, shape (3,).
            x: What the first direction shall be, but for its share along the normal, shape (3,);
                None: some direction.

        Raises:
            ValueError: If the normal is zero, or x is along it.
        """
        n = _unit(frozen_array(normal, (3,), "normal"), "normal")
        some = np.eye(3)[int(np.argmin(np.abs(n)))] if x is None else frozen_array(x, (3,), "x")
        across = some - (some @ n) * n
        if not np.linalg.norm(across) > _SQUARE * np.linalg.norm(some):
            raise ValueError(f"x: want it across the normal {n.tolist()}, got {some.tolist()}")
        first = _unit(across, "x")
        return cls(frozen_array(origin, (3,), "origin"), first, np.cross(n, first))

    def points(self, xy: ArrayInput) -> FloatArray:
        """Give the points with coordinates x, y in the plane: (..., 2) to (..., dim)."""
        array = np.asarray(xy, dtype=np.float64)
        placed: FloatArray = self.origin + array[..., :1] * self.x + array[..., 1:] * self.y
        return placed


def _unit(vector: FloatArray, name: str) -> FloatArray:
    largest = float(np.abs(vector).max())
    if not largest > 0.0:
        raise ValueError(f"{name}: want a direction, got {vector.tolist()}")
    scaled = vector / largest
    unit: FloatArray = scaled / np.linalg.norm(scaled)
    return unit
