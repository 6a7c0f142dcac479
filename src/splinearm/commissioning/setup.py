"""From servos fresh out of the box to an arm that is ready: what is found, asked, written, checked.

Every step looks first and skips what is done. What a servo is called is in the servo itself, its
id, and that is the first thing that is written: whoever is stopped anywhere begins again, and
comes to the same end. Nothing here gives a servo torque.
"""

from collections.abc import Sequence
from math import isinf

from splinearm.config import Cell
from splinearm.doctor.roll import FACTORY_ID
from splinearm.drivers.chain import ServoChain, ServoRole, ServoSpec
from splinearm.errors import BusTimeoutError, DeclinedError, ServoError

from .bench import Address, Bench, Found
from .image import ControlImage
from .person import Person
from .search import call_file, factory_baud
from .session import ERRORS, Session, SessionReport
from .survey import Look, Survey
from .task import Change, Task, in_words
from .wish import changes_of, require_firmware, wishes
from .writing import free_id

PATIENCE = 300.0
"""For how long to wait for a person to connect something, s."""

_POLL = 0.2  # s
_WIDE_EVERY = 6
"""How many quick looks are taken to one at all rates."""
_ROUNDS = 3


class Setup:
    """One setup of an arm.

    Args:
        bench: The line.
        cell: The arm, calibrated if it is.
        person: Who is asked.
        one_by_one: Whether not to believe the ids that servos have.
        patience: For how long to wait for a servo to be connected, s.
    """

    def __init__(
        self,
        bench: Bench,
        cell: Cell,
        person: Person,
        *,
        one_by_one: bool = False,
        patience: float = PATIENCE,
    ) -> None:
        if cell.chain is None:
            raise ValueError(f"cell: want an arm with servos, got {cell.name!r}")
        self._bench = bench
        self._cell = cell
        self._chain: ServoChain = cell.chain
        self._person = person
        self._patience = patience
        self._done: set[str] = set()
        self._survey = Survey(bench, cell.chain, self._done, one_by_one=one_by_one)
        self._session = Session(bench, person, cell.name)
        self._told: set[str] = set()
        self._garbled: set[Address] = set()

    @property
    def report(self) -> SessionReport:
        """What was found and done so far."""
        return self._session.report

    def check(self) -> SessionReport:
        """Say what is left to do; nothing at all is written.

        Raises:
            BusError: If the port is gone, or a servo is of another model than the file says.
        """
        look = self._survey.everywhere()
        report = self.report
        report.left += [
            f"{address}: answers are damaged each time, as if two servos had this id (fresh out of "
            "the box all have one): each will be asked for by itself"
            for address in look.garbled
        ]
        report.left += [_mute(one) for one in look.mute]
        report.left += [_missing(servo, look) for servo in look.missing]
        report.notes += [_stranger(one) for one in look.match.strangers]
        report.tasks = self._tasks(look)
        for task in report.tasks:
            report.left += [f"{task.name}: {in_words(change)}" for change in task.changes]
            report.left += [f"{task.name}: reboot to clear: {e}" for e in task.errors]
        return report

    def run(self) -> SessionReport:
        """Set all servos up.

        Raises:
            DeclinedError: If the person does not agree to something.
            BusError: If a servo does not do as it is told, or is none of this arm.
        """
        look = self._give_voice(self._survey.everywhere())
        self._note_strangers(look)
        self._do(look, self._tasks(look))
        if any(not self._is_fresh(address) for address in look.garbled):
            self._survey.one_by_one = True  # an id that two have says nothing
        for servo in self._chain.servos:
            if servo.name not in self._done:
                self._bring_in(servo, look)
                look = self._survey.near(alone=True)
        self._gather()
        return self._session.closed()

    def _tasks(self, look: Look) -> list[Task]:
        """Say what is to be done to the servos that are known."""
        named = look.match.named
        servos = [servo for servo in self._chain.servos if servo.name in named]
        return [self._task(servo, look.images[named[servo.name].address]) for servo in servos]

    def _task(self, servo: ServoSpec, image: ControlImage) -> Task:
        """Say what is to be done to a servo."""
        wanted = wishes(servo, self._chain, image, self._reach(servo))
        status = image.value(ERRORS) or 0
        return Task(
            name=servo.name,
            image=image,
            changes=changes_of(image, wanted),
            servo=servo,
            errors=image.model.hardware_errors(status),
        )

    def _reach(self, servo: ServoSpec) -> tuple[int, int] | None:
        """Give the positions to which the joint of a leader may go, ticks; None: not known."""
        names, limits = self._cell.arm.joint_names, self._cell.arm.limits
        if servo.role is not ServoRole.LEADER or servo.zero_ticks is None:
            return None
        i = names.index(str(servo.joint))
        low, high = float(limits.q_min[i]), float(limits.q_max[i])
        if isinf(low) or isinf(high):
            return None
        per_rad = servo.servo_model.pulses_per_rad
        return round(servo.zero_ticks + low * per_rad), round(servo.zero_ticks + high * per_rad)

    # --- writing

    def _give_voice(self, look: Look) -> Look:
        """Let servos answer that were told not to, so that they can be read."""
        for one in look.mute:
            if not self._person.allows(f"{_mute(one)}; set that to 2, so that it can be read?"):
                raise DeclinedError("a servo that cannot be read cannot be set up; nothing written")
            self._session.let_answer(one)
        return self._survey.everywhere() if look.mute else look

    def _do(self, look: Look, tasks: Sequence[Task]) -> None:
        """Carry out what is to be done to servos that are known."""
        todo = [task for task in tasks if not task.is_done]
        for task in tasks:
            if task.servo is not None:
                require_firmware(task.name, task.image, _wanted(task))
        if todo:
            self._apply(look, todo)
        self._done |= {task.name for task in tasks}
        known = {task.name for task in self.report.tasks}
        self.report.tasks += [task for task in tasks if task.name not in known]

    def _apply(self, look: Look, todo: Sequence[Task]) -> None:
        """Write, with whoever is in the way brought to a free id before."""
        names = {one.address: name for name, one in look.match.named.items()}
        self._session.carry_out([*self._parked(look, todo), *todo], look.images, names)

    def _parked(self, look: Look, todo: Sequence[Task]) -> list[Task]:
        """Give the tasks of those that nobody knows and that have an id which another shall have.

        Raises:
            ServoError: If nothing can be written to such a one.
        """
        ways = {address for task in todo for address in task.path(task.image.address)}
        own = {task.image.address for task in todo}
        reserved = [servo.servo_id for servo in self._chain.servos]
        taken = set(look.images)
        parked: list[Task] = []
        for address in sorted((ways & taken) - own):
            image = look.images[address]
            spare = free_id(taken, reserved)
            taken.add(address._replace(servo_id=spare))
            change = Change(image.model.table["ID"], address.servo_id, spare)
            name = f"{image.found.model_words} ({address}), in the way"
            parked.append(Task(name=name, image=image, changes=(change,)))
        return parked

    def _is_fresh(self, address: Address) -> bool:
        """Tell whether servos fresh out of the box are there, which all have one id."""
        rates = [factory_baud(servo.servo_model) for servo in self._chain.servos]
        return address.servo_id == FACTORY_ID and address.baud in rates

    # --- one by one

    def _bring_in(self, servo: ServoSpec, look: Look) -> None:
        """Let the person connect a servo that is not known yet, and set it up.

        Raises:
            BusTimeoutError: If nobody does.
        """
        stale = self._ask_for(servo, look)
        until = self._bench.clock() + self._patience
        rounds = 0
        while True:
            rounds += 1
            look_on = self._survey.far if rounds % _WIDE_EVERY == 0 else self._survey.near
            look = self._give_voice(look_on(alone=True))
            stale &= {one.address for one in look.match.unknown}
            self._do(look, [t for t in self._tasks(look) if t.name not in self._done])
            if servo.name in self._done:
                return
            one = self._candidate(servo, look)
            if one is not None and one.address not in stale:
                self._do(look, [self._task(servo, look.images[one.address])])
                return
            if self._bench.clock() > until:
                raise BusTimeoutError(servo.servo_id, port=self._bench.port, name=servo.name)
            self._bench.sleep(_POLL)

    def _ask_for(self, servo: ServoSpec, look: Look) -> set[Address]:
        """Let the person connect a servo; give where others are that it must not be taken for."""
        if servo.name in look.match.named:
            return set()
        one = self._candidate(servo, look)
        if one is not None and self._person.is_it(servo, one):
            return set()
        if one is not None:
            self._person.tell(f"Disconnect the servo that is there now ({one.address}).")
        self._person.connects(servo)
        return {one.address for one in look.match.unknown}

    def _candidate(self, servo: ServoSpec, look: Look) -> Found | None:
        """Give the servo that may be the one that was asked for, if it is alone; else say why."""
        for address in self._garbled & set(look.garbled):  # not just while a plug goes in
            self._tell_once(_shared(address))
        self._garbled = set(look.garbled)
        unknown = [*look.match.unknown, *look.match.strangers]
        right = [one for one in look.match.unknown if one.model_number == servo.servo_model.number]
        if len(right) > 1:
            where = ", ".join(str(one.address) for one in right)
            self._tell_once(
                f"{len(right)} servos are there that may be {servo.name} ({where}): leave only it"
            )
        elif not right and unknown:
            there = f"a {unknown[0].model_words} is there ({unknown[0].address})"
            self._tell_once(f"{there}; servo {servo.name} is a {servo.model}")
        return right[0] if len(right) == 1 and not look.garbled else None

    def _gather(self) -> None:
        """See that all are there at last, and that nothing is left to do.

        Raises:
            BusTimeoutError: If not all are connected in time.
            ServoError: If one is otherwise each time.
        """
        until = self._bench.clock() + self._patience
        asked = False
        odd: Sequence[ServoSpec] = ()
        for _ in range(_ROUNDS):
            while len(call_file(self._bench, self._chain).found) < len(self._chain.servos):
                look = self._survey.near()
                for address in look.garbled if asked else ():
                    self._tell_once(_shared(address))
                absent = list(look.match.missing)
                if absent and not asked:
                    self._person.connects_all([servo.name for servo in absent])
                    asked = True
                if absent and self._bench.clock() > until:
                    one = absent[0]
                    raise BusTimeoutError(one.servo_id, port=self._bench.port, name=one.name)
                if absent:
                    self._bench.sleep(_POLL)
            look = self._survey.everywhere()
            tasks = self._tasks(look)
            undone = (self._chain.servo(task.name) for task in tasks if not task.is_done)
            odd = [*look.match.missing, *undone]
            if not odd:
                return
            self._do(look, tasks)
        reason = "it is otherwise each time one looks: check its cables"
        raise ServoError(odd[0].servo_id, reason, name=odd[0].name)

    def _note_strangers(self, look: Look) -> None:
        for one in look.match.strangers:
            self.report.notes.append(_stranger(one))
            self._person.tell(_stranger(one))

    def _tell_once(self, words: str) -> None:
        if words not in self._told:
            self._told.add(words)
            self._person.tell(words)


def _wanted(task: Task) -> dict[str, int]:
    """Give what is to be written into a servo."""
    return {change.register.name: change.new for change in task.changes}


def _shared(address: Address) -> str:
    return f"{address}: answers are damaged each time, as if two servos had this id: leave only one"


def _mute(one: Found) -> str:
    return f"{one.address}: a {one.model_words} answers pings alone (Status Return Level)"


def _missing(servo: ServoSpec, look: Look) -> str:
    words = f"{servo.name}: no {servo.model} answers as id {servo.servo_id}"
    able = [o for o in look.match.unknown if o.model_number == servo.servo_model.number]
    if able:
        words += f"; it may be the one with {able[0].address}: which one it is must be said"
    return words


def _stranger(one: Found) -> str:
    return f"{one.address}: a {one.model_words} that the arm's file does not name; it is left alone"
