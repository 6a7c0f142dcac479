"""Lines and arcs one after the other, their corners rounded within a distance."""

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, GREY, INK, MM, ORANGE, RED, WIDTH, draw_curve, plane, save, styled

from splinearm.curves.course import Course
from splinearm.curves.segment import Arc, Line

A, B, C, D = (np.array(p) * MM for p in ((0, 0, 0), (50, 0, 0), (90, 40, 0), (40, 40, 0)))
VIA = np.array((78, 12, 0)) * MM
BLEND = 15 * MM


@styled
def draw() -> Figure:
    """Draw the way in the plane and its curvature."""
    figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    segments = (Line(A, B), Arc.through(B, VIA, C), Line(C, D))
    s = np.concatenate(([0.0], np.cumsum([segment.length for segment in segments])))
    course = Course(segments, s, np.array([0.0, BLEND, BLEND, 0.0]))
    for segment in segments:
        draw_curve(left, segment.at(np.linspace(0.0, 1.0, 40))[:, :2], color=GREY, linewidth=0.9)
    at = np.linspace(*course.domain, 400)
    first, second = course.at(at, 1), course.at(at, 2)
    speed = np.linalg.norm(first, axis=1)
    bend = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / speed**3
    rounded = np.zeros(len(at), dtype=np.bool)
    for i, colour in ((1, RED), (2, ORANGE)):
        here = np.abs(at - s[i]) <= BLEND
        rounded |= here
        draw_curve(left, course.at(at[here])[:, :2], color=colour, linewidth=2.2, zorder=4)
        right.plot(at[here] / MM, bend[here], color=colour, zorder=4)
    draw_curve(left, course.at(at)[:, :2], color=BLUE)
    right.plot(at / MM, bend, color=BLUE)
    draw_curve(left, np.array((B, C))[:, :2], color=INK, marker="o", linestyle="")
    plane(left, f"corners rounded from {BLEND / MM:g} mm before them")
    right.set(xlabel="s / mm", ylabel="curvature / (1/m)", title="curvature does not jump")
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
