"""Stretches of contours by the length along them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.stretch import (
    along_of,
    begun_at,
    begun_on,
    nearest_along,
    opened,
    place_on,
    stretch,
)

SHAPES = {
    "polygon": Contour.polyline([[0, 0], [3, 0], [3, 2], [1, 4]]),
    "circle": Contour.circle([1.0, 2.0], 3.0),
    "slot": Contour.rectangle([0.0, 0.0], [5.0, 2.0], 1.0),
    "wide arcs": Contour(
        np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), np.array([2.5, 0.3, -0.2])
    ),
}
PATH = Contour(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), np.array([-0.8, 0.4]), closed=False)

each_shape = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
pytestmark = pytest.mark.kernel


@each_shape
@given(begin=st.floats(-2.0, 2.0), share=st.floats(0.01, 2.3))
@settings(max_examples=30, deadline=None)
def test_a_stretch_has_its_length_and_lies_on_its_contour(shape, begin, share):
    whole = shape.length
    part = stretch(shape, begin * whole, (begin + share) * whole)
    assert part.length == pytest.approx(share * whole, rel=1e-9)
    assert not part.closed
    assert shape.distance(part.flattened(1e-2)).max() < 1e-2 + 1e-9
    np.testing.assert_allclose(part.vertices[0], place_on(shape, begin * whole)[0], atol=1e-9)
    np.testing.assert_allclose(
        part.vertices[-1], place_on(shape, (begin + share) * whole)[0], atol=1e-9
    )


@each_shape
def test_a_contour_begun_elsewhere_is_the_same_contour(shape):
    for along in np.linspace(0.0, shape.length, 23):
        begun = begun_at(shape, float(along))
        assert (begun.vertices[0] == begun.vertices[-1]).all()
        assert begun.length == pytest.approx(shape.length, rel=1e-12)
        closed = Contour(begun.vertices[:-1], begun.bulges)
        assert closed.area == pytest.approx(shape.area, rel=1e-9)


@each_shape
def test_a_place_is_found_again_along_its_contour(shape):
    marks = np.concatenate(([0.0], np.cumsum(shape.lengths)))
    for along in np.linspace(0.01, 0.99, 17) * shape.length:
        place, direction = place_on(shape, along)
        segment = int(np.searchsorted(marks, along, side="right") - 1)
        assert along_of(shape, segment, place) == pytest.approx(along, rel=1e-9)
        assert nearest_along(shape, place) == pytest.approx(along, abs=1e-7)
        ahead = place_on(shape, along + 1e-6)[0]
        if segment == np.searchsorted(marks, along + 2e-6, side="right") - 1:
            np.testing.assert_allclose((ahead - place) / 1e-6, direction, atol=1e-5)
        begun = begun_on(shape, segment, place)
        np.testing.assert_allclose(begun.vertices[0], place, atol=1e-9)


def test_an_open_contour_gives_no_more_than_it_is_long():
    assert stretch(PATH, 0.0, PATH.length).length == pytest.approx(PATH.length)
    for begin, end in ((-0.1, 0.5), (0.5, PATH.length + 0.1), (0.5, 0.5)):
        with pytest.raises(ValueError, match="stretch"):
            stretch(PATH, begin, end)
    assert opened(PATH) is PATH
    around = opened(SHAPES["polygon"])
    assert len(around.vertices) == 5
    assert not around.closed
