"""An arm: its links from base to flange, its limits, where it stands and what it holds."""

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Literal, Self, TypeAlias

import numpy as np
from numpy import empty

from splinearm.arrays import ArrayInput, FloatArray
from splinearm.joints import JointLimits

from . import chain, forward, space
from .dh import DHConvention, DHLink
from .forward import LOADED, NOT_LOADED
from .link import Inertia, Link
from .packed import pack_kernel

_TABLE_TOLERANCE = 1e-9

Frame: TypeAlias = Literal["base", "tool"]
"""The frame along whose axes a Jacobian is written."""


def _identity() -> FloatArray:
    return np.eye(4)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Arm:
    """A serial arm. All poses it speaks of are in its base frame unless the name says otherwise."""

    name: str
    """Name of the arm."""
    links: tuple[Link, ...]
    """The n links and their joints, base to flange."""
    limits: JointLimits
    """What the joints may do; names and kinds are those of the links."""
    _: KW_ONLY
    T_world_base: FloatArray = field(default_factory=_identity)
    """Where the arm stands in the world, shape (4, 4)."""
    T_base_first: FloatArray = field(default_factory=_identity)
    """Pose of the first link's parent frame (frame 0 of a DH table) in base, shape (4, 4)."""
    T_flange_tool: FloatArray = field(default_factory=_identity)
    """Pose of the tool in the last link's frame, the flange, shape (4, 4)."""
    convention: DHConvention | None = None
    """Convention of the DH table, if the arm has one."""
    dh: tuple[DHLink, ...] | None = None
    """The DH table that the links come from, if they do."""
    _packed: chain.Chain = field(init=False, repr=False)
    _numbers: FloatArray = field(init=False, repr=False)
    _bare: forward.Bare = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "links", tuple(self.links))
        for name in ("T_world_base", "T_base_first", "T_flange_tool"):
            object.__setattr__(self, name, space.frozen_rigid(getattr(self, name), name))
        if not self.links:
            raise ValueError(f"arm {self.name!r}: want at least one link, got none")
        if len(set(self.joint_names)) != self.n:
            raise ValueError(f"arm {self.name!r}: joint names repeat: {list(self.joint_names)}")
        self._check_limits()
        self._check_table()
        packed = chain.pack(self.links, self.T_base_first, self.T_flange_tool)
        object.__setattr__(self, "_packed", packed)
        object.__setattr__(self, "_numbers", pack_kernel(packed))
        object.__setattr__(self, "_bare", NOT_LOADED)

    @classmethod
    def from_dh(  # noqa: PLR0913 - all that an arm file says of its table
        cls,
        name: str,
        dh_links: Sequence[DHLink],
        convention: DHConvention,
        limits: JointLimits,
        *,
        inertias: Sequence[Inertia | None] | None = None,
        T_world_base: ArrayInput | None = None,
        T_base_first: ArrayInput | None = None,
        T_flange_tool: ArrayInput | None = None,
    ) -> Self:
        """Give the arm of a Denavit-Hartenberg table.

        Args:
            name: Name of the arm.
            dh_links: The rows, base to flange.
            convention: How the rows are to be read.
            limits: What the joints may do.
            inertias: Of each link in its DH frame, or None where not known.
            T_world_base: Where the arm stands in the world, shape (4, 4); None: identity.
            T_base_first: Pose of DH frame 0 in base, shape (4, 4); None: identity.
            T_flange_tool: Pose of the tool in the last DH frame, shape (4, 4); None: identity.

        Raises:
            ValueError: If numbers of rows, inertias and limits differ or a transform is not rigid.
        """
        rows = tuple(dh_links)
        known = (None,) * len(rows) if inertias is None else tuple(inertias)
        if len(known) != len(rows):
            raise ValueError(f"inertias: want {len(rows)} of them, one a link, got {len(known)}")
        return cls(
            name,
            tuple(row.link(convention, of) for row, of in zip(rows, known, strict=True)),
            limits,
            T_world_base=_or_identity(T_world_base),
            T_base_first=_or_identity(T_base_first),
            T_flange_tool=_or_identity(T_flange_tool),
            convention=convention,
            dh=rows,
        )

    def __repr__(self) -> str:
        return f"Arm({self.name!r}, joints {', '.join(self.joint_names)})"

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.links)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, base to flange."""
        return tuple(link.name for link in self.links)

    @property
    def packed(self) -> chain.Chain:
        """The arm as packed arrays, for the functions of module chain, which check nothing."""
        return self._packed

    @property
    def numbers(self) -> FloatArray:
        """The arm as the one array that kernels take, shape (n + 1, 13); see module packed."""
        return self._numbers

    def compiled(self) -> Self:
        """Give this arm once the compiled kernels of fk, frames and jacobian are loaded.

        Until then numpy answers, some ten times slower, except to batches of 20 000 joint vectors
        or more and to calls with ``out=``, which load what they need. Loading takes about 0.2 s,
        and some seconds the first time on a machine. It holds for all arms of the process.
        """
        forward.load()
        return self

    def bare(self) -> forward.Bare:
        """Give the kernels of this arm as functions for the tightest loops; see `forward.Bare`."""
        if self._bare is NOT_LOADED:
            object.__setattr__(self, "_bare", forward.bare(self._numbers))
        return self._bare

    def fk(self, q: ArrayInput, *, out: FloatArray | None = None) -> FloatArray:
        """Give the pose of the tool in base, T_base_tool, shape (..., 4, 4).

        Args:
            q: Joint positions, shape (..., n), rad (m where a joint slides). They may lie outside
                the limits.
            out: A contiguous array of float64 of the answer's shape to write it to; None: a new
                one.

        Raises:
            TypeError: If ``out`` is not an array of float64.
            ValueError: If the last axis is not n long, a number is not finite, or ``out`` does
                not fit. What stands in ``out`` is then not to be used.
        """
        T = empty((4, 4)) if out is None else out
        if self._bare.fk(q, T):
            return T
        # not as the kernel takes it, or no kernel yet: converted, or refused
        q = self.joint_array(q)
        return forward.fk(self._packed, self._numbers, self._single(out), q, out)

    def frames(self, q: ArrayInput, *, out: FloatArray | None = None) -> FloatArray:
        """Give the pose of every link frame in base, shape (..., n, 4, 4).

        For an arm from a DH table these are the DH frames 1 to n; the last is the flange.

        Args:
            q: Joint positions, shape (..., n), rad (m where a joint slides).
            out: As in `fk`.

        Raises:
            TypeError: As in `fk`.
            ValueError: As in `fk`.
        """
        return forward.frames(self._packed, self._numbers, self.joint_array(q), out)

    def jacobian(
        self, q: ArrayInput, *, frame: Frame = "base", out: FloatArray | None = None
    ) -> FloatArray:
        """Give the geometric Jacobian of the tool point, shape (..., 6, n).

        Rows: linear velocity (m/s), then angular velocity (rad/s), of the tool against the base
        per rad/s (m/s where a joint slides), along the axes of ``frame``.

        Args:
            q: Joint positions, shape (..., n), rad (m where a joint slides).
            frame: Whose axes: "base" or "tool".
            out: As in `fk`.

        Raises:
            TypeError: As in `fk`.
            ValueError: As in `fk`, or if ``frame`` is neither word.
        """
        if frame == "base":
            J = empty((6, len(self.links))) if out is None else out
            if self._bare.jacobian(q, J):
                return J
        elif frame != "tool":
            raise ValueError(f"frame: want 'base' or 'tool', got {frame!r}")
        q = self.joint_array(q)
        J = forward.jacobian(self._packed, self._numbers, self._single(out), q, out)
        if frame == "tool":
            R_tool_base = self.fk(q)[..., :3, :3].mT
            J[..., :3, :] = R_tool_base @ J[..., :3, :]
            J[..., 3:, :] = R_tool_base @ J[..., 3:, :]
        return J

    def with_tool(self, T_flange_tool: ArrayInput) -> Self:
        """Give the same arm with another tool: its pose in the flange, shape (4, 4)."""
        return replace(self, T_flange_tool=np.asarray(T_flange_tool, dtype=np.float64))

    def joint_array(self, values: ArrayInput, name: str = "q") -> FloatArray:
        """Give one number a joint as an array, shape (..., n), after checking it.

        Args:
            values: What came.
            name: What it is called in the error.

        Raises:
            ValueError: If the last axis is not n long or a number is not real and finite.
        """
        try:
            array = np.asarray(values)
            if array.dtype != np.float64:
                array = array.astype(np.float64, casting="same_kind")
        except (TypeError, ValueError) as error:
            raise ValueError(f"{name}: want an array of numbers, got {values!r}") from error
        if array.ndim == 0 or array.shape[-1] != self.n:
            raise ValueError(
                f"{name}: want shape (..., {self.n}) for the joints of arm {self.name!r}, "
                f"got {array.shape}"
            )
        if not np.isfinite(array).all():
            raise ValueError(f"{name}: want finite numbers, got {array.tolist()}")
        return array

    def _single(self, out: FloatArray | None) -> forward.Bare:
        """Give the kernels of single calls once they are loaded, or wanted because of ``out``."""
        return self._bare if LOADED.single is None and out is None else self.bare()

    def _check_limits(self) -> None:
        if self.limits.names != self.joint_names:
            raise ValueError(
                f"limits: want those of the joints {list(self.joint_names)}, "
                f"got {list(self.limits.names)}"
            )
        for link, kind in zip(self.links, self.limits.kinds, strict=True):
            if link.kind is not kind:
                raise ValueError(
                    f"limits: joint {link.name!r} is {kind.value} there but {link.kind.value} here"
                )

    def _check_table(self) -> None:
        if self.dh is None:
            return
        object.__setattr__(self, "dh", tuple(self.dh))
        if self.convention is None:
            raise ValueError("convention: want the one of the DH table, got None")
        if len(self.dh) != self.n:
            raise ValueError(f"dh: want {self.n} rows, one a link, got {len(self.dh)}")
        for row, link in zip(self.dh, self.links, strict=True):
            of_row = row.link(self.convention)
            for name in ("T_parent_joint", "T_joint_link"):
                error = np.abs(getattr(of_row, name) - getattr(link, name)).max()
                if row.kind is not link.kind or error > _TABLE_TOLERANCE:
                    raise ValueError(f"dh: row {row.name!r} does not describe link {link.name!r}")


def _or_identity(T: ArrayInput | None) -> FloatArray:
    return np.eye(4) if T is None else np.asarray(T, dtype=np.float64)
