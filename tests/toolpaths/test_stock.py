"""Stock as heights: cells are where they say, and kernels are the Python that they stand for."""

import numpy as np
import pytest

from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.region import Region
from splinearm.toolpaths.stock import HeightMap, Stock, cell_for

pytestmark = pytest.mark.kernel

MM = 1e-3
PLATE = Contour.rectangle([0, 0], [50 * MM, 30 * MM], 4 * MM)
HOLED = Region(PLATE, (Contour.circle([25 * MM, 15 * MM], 4 * MM),))


def test_a_block_lies_about_its_region_with_as_many_cells_as_asked():
    block = Stock.about(HOLED, margin=5 * MM, top=1 * MM, thick=10 * MM)
    assert block.low == pytest.approx([-5 * MM, -5 * MM, -9 * MM])
    assert block.high == pytest.approx([55 * MM, 35 * MM, 1 * MM])
    blank = HeightMap.of(block, cell_for(block, 10_000))
    assert blank.heights.size == pytest.approx(10_000, rel=0.03)
    x, y, z = blank.place(0, 0)
    assert (x, y, z) == pytest.approx((-5 * MM, -5 * MM, 1 * MM), abs=blank.cell)


def test_cells_are_covered_as_contours_contain_their_middles():
    blank = HeightMap.of(Stock.about(HOLED, margin=8 * MM, thick=10 * MM), 0.37 * MM)
    rows, columns = blank.heights.shape
    x = blank.corner[0] + blank.cell * np.arange(columns)
    y = blank.corner[1] + blank.cell * np.arange(rows)
    middles = np.stack(np.meshgrid(x, y), axis=-1)
    near = HOLED.distance(middles) < 0.02 * blank.cell
    wrong = blank.covered(HOLED.contours) != HOLED.contains(middles)
    assert not (wrong & ~near).any()


def test_kernels_say_the_same_as_plain_python(compiled_as_plain):
    code = """
import numpy as np
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.verify_way import outline_of
from splinearm.toolpaths.verify_kernel import clearances, gaps, insides, rooms
from splinearm.toolpaths.stock_kernel import carve, filled
part = outline_of([Contour.rectangle([0, 0], [4, 2], 0.5), Contour.circle([2, 1], 0.4)])
ways = outline_of([Contour.rectangle([0.3, 0.4], [3.4, 1.2], 0.2), Contour.circle([2, 1], 0.7)])
near, spots = np.empty((len(ways), 3)), np.random.default_rng(1).uniform(-1, 5, (40, 2))
clearances(ways, np.full(len(ways), 9.0), part, near)
far, odd, room = (np.empty(len(spots)) for _ in range(3))
gaps(part, spots, 0.0, far)
insides(part, spots, odd)
rooms(part, part, np.array([0.0, len(part)]), np.zeros(1), spots[:8], 0.3, room[:8])
heights, cells = np.zeros((30, 40)), np.empty((30, 40))
moves = np.array([[0.5, 0.5, -0.1, 3.0, 1.5, -0.4], [1.0, 1.0, 0.1, 1.0, 1.0, -0.3]])
done = []
for kind in (0.0, 1.0, 2.0):
    found = np.empty((2, 4))
    carve(heights, (0.05, 0.05, 0.1), moves, np.full((2, 3), (kind, 0.35, 0.8)), found)
    done.append(found)
filled(np.array([[0.3, 0.2], [3, 0.4], [2, 2.5]]), np.array([0.0, 3.0]), (0.05, 0.05, 0.1), cells)
found = [near[:, 0], far, odd, room[:8], heights, np.array(done)[:, :, [0, 3]], cells]
"""
    compiled_as_plain(code, 7)
