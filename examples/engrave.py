"""Write engrave.ngc beside this file: the letters "sa" and a line below them.

They are made of arcs, lines and splines; ``splinearm run`` carries the program out on an arm.
"""

from pathlib import Path

import numpy as np

from splinearm.curves import BSpline
from splinearm.toolpaths.action import Action, ArcFeed, Feed, Pause, Rapid, Spindle, SplineFeed
from splinearm.toolpaths.gcode_check import write_checked
from splinearm.toolpaths.gcode_dialect import dialect_of

CLEAR, DEPTH = 3e-3, -0.3e-3
FEED, PLUNGE = 10e-3, 4e-3
BLEND = 0.05e-3
KNOTS = np.repeat([0.0, 1.0], 4)

# an s of two cubic Beziers, and the line below, in mm
S = [
    [(14, 16), (10, 21), (1, 19), (5, 13.5)],
    [(5, 13.5), (9, 8), (15, 10), (13.5, 6)],
    [(13.5, 6), (12, 2), (4, 2), (2, 6)],
]
WAVE = [
    [(0, -3), (10, 2), (20, -8), (30, -3)],
    [(30, -3), (33, -1.5), (36, -1.5), (38, -3)],
]


class Pen:
    """Draws actions one after the other."""

    def __init__(self) -> None:
        self.actions: list[Action] = [Spindle(speed=800.0)]
        self.at = np.array([0.0, 0.0, CLEAR])

    def begin(self, x: float, y: float) -> None:
        """Go over a place and down, from mm."""
        if len(self.actions) > 1:
            self._go(Rapid, self.at[0], self.at[1], CLEAR)
        self._go(Rapid, x * 1e-3, y * 1e-3, CLEAR)
        self._go(Feed, x * 1e-3, y * 1e-3, DEPTH, feed=PLUNGE, blend=BLEND)

    def line(self, x: float, y: float) -> None:
        """Cut straight, to mm."""
        self._go(Feed, x * 1e-3, y * 1e-3, DEPTH, feed=FEED, blend=BLEND)

    def arc(self, x: float, y: float, turn: float) -> None:
        """Cut around a centre in mm."""
        centre = np.array([x * 1e-3, y * 1e-3, DEPTH])
        arm = self.at - centre
        cos, sin = np.cos(turn), np.sin(turn)
        end = centre + np.array([cos * arm[0] - sin * arm[1], sin * arm[0] + cos * arm[1], 0.0])
        self.actions.append(
            ArcFeed(
                start=self.at, end=end, centre=centre, axis=2, turn=turn, feed=FEED, blend=BLEND
            )
        )
        self.at = end

    def bezier(self, points: list[tuple[float, float]]) -> None:
        """Cut along a cubic, in mm."""
        places = np.column_stack((np.array(points) * 1e-3, np.full(4, DEPTH)))
        self.actions.append(
            SplineFeed(
                start=places[0],
                end=places[-1],
                feed=FEED,
                blend=BLEND,
                curve=BSpline(KNOTS, places, 3),
            )
        )
        self.at = places[-1]

    def end(self) -> None:
        """Go up and switch off."""
        self._go(Rapid, self.at[0], self.at[1], CLEAR)
        self.actions += [Spindle(speed=0.0), Pause(code="M2")]

    def _go(self, kind: type, x: float, y: float, z: float, **words: float) -> None:
        end = np.array([x, y, z])
        if np.abs(end - self.at).max() > 0.0:
            self.actions.append(kind(start=self.at, end=end, **words))
        self.at = end


def actions() -> list[Action]:
    """Give what the program does."""
    pen = Pen()
    pen.begin(*S[0][0])
    for points in S:
        pen.bezier(points)
    pen.begin(32, 10)
    pen.arc(26, 10, 2.0 * np.pi)
    pen.begin(32, 16)
    pen.line(32, 7)
    pen.arc(35, 7, 0.5 * np.pi)
    pen.line(37, 4)
    pen.begin(*WAVE[0][0])
    for points in WAVE:
        pen.bezier(points)
    pen.end()
    return pen.actions


if __name__ == "__main__":
    text = write_checked(actions(), dialect_of("linuxcnc"), "letters: arcs, lines, splines")
    Path(__file__).with_suffix(".ngc").write_text(text, encoding="utf-8")
