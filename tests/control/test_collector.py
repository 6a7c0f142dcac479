import gc

import pytest

from splinearm.control.collector import collector_suspended


def fail_inside():
    with collector_suspended():
        assert not gc.isenabled()
        raise RuntimeError


def test_the_collector_rests_inside_and_runs_again_after_also_after_an_error():
    assert gc.isenabled()
    with pytest.raises(RuntimeError):
        fail_inside()
    assert gc.isenabled()


def test_a_collector_that_was_off_stays_off():
    gc.disable()
    try:
        with collector_suspended():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()
