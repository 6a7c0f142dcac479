"""How fast a motion under way shall go on: asked from any thread, heard once a cycle."""

from splinearm.trajectories.pace import FASTEST


class PaceRequest:
    """The pace of a motion as a share of the planned one, which may be changed while it runs."""

    def __init__(self, pace: float = 1.0) -> None:
        """Take the pace to begin with.

        Args:
            pace: From 0, which rests on the path, to 1.5; 1 is as planned.

        Raises:
            ValueError: If it is not from 0 to 1.5.
        """
        self.ask(pace)

    @property
    def pace(self) -> float:
        """What is asked for."""
        return 0.0 if self._paused else self._pace

    def ask(self, pace: float) -> None:
        """Ask for a pace; the arm takes it up as soon as its limits allow.

        Raises:
            ValueError: If it is not from 0 to 1.5.
        """
        if not 0.0 <= pace <= FASTEST:
            raise ValueError(f"pace: want a share from 0 to {FASTEST:g} of the plan, got {pace}")
        self._pace = pace
        self._paused = False

    def pause(self) -> None:
        """Slow down along the path and rest there."""
        self._paused = True

    def resume(self) -> None:
        """Go on at the pace that was asked for last."""
        self._paused = False
