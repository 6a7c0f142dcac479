"""What keeps an arm from doing what is wished, in words that say what to do instead."""

from dataclasses import dataclass
from enum import Enum

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind
from splinearm.kinematics.arm import Arm
from splinearm.kinematics.singularity import nearest_singularity
from splinearm.units import DEG, MM

SINGULAR = 0.05
"""An arm whose smallest singular value is below this counts as nearly singular."""


class Broken(Enum):
    """Which bound a motion would break."""

    POSITION = "position"
    VELOCITY = "velocity"
    ACCELERATION = "acceleration"
    JERK = "jerk"
    TOOL = "tool"
    REACH = "reach"
    """The tool cannot be there."""
    ABILITY = "ability"
    """The arm has too few joints for it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Hindrance:
    """What keeps an arm from doing what is wished."""

    broken: Broken
    """Which bound it would break otherwise."""
    words: str
    """What a person should know."""
    joint: str | None = None
    """The joint whose bound that is; None: it is not one joint's."""
    share: float = 0.0
    """So fast it goes all the same, as a share of what is wished."""

    @property
    def temporary(self) -> bool:
        """Whether it passes by itself: the arm only comes to speed."""
        return self.broken in (Broken.ACCELERATION, Broken.JERK)


def position(arm: Arm, joint: int, upper: bool, *, tool: bool) -> Hindrance:  # noqa: FBT001
    """Say that a joint is at a limit.

    Args:
        arm: The arm.
        joint: Number of the joint.
        upper: Whether it is the upper limit.
        tool: Whether the tool was to move, not this joint.
    """
    limits = arm.limits
    name, slides = limits.names[joint], limits.kinds[joint] is JointKind.PRISMATIC
    value = float((limits.q_max if upper else limits.q_min)[joint])
    shown = f"{value / MM:.1f} mm" if slides else f"{value / DEG:.1f} deg"
    remedy = "go the other way"
    if tool:
        remedy = f"the tool cannot go on that way; go back, or move {name} by itself"
    side = "upper" if upper else "lower"
    words = f"{name} is at its {side} limit {shown}: {remedy}"
    return Hindrance(broken=Broken.POSITION, words=words, joint=name)


def speed(arm: Arm, q: FloatArray, joint: int, share: float, *, tool: bool) -> Hindrance:
    """Say that a joint would have to be too fast, perhaps for the ``tool``."""
    name = arm.joint_names[joint]
    how = f"at {share:.0%} of the speed" if share >= 0.005 else "slowly"
    words = f"{name} is as fast as it may be in jogging: {how}"
    near = nearest_singularity(arm, q) if tool else None
    if near is not None and near.nearness < SINGULAR:
        words = f"nearly singular, {_opposed(near.opposed)}: {how}"
    return Hindrance(broken=Broken.VELOCITY, words=words, joint=name)


def reach(arm: Arm, q: FloatArray) -> Hindrance:
    """Say that the tool cannot get there."""
    near = nearest_singularity(arm, q)
    joint = " or ".join(near.causes) or "a joint"
    words = (
        f"singular, {_opposed(near.opposed)}: the tool cannot go that way; "
        f"go back, or move {joint} by itself"
    )
    return Hindrance(broken=Broken.REACH, words=words)


def ability(arm: Arm, what: str) -> Hindrance:
    """Say that the arm has too few joints for that."""
    words = f"with its {arm.n} joints this arm cannot {what} here; move a joint by itself"
    return Hindrance(broken=Broken.ABILITY, words=words)


def tool_speed(share: float) -> Hindrance:
    """Say that the tool is as fast as it may be beside a person."""
    words = f"the tool does 250 mm/s, no more beside a person: {share:.0%} of what is wished"
    return Hindrance(broken=Broken.TOOL, words=words)


def passing(broken: Broken, joint: str) -> Hindrance:
    """Say that a joint only comes to speed."""
    return Hindrance(broken=broken, words=f"{joint} comes to speed", joint=joint)


def _opposed(opposed: tuple[str, ...]) -> str:
    if len(opposed) < 2:
        return f"{opposed[0]} hardly moves the tool"
    return f"{', '.join(opposed[:-1])} and {opposed[-1]} undo each other"
