"""Direct calls: taken where arrays are as they want them, refused everywhere else."""

import pickle
import sys

import numpy as np

from splinearm import direct
from splinearm.compiled import kernel


def _double_into(model, arguments, count):
    given = model, arguments
    a, b = direct.vector(given, 0), direct.vector(given, 1, direct.WRITE)
    return direct.answer(count == 2 and _doubled(direct.matrix(given, direct.MODEL), a, b))


@kernel
def _doubled(A, a, b):
    if A.shape[1] != a.shape[0] or b.shape[0] != a.shape[0]:
        return False
    for i in range(a.shape[0]):
        b[i] = 2.0 * A[0, i] * a[i]
    return True


def test_a_direct_call_answers_only_for_arrays_as_it_wants_them():
    model = np.array([[1.0, 2.0, 3.0]])
    double = direct.bind(_double_into, model)
    a, b = np.array([1.0, 10.0, 100.0]), np.zeros(3)
    assert double(a, b) is True
    assert b.tolist() == [2.0, 40.0, 600.0]
    frozen = a.copy()
    frozen.flags.writeable = False
    pickled = pickle.loads(pickle.dumps(a))
    assert double(frozen, b)
    assert double(pickled, b)
    model[:] = 0.0
    assert double(a, b)
    assert b.tolist() == [2.0, 40.0, 600.0]

    class Own(np.ndarray):
        pass

    for wrong in (
        [1.0, 10.0, 100.0], None, 3.0, a.astype(int), a.astype(np.float32), a.astype(">f8"),
        a.astype(complex), np.zeros((1, 3)), np.zeros(6)[::2], np.zeros(4), a.view(Own),
        np.frombuffer(b"\0" + a.tobytes(), offset=1),
    ):  # fmt: skip
        assert double(wrong, b) is False
        assert double(a, wrong) is False
    assert double(a, frozen) is False
    assert double(a) is False
    assert double(a, b, b) is False


def test_a_direct_call_keeps_no_array_and_leaks_none():
    double = direct.bind(_double_into, np.ones((1, 3)))
    a, b = np.zeros(3), np.zeros(3)
    before = sys.getrefcount(a), sys.getrefcount(b)
    for _ in range(1000):
        double(a, b)
        double(a, a[:2])
    assert (sys.getrefcount(a), sys.getrefcount(b)) == before
