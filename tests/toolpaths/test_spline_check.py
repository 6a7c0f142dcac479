"""The check of spline offsets: what is not proven does not pass."""

import json
import os
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.errors import GougeError, OffsetError
from splinearm.toolpaths.piece import ArcPiece, LinePiece, SplinePiece
from splinearm.toolpaths.spline_check import check_band, check_clear, check_complete
from splinearm.toolpaths.spline_offset import offset_outline, offset_spline
from splinearm.toolpaths.spline_source import source_of

ENDS = [0.0] * 4 + [1.0] * 4
S_CURVE = BSpline(ENDS, [[0.0, 0.0], [1.0, 1.0], [0.6, -1.0], [1.6, 0.2]], 3)
WEIGHTED = replace(S_CURVE, weights=np.array([1.0, 2.0, 0.7, 1.0]))
TOLERANCE = 4e-3


@pytest.fixture(scope="module", params=[S_CURVE, WEIGHTED], ids=["polynomial", "rational"])
def made(request):
    (found,) = offset_spline(request.param, 0.15, TOLERANCE)
    return source_of([[SplinePiece(request.param)]], 0.15), found


@pytest.mark.kernel
def test_what_was_made_passes(made):
    source, found = made
    check_band(source, [SplinePiece(found)], 0.15, TOLERANCE)
    check_complete(source, [SplinePiece(found)], 0.15, TOLERANCE)


@pytest.mark.kernel
def test_a_control_point_pushed_into_the_part_is_a_gouge(made):
    source, found = made
    for k in range(1, len(found.points) - 1):
        u = found.domain[0] + (k / (len(found.points) - 1)) * np.diff(found.domain)[0]
        way = found.at(u, 1)
        inward = np.array([way[1], -way[0]]) / np.hypot(*way)
        points = np.array(found.points)
        points[k] += 6.0 * TOLERANCE * inward
        with pytest.raises(GougeError) as error:
            check_band(source, [SplinePiece(replace(found, points=points))], 0.15, TOLERANCE)
        assert 0.0 < error.value.depth < 6.0 * TOLERANCE


@pytest.mark.kernel
def test_a_control_point_pulled_away_is_too_far(made):
    source, found = made
    points = np.array(found.points)
    points[2] += [0.0, 3.0 * TOLERANCE]
    with pytest.raises(OffsetError, match="too far from the curve"):
        check_band(source, [SplinePiece(replace(found, points=points))], 0.15, TOLERANCE)


def test_a_gouge_is_found_however_narrow_it_is():
    # a dent as wide as a thousandth of the offset, and deeper than its band by 2 nm
    (found,) = offset_spline(S_CURVE, 0.15, 1e-6)
    source = source_of([[SplinePiece(S_CURVE)]], 0.15)
    for u in (0.2113, 0.5531, 0.9012):
        dented = found.with_knots(np.repeat([u - 5e-4, u, u + 5e-4], 2))
        points = np.array(dented.points)
        k = int(np.argmin(np.linalg.norm(points - found.at(u), axis=1)))
        way = found.at(u, 1)
        points[k] += 4e-6 * np.array([way[1], -way[0]]) / np.hypot(*way)
        with pytest.raises((GougeError, OffsetError)):
            check_band(source, [SplinePiece(replace(dented, points=points))], 0.15, 1e-6)


@pytest.mark.kernel
def test_an_exact_arc_passes_only_within_its_band():
    arc = ArcPiece.about(np.zeros(2), 0.05, 0.3, 2.0)
    source = source_of([[arc]], 0.01)
    for radius, wrong in ((0.04, None), (0.04 - 2e-6, OffsetError), (0.04 + 1e-9, GougeError)):
        other = [ArcPiece.about(np.zeros(2), radius - 1e-8, 0.3, 2.0)]
        if wrong is None:
            check_band(source, other, 0.01, 1e-6)
        elif radius < 0.04:
            with pytest.raises(wrong):
                check_band(source, other, 0.01, 1e-6)
        else:
            with pytest.raises(wrong):
                check_band(source, [ArcPiece.about(np.zeros(2), radius, 0.3, 2.0)], 0.01, 1e-6)


