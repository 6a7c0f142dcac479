"""Denavit-Hartenberg parameters in both conventions, stated and never guessed."""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind

from . import space
from .link import Inertia, Link


class DHConvention(Enum):
    """In which order a row of a Denavit-Hartenberg table is carried out."""

    STANDARD = "standard"
    """Rz(theta) Tz(d) Tx(a) Rx(alpha): the joint acts at the near end of its link."""
    # Spong, Hutchinson, Vidyasagar, Robot Modeling and Control, 2006, eq. 3.10

    MODIFIED = "modified"
    """Rx(alpha) Tx(a) Rz(theta) Tz(d): the joint acts at the origin of its own link's frame."""
    # Craig, Introduction to Robotics, 3rd ed. 2005, eq. 3.6; alpha and a are those of row i - 1


@dataclass(frozen=True, slots=True, eq=False)
class DHLink:
    """A row of a Denavit-Hartenberg table.

    The joint position q is added to ``theta`` when the joint turns and to ``d`` when it slides.
    In the modified convention ``a`` and ``alpha`` lead from the previous joint to this one.
    """

    name: str
    """Name of the joint."""
    a: float
    """Length along x, m."""
    alpha: float
    """Twist about x, rad."""
    d: float
    """Offset along z, m."""
    theta: float
    """Turn about z at q = 0, rad."""
    kind: JointKind = JointKind.REVOLUTE
    """Whether the joint turns or slides."""

    def __post_init__(self) -> None:
        for name in ("a", "alpha", "d", "theta"):
            value = getattr(self, name)
            if not np.isfinite(value):
                raise ValueError(f"link {self.name!r}: {name}: want a finite number, got {value}")

    def matrix(self, q: float, convention: DHConvention) -> FloatArray:
        """Give the pose of this row's frame in the one before, shape (4, 4), at ``q``."""
        return self.link(convention).matrix(q)

    def link(self, convention: DHConvention, inertia: Inertia | None = None) -> Link:
        """Give the same link by its frames.

        The turn by theta and the slide by d share their axis with the joint's motion, so they may
        stand on either side of it: here they follow it.
        """
        along_z = space.rotation_z(self.theta) @ space.translation((0.0, 0.0, self.d))
        along_x = space.translation((self.a, 0.0, 0.0)) @ space.rotation_x(self.alpha)
        if convention is DHConvention.STANDARD:
            return Link(self.name, self.kind, np.eye(4), along_z @ along_x, inertia)
        return Link(self.name, self.kind, along_x, along_z, inertia)
