"""The steps of ``splinearm calibrate``: what a person at the arm sees, does and is asked."""

import time
from collections.abc import Callable, Collection
from datetime import UTC, datetime
from functools import partial
from typing import TYPE_CHECKING

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.text import Text

from splinearm.commissioning.calibration_bench import CalibrationBench
from splinearm.commissioning.calibration_words import growth_words, pose_words
from splinearm.commissioning.calibration_zero import zero_by_ends, zero_by_pose
from splinearm.config import Cell
from splinearm.config.calibration_table import Calibration
from splinearm.errors import SplinearmError, TerminalLostError
from splinearm.units import DEG

from .calibrate_outcome import Outcome, Shown, live_table
from .keyboard import Keyboard
from .output import console

if TYPE_CHECKING:
    from splinearm.commissioning.calibration_hand import VirtualHand

_LOOK, _DRAWN = 0.02, 0.1
"""How long a key is waited for between two readings, and how often the screen is drawn, s."""

_CLEAR = 5.0 * DEG
"""By so much a joint must be turned for its direction to be clear, rad."""

_SWEPT = 10.0 * DEG
"""A joint that lacks less of what its limits span is done, rad."""


_SWEEP = "Turn each joint from one end to the other. Enter: done; r: begin anew; q: leave."


class Steps:
    """One calibration, step by step. Nothing is written before the last question."""

    def __init__(
        self,
        cell: Cell,
        bench: CalibrationBench,
        keys: Keyboard,
        hand: "VirtualHand | None" = None,
        *,
        arm: str = "",
        to_errors: bool = False,
    ) -> None:
        """Take an arm that was surveyed, and a terminal.

        Args:
            cell: The arm, as its file says.
            bench: Its servos.
            keys: The keyboard.
            hand: What turns the joints in a rehearsal: then nothing is kept.
            arm: What the person calls the arm; empty: by its name.
            to_errors: Whether the error stream is what the person sees.
        """
        self._cell, self._bench, self._keys, self._hand = cell, bench, keys, hand
        self._arm = arm or cell.name
        self._show = Shown(Console(stderr=True) if to_errors else console)
        grippers = [] if bench.gripper is None else [bench.gripper.name]
        self._names = (*bench.joints, *grippers)
        self._signs: dict[str, int] = {}
        self._zeros: dict[str, float] = {}
        self._zero_by = ""

    def take(self, name: str, pose: str, *, by_ends: bool, serial: str | None) -> Calibration:
        """Take all steps; give what was made.

        Args:
            name: What it is called.
            pose: The named pose in which the arm is put.
            by_ends: Whether zero is found by the ends of the travel instead.
            serial: Serial number of the adapter, if it is known.

        Raises:
            KeyboardInterrupt: If the person has had enough. Torque that is off stays off.
            CalibrationError: If the arm cannot be calibrated as it is mounted or was moved.
            BusError: If a servo does not answer or refuses.
        """
        self._let_go()
        try:
            return self._take(name, pose, by_ends=by_ends, serial=serial)
        except BaseException:
            self._show.say("Left. The torque is off: support the arm until it is on again.")
            raise

    def _take(self, name: str, pose: str, *, by_ends: bool, serial: str | None) -> Calibration:
        self._sweep()
        for joint in self._bench.joints if by_ends else ():
            zero_by_ends(self._bench.turned(joint, 1))  # refused now rather than in the end
        for joint in self._bench.joints:
            self._find_sign(joint, pose)
        if by_ends:
            self._zeros_by_ends()
        else:
            self._zeros_by_pose(pose)
        ends = None if self._bench.gripper is None else self._find_gripper(self._bench.gripper.name)
        fresh = Calibration(
            arm=self._cell.name,
            name=name,
            date=datetime.now(UTC).replace(microsecond=0),
            servos=(),
            usb_serial=serial,
        )
        return self._set(fresh, ends)

    def _let_go(self) -> None:
        """Have the arm supported, then switch its torque off."""
        held = self._bench.line.energised()
        if held:
            names = ", ".join(servo.name for servo in held)
            self._ask(
                f"The torque of {names} is on.",
                "Support the arm with your hand or something under it: it falls when the torque "
                "goes off. Press s once it is supported.",
                keys="s",
            )
            self._bench.line.release()
        self._show.say("The torque is off: the joints can be turned by hand.")

    def _sweep(self) -> None:
        """Let every joint be turned from end to end; what is missing is asked for once."""
        bench, tail = self._bench, _SWEEP
        asked: set[str] = set()
        while True:
            if self._watch(partial(self._sweep_table, tail), ("enter", "r")) == "r":
                bench.begin_anew()
                tail, asked = _SWEEP, set()
                continue
            far = [name for name in self._names if bench.is_too_far(name)]
            lacking = {j: bench.missing(j) for j in bench.joints if bench.missing(j) > _SWEPT}
            if far:
                names = ", ".join(far)
                tail = f"Turned farther than the servo can tell: {names}. Press r to begin anew."
            elif lacking.keys() <= asked:
                return
            else:
                asked |= lacking.keys()
                words = ", ".join(f"{j} {angle / DEG:.0f} deg" for j, angle in lacking.items())
                tail = (
                    f"Missing of what the limits span: {words}. Turn on, or press Enter again if "
                    "the arm cannot go farther."
                )

    def _sweep_table(self, tail: str) -> RenderableType:
        table = live_table("joint", "now", "lowest", "highest", "travel", "missing")
        for name in self._names:
            sweep = self._bench.sweep_of(name)
            model = self._bench.model_of(name)
            travel = sweep.travel / model.pulses_per_rad
            missing = self._bench.missing(name) if name in self._bench.joints else 0.0
            text, style = "-", "green"
            if self._bench.is_too_far(name):
                text, style = "too far: the servo cannot tell", "bold red"
            elif missing > _SWEPT:
                text, style = f"{missing / DEG:.0f} deg", "yellow"
            cells = (sweep.now, sweep.low, sweep.high, f"{travel / DEG:.1f} deg", text)
            table.add_row(name, *map(str, cells), style=style)
        return Group(Text(tail), table)

    def _find_sign(self, joint: str, pose: str) -> None:
        """Let a joint be turned so that its angle grows, and see which way it counts."""
        bench, arm = self._bench, self._cell.arm
        i = arm.joint_names.index(joint)
        how = growth_words(arm, self._cell.poses[pose], i)
        begun, clear = bench.sweep_of(joint).now, _CLEAR * bench.model_of(joint).pulses_per_rad
        head = Text(f"Joint {joint}: turn it {how}", style="bold")
        if len(self._bench.joints) > 1 or arm.n > 1:
            head.append(f"\n  (as it is with the arm about in its pose {pose!r})", style="not bold")
        while True:
            key = self._watch(partial(self._sign_picture, joint, head, begun), ("enter", "r"))
            moved = bench.sweep_of(joint).now - begun
            if key == "r":
                begun = bench.sweep_of(joint).now
            elif abs(moved) >= clear:
                self._signs[joint] = 1 if moved > 0 else -1
                self._show.say(f"{joint}: turned {how}, its numbers go {_way(moved)}")
                return

    def _sign_picture(self, joint: str, head: Text, begun: int) -> RenderableType:
        moved = self._bench.sweep_of(joint).now - begun
        far = abs(moved) >= _CLEAR * self._bench.model_of(joint).pulses_per_rad
        shown = f"the numbers go {_way(moved)}" if far else "turn it farther"
        return Group(
            head,
            Text(f"  {moved:+d} ticks: {shown}"),
            Text("Enter: so it is; r: begin anew from here; q: leave."),
        )

    def _zeros_by_ends(self) -> None:
        for joint in self._bench.joints:
            self._zeros[joint] = zero_by_ends(self._bench.turned(joint, self._signs[joint]))
        self._zero_by = "the ends of its travel"

    def _zeros_by_pose(self, pose: str) -> None:
        """Let the arm be put in a pose, and take where its joints are there."""
        bench, cell = self._bench, self._cell
        q = cell.poses[pose]
        tail = "Put the arm in that pose and hold it still. Enter: there it is; q: leave."
        while True:
            self._watch(partial(self._pose_table, pose, tail), ("enter",))
            counts = bench.rest()
            if counts is not None:
                break
            tail = "It moves. Hold it still, then press Enter again."
        for joint in bench.joints:
            servo, i = bench.leaders[joint], cell.arm.joint_names.index(joint)
            count, sign = counts[servo.servo_id], self._signs[joint]
            self._zeros[joint] = zero_by_pose(count, float(q[i]), sign, servo.servo_model)
        self._zero_by = f"the pose {pose!r}"

    def _pose_table(self, pose: str, tail: str) -> RenderableType:
        arm, q = self._cell.arm, self._cell.poses[pose]
        shown = self._cell.to_file_units(q)
        table = live_table("joint", "deg", "that is", "now")
        for i, joint in enumerate(arm.joint_names):
            now = str(self._bench.sweep_of(joint).now) if joint in self._bench.joints else ""
            table.add_row(joint, f"{shown[i]:.1f}", pose_words(arm, q, i), now)
        head = Text(f"The pose {pose!r} (forward is x of the arm's world, up is z):", style="bold")
        return Group(head, Text(tail), table)

    def _find_gripper(self, name: str) -> tuple[float, float]:
        """Let the gripper be opened and closed, and take where it is."""
        counts = []
        for word in ("Open", "Close"):
            self._watch(partial(self._gripper_picture, name, word), ("enter",))
            self._bench.catch_up()
            counts.append(float(self._bench.sweep_of(name).now))
        return counts[0], counts[1]

    def _gripper_picture(self, name: str, word: str) -> RenderableType:
        return Group(
            Text(f"{word} the gripper by hand, all the way.", style="bold"),
            Text(f"  {name}: {self._bench.sweep_of(name).now} ticks"),
            Text("Enter: there it is; q: leave."),
        )

    def _set(self, fresh: Calibration, ends: tuple[float, float] | None) -> Calibration:
        """Show what is to be written, ask, write and keep it."""
        outcome = Outcome(self._cell, self._bench, fresh, self._show, rehearsal=bool(self._hand))
        outcome.work_out(self._zeros, self._signs, self._zero_by, ends)
        outcome.show()
        self._ask("y: write that and keep it; q: leave, with nothing written.", keys="y")
        made = outcome.carry_out()
        outcome.end(self._arm)
        self._show.say("The torque is still off: support the arm until it is on again.")
        return made

    def _ask(self, *lines: str, keys: Collection[str]) -> None:
        texts = [Text(line) for line in lines]
        self._watch(lambda: Group(*texts, Text("(q: leave)")), keys, look=False)

    def _watch(
        self, picture: Callable[[], RenderableType], keys: Collection[str], *, look: bool = True
    ) -> str:
        """Show what changes, reading the servos meanwhile, until one of some keys is pressed."""
        try:
            return self._look(picture, keys, look=look)
        except OSError as error:
            if isinstance(error, SplinearmError):  # a servo that is silent is a TimeoutError too
                raise
            raise TerminalLostError from error  # it cannot be written to any more

    def _look(
        self, picture: Callable[[], RenderableType], keys: Collection[str], *, look: bool
    ) -> str:
        due = 0.0
        with Live(console=self._show.console, auto_refresh=False, transient=True) as live:
            while True:
                if look:
                    self._bench.poll()
                if time.monotonic() >= due:
                    live.update(self._with_hand(picture()), refresh=True)
                    due = time.monotonic() + _DRAWN
                key = self._keys.read(_LOOK)
                if key is not None and key in keys:
                    return key
                if key == "q":
                    raise KeyboardInterrupt
                if key is not None and self._hand is not None and self._hand.take(key):
                    due = 0.0

    def _with_hand(self, picture: RenderableType) -> RenderableType:
        if self._hand is None:
            return picture
        return Group(picture, Text(f"(rehearsal: {self._hand.words})", style="dim"))


def _way(moved: int) -> str:
    return "up" if moved > 0 else "down"
