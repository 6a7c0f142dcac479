"""Pieces joined end to end: every piece once, in order, meeting exactly, and what is odd told."""

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from splinearm.curves.bspline import BSpline
from splinearm.toolpaths.chain import chain
from splinearm.toolpaths.piece import ArcPiece, LinePiece, SplinePiece

TOLERANCE = 1e-5


def line(a, b):
    return LinePiece(np.array(a, dtype=float), np.array(b, dtype=float))


def ring(count):
    angles = np.linspace(0.0, 2.0 * pi, count, endpoint=False)
    corners = np.column_stack((np.cos(angles), np.sin(angles)))
    return [line(corners[i], corners[(i + 1) % count]) for i in range(count)]


def assert_whole(wire):
    pieces = wire.pieces
    for before, after in pairwise(pieces):
        assert (before.end == after.start).all()
    assert wire.closed == bool((pieces[-1].end == pieces[0].start).all())


@pytest.mark.property
@given(
    order=st.permutations(range(8)),
    flips=st.lists(st.booleans(), min_size=8, max_size=8),
    shift=st.lists(st.floats(-0.35, 0.35), min_size=32, max_size=32),
)
def test_a_ring_is_found_in_any_order_and_direction_with_gaps_within_the_tolerance(
    order, flips, shift
):
    moves = np.reshape(shift, (8, 2, 2)) * TOLERANCE
    pieces = []
    for i in order:
        piece = ring(8)[i]
        piece = line(piece.start + moves[i, 0], piece.end + moves[i, 1])
        pieces.append(piece.reversed() if flips[i] else piece)
    found = chain(pieces, TOLERANCE)
    (wire,) = found.wires
    assert wire.closed
    assert len(wire.pieces) == 8
    assert_whole(wire)
    assert found.widest_gap <= TOLERANCE
    assert len(found.open_ends) == len(found.branches) == len(found.duplicates) == 0


def test_the_direction_in_which_a_ring_was_drawn_is_kept():
    (wire,) = chain(ring(5), TOLERANCE).wires
    for piece, drawn in zip(wire.pieces, ring(5), strict=True):
        np.testing.assert_allclose(piece.start, drawn.start, atol=1e-15)


def test_open_ends_are_told_with_their_places():
    found = chain([line((0, 0), (1, 0)), line((1, 0), (1, 1))], TOLERANCE)
    (wire,) = found.wires
    assert not wire.closed
    assert_whole(wire)
    np.testing.assert_allclose(sorted(found.open_ends.tolist()), [[0, 0], [1, 1]])


def test_a_gap_above_the_tolerance_stays_open():
    found = chain([line((0, 0), (1, 0)), line((1, 2 * TOLERANCE), (0, 0))], TOLERANCE)
    assert len(found.open_ends) == 2


def test_where_three_pieces_meet_wires_end_and_the_place_is_told():
    found = chain([line((0, 0), (1, 0)), line((1, 0), (2, 0)), line((1, 0), (1, 1))], TOLERANCE)
    assert len(found.wires) == 3
    np.testing.assert_allclose(found.branches, [[1, 0]])


def test_pieces_drawn_twice_are_kept_once_and_told():
    circle = ArcPiece.about(np.zeros(2), 0.1, 0.0, 2.0 * pi)
    turned = ArcPiece.about(np.zeros(2), 0.1, 1.0, -2.0 * pi)
    arc = ArcPiece.about(np.ones(2), 0.1, 0.0, 1.0)
    found = chain(
        [circle, turned, arc, arc.reversed(), line((3, 0), (4, 0)), line((4, 0), (3, 0))], TOLERANCE
    )
    assert len(found.wires) == 3
    assert len(found.duplicates) == 3


def test_two_arcs_over_one_chord_are_no_duplicates_but_a_ring():
    above = ArcPiece.bulging(np.zeros(2), np.array([1.0, 0.0]), -0.5)
    below = ArcPiece.bulging(np.zeros(2), np.array([1.0, 0.0]), 0.5)
    (wire,) = chain([above, below], TOLERANCE).wires
    assert wire.closed
    assert wire.length == pytest.approx(2 * above.length)


def test_circles_and_closed_splines_are_wires_by_themselves():
    points = np.array([(0.0, 0.0), (1.0, 2.0), (2.0, -1.0), (0.0, 0.0)])
    loop = SplinePiece(BSpline(np.repeat((0.0, 1.0), 4), points, 3))
    found = chain([loop, ArcPiece.about(np.zeros(2), 3.0, 0.0, 2 * pi)], TOLERANCE)
    assert [wire.closed for wire in found.wires] == [True, True]


def test_splines_and_arcs_are_moved_to_meet_exactly():
    points = np.array([(0.0, 0.0), (1.0, 2.0), (2.0, -1.0), (3.0, 0.0)])
    spline = SplinePiece(BSpline(np.repeat((0.0, 1.0), 4), points, 3))
    arc = ArcPiece.bulging(np.array([3.0, 4e-6]), np.array([5.0, 0.0]), 0.7)
    (wire,) = chain([spline, arc], TOLERANCE).wires
    assert_whole(wire)
    assert wire.pieces[1].turn == pytest.approx(arc.turn)


def test_a_tolerance_must_be_above_zero():
    with pytest.raises(ValueError, match="tolerance"):
        chain([], 0.0)
