from collections import Counter

import pytest

from splinearm.sim.line_fault import FaultKind, LineFault, LineFaults

DATA = bytes(range(30))


def faults_of(*faults: LineFault, seed: int = 0, clock=lambda: 0.0) -> LineFaults:
    return LineFaults(faults, clock=clock, seed=seed)


def test_words_give_the_fault_that_they_say():
    assert LineFault.parse("late id=3 p=0.25 n=5 for=2.5 by=0.01 size=7").__class__ is LineFault
    got = LineFault.parse("late id=3 p=0.25 n=5 for=2.5 by=0.01 size=7")
    assert (got.kind, got.servo_id, got.probability, got.times) == (FaultKind.LATE, 3, 0.25, 5)
    assert (got.lasting, got.seconds, got.size) == (2.5, 0.01, 7)
    plain = LineFault.parse("lost")
    assert (plain.servo_id, plain.probability, plain.times, plain.lasting) == (
        None,
        1.0,
        None,
        None,
    )


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "want one of lost, corrupt"),
        ("gone id=1", "got 'gone'"),
        ("lost id", "got 'lost id'"),
        ("lost p=2", "want 0..1, got 2.0"),
        ("late by=-1", "want seconds and size of 0 or more"),
        ("echo id=1", "echo is of no servo, got 1"),
    ],
)
def test_words_that_say_nothing_are_refused(text, said):
    with pytest.raises(ValueError, match=said):
        LineFault.parse(text)


def test_a_fault_strikes_whom_it_concerns():
    faults = faults_of(LineFault(kind=FaultKind.LOST, servo_id=3))
    assert faults.strikes(FaultKind.LOST, 3)
    assert not faults.strikes(FaultKind.LOST, 4)
    assert not faults.strikes(FaultKind.DEAD, 3)
    assert faults_of(LineFault(kind=FaultKind.LOST)).strikes(FaultKind.LOST, 4)


def test_a_fault_strikes_as_often_as_it_says():
    faults = faults_of(LineFault(kind=FaultKind.LOST, times=2))
    assert [bool(faults.strikes(FaultKind.LOST, 1)) for _ in range(4)] == [True, True, False, False]


def test_a_fault_ends_when_it_says():
    now = 5.0
    faults = faults_of(LineFault(kind=FaultKind.DEAD, lasting=1.0), clock=lambda: now)
    assert faults.strikes(FaultKind.DEAD, 1)
    now = 6.0
    assert not faults.strikes(FaultKind.DEAD, 1)


def test_the_dice_are_fair_and_the_same_for_a_seed():
    def throws(seed: int) -> list[bool]:
        faults = faults_of(LineFault(kind=FaultKind.LOST, probability=0.2), seed=seed)
        return [bool(faults.strikes(FaultKind.LOST, 1)) for _ in range(2000)]

    assert throws(1) == throws(1) != throws(2)
    assert 300 < Counter(throws(1))[True] < 500


@pytest.mark.parametrize(
    ("fault", "holds"),
    [
        (LineFault(kind=FaultKind.CORRUPT), lambda d: sum(map(int.__ne__, d, DATA)) == 1),
        (LineFault(kind=FaultKind.GARBLED), lambda d: all(map(int.__ne__, d, DATA))),
        (LineFault(kind=FaultKind.TRUNCATED), lambda d: 0 < len(d) < 30 and DATA.startswith(d)),
        (LineFault(kind=FaultKind.DOUBLED), lambda d: d == DATA + DATA),
        (LineFault(kind=FaultKind.NOISE, size=5), lambda d: len(d) == 35 and d.endswith(DATA)),
    ],
)
def test_what_becomes_of_a_reply(fault, holds):
    for seed in range(50):
        data, late = faults_of(fault, seed=seed).on_the_way(DATA, 1)
        assert holds(data)
        assert late == 0.0


def test_a_late_reply_is_whole():
    fault = LineFault(kind=FaultKind.LATE, seconds=0.02, servo_id=2)
    assert faults_of(fault).on_the_way(DATA, 2) == (DATA, 0.02)
    assert faults_of(fault).on_the_way(DATA, 3) == (DATA, 0.0)


def test_a_share_of_garbled_bytes_is_that_share():
    faults = faults_of(LineFault(kind=FaultKind.GARBLED, probability=0.01))
    got = b"".join(faults.on_the_way(bytes(100), 1)[0] for _ in range(200))
    assert 120 < sum(map(bool, got)) < 290
