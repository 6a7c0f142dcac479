"""Draw ``bracket.dxf``: an outline with arcs, two pockets, an island in one of them, two holes."""

from pathlib import Path

import ezdxf

CORNER = 0.41421356237309503
"""Bulge of a quarter circle to the left."""


def rounded(x: float, y: float, w: float, h: float, r: float) -> list[tuple[float, ...]]:
    """Give corners and bulges (x, y, bulge) of a rectangle with rounded corners, mm."""
    return [
        (x + r, y, 0.0), (x + w - r, y, CORNER), (x + w, y + r, 0.0), (x + w, y + h - r, CORNER),
        (x + w - r, y + h, 0.0), (x + r, y + h, CORNER), (x, y + h - r, 0.0), (x, y + r, CORNER),
    ]  # fmt: skip


def main() -> None:
    """Write the drawing beside this script."""
    document = ezdxf.new("R2010", units=4)
    # the same drawing is the same file
    document.header["$TDCREATE"] = document.header["$TDUPDATE"] = 2451544.5
    for colour, layer in enumerate(("outline", "pockets", "holes", "text"), start=1):
        document.layers.add(layer, color=colour)
    space = document.modelspace()

    def draw(points: list[tuple[float, ...]], layer: str) -> None:
        space.add_lwpolyline(points, format="xyb", close=True, dxfattribs={"layer": layer})

    outline = rounded(0.0, 0.0, 120.0, 80.0, 12.0)
    # a half round bay in the upper side
    outline[5:5] = [(72.0, 80.0, -1.0), (48.0, 80.0, 0.0)]
    draw(outline, "outline")
    draw(rounded(10.0, 14.0, 60.0, 44.0, 6.0), "pockets")
    space.add_circle((40.0, 36.0), 9.0, dxfattribs={"layer": "pockets"})
    draw([(78.0, 18.0, 0.0), (108.0, 18.0, 0.35), (108.0, 58.0, 0.0), (84.0, 52.0, 0.0)], "pockets")
    for x in (10.0, 110.0):
        space.add_circle((x, 70.0), 3.0, dxfattribs={"layer": "holes"})
    space.add_text("bracket", height=5.0, dxfattribs={"layer": "text"}).set_placement((48.0, 4.0))
    document.saveas(Path(__file__).with_suffix(".dxf"))


if __name__ == "__main__":
    main()
