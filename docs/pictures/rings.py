"""Offsets of a part, each from the part itself, and the part."""

import numpy as np
from matplotlib.figure import Figure
from style import BLUE, INK, MM, RED, WIDTH, draw_curve, plane, save, styled

from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.offset import offset, rings
from splinearm.toolpaths.region import Region

PART = Region(
    Contour.rectangle([0.0, 0.0], [0.06, 0.04], 0.006),
    (Contour.circle([0.022, 0.018], 0.007),),
)


def around(contour: Contour) -> np.ndarray:
    """Give places around a contour, m."""
    places = contour.flattened(2e-5)
    return np.concatenate((places, places[:1]))


@styled
def draw() -> Figure:
    """Draw what grows and what shrinks."""
    figure = Figure(figsize=(WIDTH, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    for region in offset(PART, 3 * MM):
        for contour in region.contours:
            draw_curve(left, around(contour), color=BLUE, label="grown by 3 mm")
    for ring in rings(PART, [-d * MM for d in (3, 5, 7, 9, 11, 13)]):
        for region in ring:
            for contour in region.contours:
                draw_curve(right, around(contour), color=RED, linewidth=1.1, label="rings")
    for axes in (left, right):
        for contour in PART.contours:
            draw_curve(axes, around(contour), color=INK, label="part")
        plane(axes)
        handles, labels = axes.get_legend_handles_labels()
        named = dict(zip(labels, handles, strict=True))
        axes.legend(
            named.values(), named.keys(), loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2
        )
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
