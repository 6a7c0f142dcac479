"""The servos that move an arm's joints, sorted by how they get their goals."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Self

from .chain import ServoChain, ServoSpec
from .startup import is_coupled


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Crew:
    """Leaders and shadows of an arm."""

    leaders: tuple[ServoSpec, ...]
    """One servo a joint, in the order of the joints."""
    followers: tuple[ServoSpec, ...]
    """Shadows that are sent goals of their own."""
    coupled: tuple[ServoSpec, ...]
    """Shadows that obey what is sent to their leader's id."""

    @classmethod
    def of(cls, chain: ServoChain, joint_names: Sequence[str]) -> Self:
        """Sort the servos of a chain.

        Raises:
            ValueError: If a joint has no leader.
        """
        shadows = chain.shadows_of(joint_names)
        return cls(
            leaders=chain.leaders_of(joint_names),
            followers=tuple(servo for servo in shadows if not is_coupled(servo)),
            coupled=tuple(servo for servo in shadows if is_coupled(servo)),
        )

    @property
    def targets(self) -> tuple[ServoSpec, ...]:
        """Servos that are sent goals: leaders, then followers."""
        return self.leaders + self.followers

    @property
    def everyone(self) -> tuple[ServoSpec, ...]:
        """All servos: leaders first."""
        return self.leaders + self.followers + self.coupled

    @property
    def joint_index(self) -> list[int]:
        """For each target the number of the joint it moves."""
        return [self._index(servo) for servo in self.targets]

    def leader_of(self, shadow: ServoSpec) -> ServoSpec:
        """Give the leader at the joint of a shadow."""
        return self.leaders[self._index(shadow)]

    @property
    def led(self) -> dict[int, ServoSpec]:
        """By id of each coupled shadow its leader."""
        return {shadow.servo_id: self.leader_of(shadow) for shadow in self.coupled}

    def with_coupled(self, servos: Collection[ServoSpec]) -> list[ServoSpec]:
        """Give servos and the shadows that obey an id among theirs, leaders first."""
        return [
            servo
            for servo in self.everyone
            if servo in servos or (servo in self.coupled and self.leader_of(servo) in servos)
        ]

    def _index(self, servo: ServoSpec) -> int:
        return [leader.joint for leader in self.leaders].index(servo.joint)
