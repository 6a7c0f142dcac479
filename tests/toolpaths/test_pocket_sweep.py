"""Pockets and profiles of many random parts, verified by code that did not make them."""

import numpy as np
import pytest

from splinearm.errors import ContourError
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.fitting import fitted
from splinearm.toolpaths.gcode_check import write_checked
from splinearm.toolpaths.gcode_dialect import DIALECTS
from splinearm.toolpaths.operation import Entry, Side
from splinearm.toolpaths.pocket import pocket
from splinearm.toolpaths.profile_pass import profile
from splinearm.toolpaths.region import Region
from splinearm.toolpaths.spiral import spiral
from splinearm.toolpaths.stock import Stock
from splinearm.toolpaths.verify import Allowance, verify
from splinearm.toolpaths.verify_part import Task, Zone
from splinearm.toolpaths.zigzag import zigzag


def random_part(seed):
    """Give a valid part of lines and arcs, with islands in half of them."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(4, 40))
    angle = 2.0 * np.pi * (np.arange(n) + rng.uniform(-0.3, 0.3, n)) / n
    far = 0.03 * (1.0 + min(0.4, 6.0 / n) * rng.uniform(-1, 1, n))
    points = far[:, None] * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    bulges = np.where(rng.uniform(size=n) < 0.5, 0.0, rng.uniform(-0.4, 0.4, n))
    islands = []
    if seed % 2:
        spot = rng.uniform(-0.006, 0.006, 2)
        islands.append(Contour.circle(spot, rng.uniform(1e-3, 5e-3)))
    while True:
        try:
            return Region(Contour(points, bulges), tuple(islands))
        except ContourError:
            bulges = 0.6 * bulges


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(60))
def test_a_random_part_is_made_right(seed, milling):
    part = random_part(seed)
    rng = np.random.default_rng(1000 + seed)
    setting = milling(
        depth=3e-3,
        step_over=rng.uniform(0.6e-3, 4e-3),
        climb=bool(seed % 3),
        entry=list(Entry)[seed % 3],
        lead=1.5e-3,
    )
    stock = Stock.about(part, margin=0.01, thick=0.004)
    zones = {
        "inside": Zone(regions=(part,), floor=-3e-3),
        "edge": Zone(regions=(part,), floor=-3e-3, cleared=False),
        "outside": Zone(regions=(part,), floor=-3e-3, side="outside", cleared=False),
    }
    made = [(kind([part], setting), "inside") for kind in (pocket, zigzag, spiral)]
    made.append((profile([part], setting, Side.INSIDE), "edge"))
    made.append((profile([part], setting, Side.OUTSIDE), "outside"))
    for milled, zone in made:
        for dialect in DIALECTS.values():
            write_checked(fitted(milled.actions, dialect), dialect)
        report = verify(
            milled.actions, Task(stock, (zones[zone],)), setting.cutter, Allowance(gouge=1e-9)
        )
        assert report.ok, (zone, report.text(), milled.notes)
        assert report.gouge <= 1e-9
