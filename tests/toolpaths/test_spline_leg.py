"""Ways with splines: cut exactly by the length along the arcs beside them."""

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.curves.conic import line
from splinearm.errors import ToolpathError
from splinearm.toolpaths.edge_feed import spline_feeds
from splinearm.toolpaths.piece import ArcPiece, LinePiece, SplinePiece
from splinearm.toolpaths.spline_leg import begun_well, legs_of, path_of, pieces_between

WAVE = BSpline(
    [0.0, 0.0, 0.0, 0.0, 0.4, 1.0, 1.0, 1.0, 1.0],
    [[0.0, 0.0], [0.01, 0.012], [0.02, -0.008], [0.035, 0.01], [0.04, 0.0]],
    3,
)
PIECES = (
    LinePiece([-0.02, 0.0], [0.0, 0.0]),
    SplinePiece(WAVE),
    ArcPiece.about(np.array([0.04, 0.01]), 0.01, -0.5 * pi, 1.8 * pi),
)
TOLERANCE = 1e-6


def length_of(pieces):
    return sum(piece.length for piece in pieces)


def test_arcs_are_beside_the_splines_and_end_where_they_do():
    legs = legs_of(PIECES, TOLERANCE)
    assert [leg.piece for leg in legs] == list(PIECES)
    path = path_of(legs)
    assert (path.vertices[0] == PIECES[0].start).all()
    assert (path.vertices[-1] == PIECES[-1].end).all()
    for leg in legs:
        assert (leg.path.vertices[0] == leg.piece.start).all()
        assert (leg.path.vertices[-1] == leg.piece.end).all()
    curved = legs[1]
    places = WAVE.at(np.linspace(0.0, 1.0, 400))
    assert curved.path.distance(places).max() <= TOLERANCE
    assert path.length == pytest.approx(length_of(PIECES), abs=1e-6)
    # which place of the spline each corner is beside
    assert np.abs(WAVE.at(curved.us) - curved.path.vertices).max() <= TOLERANCE
    with pytest.raises(ToolpathError, match="too many arcs"):
        legs_of(PIECES, 1e-300)


@pytest.mark.property
@settings(max_examples=60, deadline=None)
@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=4))
def test_parts_one_after_the_other_are_the_whole(shares):
    legs = legs_of(PIECES, TOLERANCE)
    whole = path_of(legs).length
    marks = [0.0, *sorted(share * whole for share in shares), whole]
    parts = [pieces_between(legs, a, b) for a, b in pairwise(marks)]
    pieces = [piece for part in parts for piece in part]
    assert length_of(pieces) == pytest.approx(length_of(PIECES), abs=1e-9)
    # what is shorter than a billionth of a piece may be left out
    for before, behind in pairwise(pieces):
        assert np.abs(before.end - behind.start).max() <= 1e-9
    for part, (a, b) in zip(parts, pairwise(marks), strict=True):
        assert length_of(part) == pytest.approx(b - a, abs=2e-6)


def test_a_part_of_a_spline_is_that_curve():
    legs = legs_of(PIECES, TOLERANCE)
    (part,) = pieces_between(legs, 0.025, 0.035)
    lo, hi = part.curve.domain
    u = np.linspace(lo, hi, 9)
    np.testing.assert_allclose(part.curve.at(u), WAVE.at(u), atol=1e-16)
    # what is left whole is the very piece
    assert pieces_between(legs, 0.0, path_of(legs).length) == PIECES


def test_closed_pieces_begin_amid_their_longest_line_else_their_longest_piece():
    home = LinePiece(PIECES[-1].end, PIECES[0].start)
    closed = [*PIECES, home]
    turned = begun_well(closed)
    assert (turned[0].start == home.middle).all()
    assert (turned[-1].end == home.middle).all()
    assert length_of(turned) == pytest.approx(length_of(closed))
    for pieces in (PIECES[1:], [PIECES[1], SplinePiece(line(PIECES[1].end, PIECES[1].start))]):
        turned = begun_well(pieces)
        longest = max(pieces, key=lambda piece: piece.length)
        assert len(turned) == len(pieces) + 1
        assert turned[0].start == pytest.approx(longest.middle, abs=1e-16)
        assert length_of(turned) == pytest.approx(length_of(pieces))
    assert begun_well([PIECES[1]]) == [PIECES[1]]


def test_spans_that_bend_away_from_the_wall_are_slowed():
    for wall in (1, -1):
        parts = spline_feeds(WAVE, wall, 0.02, 3e-3)
        feeds = [feed for _, feed in parts]
        assert max(feeds) <= 0.02
        assert min(feeds) < 0.019
        ends = [(part.domain, feed) for part, feed in parts]
        assert ends[0][0][0] == 0.0
        assert ends[-1][0][1] == 1.0
    ((whole, feed),) = spline_feeds(WAVE, 0, 0.02, 3e-3)
    assert whole is WAVE
    assert feed == 0.02