def test_curves_of_many_pieces_are_proven():
    a = 2.0 * np.pi * np.arange(700) / 700
    inner, outer = (
        BSpline.closed(np.linspace(0.0, 1.0, 701), r * np.column_stack((np.cos(a), np.sin(a))), 3)
        for r in (1.0, 1.1)
    )
    source = source_of([[SplinePiece(inner)]], 0.1)
    check_band(source, [SplinePiece(outer)], 0.099, 2e-3)
    # also a long one behind so many that are far from most of it
    long_one = BSpline(ENDS, [[1.3, -1.0], [1.2, -0.3], [1.2, 0.3], [1.3, 1.0]], 3)
    check_clear(source, [SplinePiece(outer), SplinePiece(long_one)], 0.099)
    with pytest.raises(GougeError):
        check_band(source, [SplinePiece(outer)], 0.101, 2e-3)


def test_a_missing_loop_is_found():
    a = 2.0 * np.pi * np.arange(12) / 12
    points = (46.0 + 29.0 * np.cos(2.0 * a))[:, None] * np.stack((np.cos(a), np.sin(a)), axis=1)
    curve = BSpline.closed(np.linspace(0.0, 1.0, 13), 1e-3 * points, 3)
    first, _ = offset_outline([SplinePiece(curve)], -0.022, 1e-5)
    source = source_of([[SplinePiece(curve)]], 0.022)
    with pytest.raises(OffsetError, match="missing"):
        check_complete(source, first.pieces, 0.022, 1e-5)
    with pytest.raises(OffsetError, match="missing"):
        check_complete(source, [], 0.022, 1e-5)


@pytest.mark.property
@settings(max_examples=40, deadline=None)
@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(0.02, 0.5))
def test_lines_near_a_line_pass_if_they_are_far_enough(slant, along, distance):
    source = source_of([[LinePiece([0.0, 0.0], [1.0, 0.0])]], distance)
    start, end = np.array([along, distance]), np.array([along + 1.0, distance + 0.2 * abs(slant)])
    up = np.array([0.0, 1e-9])
    check_far = [LinePiece(start + up, end + up)]
    # from the line's end on it is farther than it is high
    check_band(source, check_far, distance, 3.0)
    if 0.0 <= along <= 1.0:
        with pytest.raises(GougeError):
            check_band(source, [LinePiece(start - np.array([0.0, 1e-6]), end)], distance, 3.0)


SCRIPT = """
import json
from splinearm.curves.bspline import BSpline
from splinearm.toolpaths.biarc import curve_arcs
from splinearm.toolpaths.piece import SplinePiece
from splinearm.toolpaths.spline_fit_kernel import fewest
from splinearm.toolpaths.spline_offset import offset_spline
from splinearm.toolpaths.spline_source import source_of
curve = BSpline([0.0] * 4 + [1.0] * 4, [[0.0, 0.0], [1.0, 1.0], [0.6, -1.0], [1.6, 0.2]], 3)
(found,) = offset_spline(curve, 0.15, 1e-2)
source = source_of([[SplinePiece(curve)]], 0.15)
band = 0.15 / source.unit, 0.16 / source.unit
pieces = fewest(source.segments, (0.0, 1.0), (0.0, 1.0), band, (-1, -1))
arcs = curve_arcs(curve, 1e-2)
print(json.dumps([pieces.tolist(), [p.start.tolist() for p in arcs.pieces], found.points.tolist()]))
"""


def test_compiled_and_plain_kernels_agree():
    told = []
    for jit in "01":
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT],
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, "NUMBA_DISABLE_JIT": jit},
        )
        told.append(json.loads(done.stdout))
    for ours, plain in zip(*told, strict=True):
        assert np.array(ours) == pytest.approx(np.array(plain), abs=1e-12)
