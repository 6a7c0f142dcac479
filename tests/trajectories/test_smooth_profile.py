"""What is given where the solver finds nothing."""

from dataclasses import replace

import numpy as np
import pytest

from splinearm.curves.interpolation import interpolate
from splinearm.trajectories import smooth_grid, smooth_problem, smooth_timing
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.section import Section
from splinearm.trajectories.smooth_canonical import canonical
from splinearm.trajectories.smooth_problem import End
from splinearm.trajectories.smooth_timing import quickest_smooth


@pytest.mark.parametrize("seed", range(3))
def test_where_nothing_is_found_the_law_is_slower_and_says_so(seed, make_limits, caplog):
    # thousands of random paths do not lead there, so that it is called by its name
    points = np.random.default_rng(seed).uniform(-2.0, 2.0, (8, 5))
    path = JointPath(interpolate(points, degree=5, parameters="uniform"))
    limits = replace(make_limits([2.0] * 5, [10.0] * 5), qddd_max=np.full(5, 100.0))
    columns = np.stack((limits.qd_max, limits.qdd_max, limits.qddd_max))
    same = canonical(path.breaks, path.coefficients, path.domain, columns, None)
    guess = smooth_grid.estimate(same.way, (0.0, 0.0))
    rest = End(0.0, 0.0)
    problem = smooth_problem.pose(same.way, guess, (rest, rest), 200)
    law = smooth_timing._law(problem, *smooth_timing._last_resort(problem), same)
    assert "no quickest law" in caplog.text
    ts = np.linspace(0.0, law.duration, 10_001)
    section = Section(path, law)
    _, qd, qdd = section.sample(ts)
    values = zip((qd, qdd, section.jerk(ts)), columns, strict=True)
    used = max(float(np.abs(value / most).max()) for value, most in values)
    assert 0.95 < used <= 1.0 + 1e-6
    best = quickest_smooth(path, limits)
    assert best.duration < law.duration < 4.0 * best.duration
