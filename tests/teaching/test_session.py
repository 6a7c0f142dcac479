"""Keys make pieces, take them back and end; readings between pieces are not kept."""

import numpy as np
import pytest

from splinearm.joints import JointState
from splinearm.teaching.session import Session


class Lesson:
    """A session, and readings that come by."""

    def __init__(self, **more):
        self.session = Session(("a", "b"), 100.0, **more)
        self.t = 5.0

    def goes_on(self, count=10):
        for _ in range(count):
            self.t += 0.01
            q = np.array([self.t, 0.0])
            state = JointState(t=self.t, q=q, qd=np.zeros(2), current=np.zeros(2))
            self.session.see(state)

    def press(self, *keys):
        for key in keys:
            self.session.press(key)


@pytest.fixture
def lesson():
    return Lesson()


def test_space_starts_and_stops_a_piece(lesson):
    lesson.goes_on()
    lesson.press(" ")
    assert lesson.session.recording
    lesson.goes_on(20)
    lesson.press(" ")
    lesson.goes_on()
    (piece,) = lesson.session.pieces
    assert len(piece.t) == 20
    assert piece.t[0] == pytest.approx(5.11)
    assert piece.lost == 0


def test_readings_that_did_not_come_are_counted(lesson):
    lesson.press(" ")
    lesson.goes_on(5)
    lesson.session.see(None)
    lesson.t += 0.03
    lesson.goes_on(5)
    lesson.press(" ")
    assert lesson.session.pieces[0].lost == 3


def test_the_gripper_parts_a_piece_and_the_recording_goes_on(lesson):
    lesson.press(" ")
    lesson.goes_on()
    lesson.press("g")
    assert lesson.session.recording
    lesson.goes_on()
    lesson.press("g", "enter")
    first, close, second, opened = lesson.session.pieces
    assert (close, opened) == ("close", "open")
    assert len(first.t) == len(second.t) == 10
    assert lesson.session.ends


def test_u_takes_back_what_is_recorded_then_the_last_piece(lesson):
    lesson.press(" ")
    lesson.goes_on()
    lesson.press(" ", "g", " ")
    lesson.goes_on()
    lesson.press("u")
    assert not lesson.session.recording
    assert len(lesson.session.pieces) == 2
    lesson.press("u")
    assert len(lesson.session.pieces) == 1
    lesson.press("u", "u")
    assert lesson.session.pieces == []
    assert "nothing" in lesson.session.lesson().note


def test_an_arm_without_gripper_says_so():
    lesson = Lesson(has_gripper=False)
    lesson.press("g")
    assert lesson.session.pieces == []
    assert "no gripper" in lesson.session.lesson().note


def test_what_is_shown_is_how_far_it_is(lesson):
    lesson.press(" ")
    lesson.goes_on(11)
    shown = lesson.session.lesson()
    assert (shown.recording, shown.samples) == (True, 11)
    assert shown.duration == pytest.approx(0.1)
    lesson.press(" ", "x")
    assert lesson.session.lesson().pieces == ("0.1 s, 11 samples",)


def test_a_warning_stands_until_the_arm_is_read_again(lesson):
    lesson.session.warn("NOT HELD")
    assert lesson.session.lesson().warning == "NOT HELD"
    lesson.goes_on(1)
    assert not lesson.session.lesson().warning
