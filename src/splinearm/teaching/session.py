"""A lesson: pieces recorded and taken back by keys, whatever shows them."""

from dataclasses import dataclass
from typing import Literal

from splinearm.arrays import FloatArray
from splinearm.joints import JointState

from .leading import Tape
from .recording import Recording

Grip = Literal["open", "close"]
"""What a gripper does."""


@dataclass(frozen=True, slots=True, eq=False)
class Lesson:
    """How far a lesson is, for showing."""

    q: FloatArray | None
    """Where the joints are, rad or m; None: not known yet."""
    recording: bool
    """Whether a piece is being recorded."""
    duration: float
    """How long that is by now, s."""
    samples: int
    """How many samples it has."""
    pieces: tuple[str, ...]
    """What was taken so far, in words."""
    note: str
    """What the last key did."""
    warning: str = ""
    """What is wrong with the arm; empty: nothing."""


class Session:
    """Takes keys and readings; keeps pieces.

    Args:
        names: The joints.
        rate: Readings a second, Hz.
        has_gripper: Whether the arm has one.
    """

    def __init__(self, names: tuple[str, ...], rate: float, *, has_gripper: bool = True) -> None:
        self._names = names
        self._rate = rate
        self._has_gripper = has_gripper
        self._tape: Tape | None = None
        self._q: FloatArray | None = None
        self._note = self._warning = ""
        self.pieces: list[Recording | Grip] = []
        """What was taken, in order."""
        self.ends = False
        """Whether the lesson is over."""

    @property
    def recording(self) -> bool:
        """Whether a piece is being recorded."""
        return self._tape is not None

    def see(self, state: JointState | None) -> None:
        """Take a reading."""
        self._warning = ""
        if state is None:
            return
        self._q = state.q
        if self._tape is not None:
            self._tape.keep(state)

    def press(self, key: str) -> None:
        """Do what a key asks for; others do nothing."""
        if key == " ":
            self._start_or_stop()
        elif key == "g":
            self._grip()
        elif key == "u":
            self._take_back()
        elif key == "enter":
            self.end()

    def end(self) -> None:
        """End the lesson, with the piece that is being recorded."""
        self._finish()
        self.ends = True

    def warn(self, words: str) -> None:
        """Let something be said of the arm until the next reading."""
        self._warning = words

    def lesson(self) -> Lesson:
        """Give how far it is."""
        tape = self._tape
        return Lesson(
            q=self._q,
            recording=tape is not None,
            duration=0.0 if tape is None else tape.duration,
            samples=0 if tape is None else len(tape),
            pieces=tuple(map(words_of, self.pieces)),
            note=self._note,
            warning=self._warning,
        )

    def _start_or_stop(self) -> None:
        if self._tape is None:
            self._tape, self._note = Tape(), "lead it; space stops this piece"
        else:
            self._finish()

    def _finish(self) -> None:
        if self._tape is None:
            return
        piece = self._tape.recording(self._names, self._rate)
        self._tape = None
        if len(piece.t):
            self.pieces.append(piece)
            self._note = f"taken: {words_of(piece)}"

    def _grip(self) -> None:
        """Have the gripper close, or open if it was closed last; a piece goes on behind it."""
        if not self._has_gripper:
            self._note = "the arm has no gripper"
            return
        going_on = self.recording
        self._finish()
        last = next((piece for piece in reversed(self.pieces) if isinstance(piece, str)), "open")
        grip: Grip = "open" if last == "close" else "close"
        self.pieces.append(grip)
        self._note = words_of(grip)
        if going_on:
            self._tape = Tape()

    def _take_back(self) -> None:
        if self._tape is not None:
            self._tape, self._note = None, "this piece is taken back"
        elif self.pieces:
            self._note = f"taken back: {words_of(self.pieces.pop())}"
        else:
            self._note = "there is nothing to take back"


def words_of(piece: Recording | Grip) -> str:
    """Give a piece in words."""
    if isinstance(piece, str):
        return f"gripper: {piece}"
    lost = f", {piece.lost} lost" if piece.lost else ""
    return f"{piece.duration:.1f} s, {len(piece.t)} samples{lost}"
