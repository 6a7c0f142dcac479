import numpy as np
import pytest

from splinearm.arrays import frozen_array


def test_an_array_is_copied_and_cannot_be_written():
    source = np.arange(3.0)
    frozen = frozen_array(source, (3,), "a")
    source[0] = 9.0
    assert frozen[0] == 0.0
    assert not frozen.flags.writeable


def test_any_length_is_taken_where_none_is_asked():
    assert frozen_array([[1, 2], [3, 4], [5, 6]], (None, 2), "a").shape == (3, 2)


@pytest.mark.parametrize(
    ("values", "shape", "what"),
    [
        ([1, 2], (3,), r"a: want shape \(3\), got \(2,\)"),
        ([[1, 2]], (None,), r"a: want shape \(any\), got \(1, 2\)"),
        ([1, np.nan], (2,), "a: want finite numbers, got"),
        ([1, np.inf], (2,), "a: want finite numbers, got"),
        (["x"], (1,), "a: want an array of numbers"),
        ([[1], [2, 3]], (2,), "a: want an array of numbers"),
        ([1j], (1,), "a: want an array of numbers"),
    ],
)
def test_what_is_no_such_array_is_refused_with_what_came(values, shape, what):
    with pytest.raises(ValueError, match=what):
        frozen_array(values, shape, "a")


def test_infinities_may_be_allowed_but_nan_never():
    assert np.isinf(frozen_array([np.inf], (1,), "a", finite=False))
    with pytest.raises(ValueError, match="a: want"):
        frozen_array([np.nan], (1,), "a", finite=False)
