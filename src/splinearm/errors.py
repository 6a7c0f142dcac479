"""Every error that splinearm raises on purpose.

A wrong argument is a ``ValueError`` or ``TypeError`` where the value enters. What files, arms and
servos do is one of these; each keeps its facts as fields in SI and speaks in the user's units::

    SplinearmError
    ├── ConfigError               a file says something that cannot be used
    ├── CalibrationError          an arm cannot be calibrated as it is mounted, or as it was moved
    ├── KinematicsError
    │   ├── UnreachableError      no joint angles within the limits reach the pose
    │   ├── PathError             no branch follows a path of the tool to its end
    │   └── SingularityError      the arm has lost a direction there
    ├── TrajectoryError
    │   ├── LimitError            a motion would break a limit of a joint
    │   │   └── HoldError         a joint cannot hold the arm somewhere on its path
    │   └── CurveError            a curve that cannot be made or asked there
    │       └── StillError        nothing moves in a recording
    ├── ToolpathError
    │   ├── DrawingError          a drawing cannot be read or cut
    │   ├── ContourError          contours cross or lie where they cannot
    │   ├── OffsetError           an offset cannot be made that passes its check
    │   ├── GougeError            a toolpath would cut into the part
    │   └── GcodeError            an NC program says what cannot be done
    ├── BusError
    │   ├── PortError             the serial port cannot be used
    │   ├── BusTimeoutError       a servo does not answer (also a ``TimeoutError``)
    │   ├── SilentBusError        no servo answers (also a ``TimeoutError``)
    │   ├── PacketError           bytes came that were not the awaited ones
    │   └── ServoError            a servo refused, reported a fault or is not as the file says
    │       └── HealthError       a servo is too hot, badly fed or overloaded to go on
    ├── MotionError
    │   ├── StartError            the arm is not where the motion starts
    │   ├── FollowingError        the arm does not keep up with the motion
    │   └── StaleFeedbackError    what the arm last said is too old
    ├── DeclinedError             a person did not agree to what a command would do
    └── TerminalLostError         the terminal in which a command ran was closed
"""

from math import pi
from os import PathLike


class SplinearmError(Exception):
    """Base of every error that splinearm raises on purpose."""


class ConfigError(SplinearmError):
    """A file says something that cannot be used."""

    def __init__(self, file: str | PathLike[str], key: str, reason: str) -> None:
        self.file = str(file)
        self.key = key
        self.reason = reason
        where = f"{self.file}: {key}" if key else self.file
        super().__init__(f"{where}: {reason}")


class CalibrationError(SplinearmError):
    """An arm cannot be calibrated as it is mounted, or as it was moved."""

    def __init__(self, whose: str, reason: str) -> None:
        self.whose = whose
        self.reason = reason
        super().__init__(f"{whose} {reason}")


class KinematicsError(SplinearmError):
    """Base of what goes wrong between joint angles and poses."""


class UnreachableError(KinematicsError):
    """No joint angles within the limits reach the pose."""

    def __init__(
        self,
        position_error: float,
        orientation_error: float,
        joint: str | None = None,
        reason: str = "",
        what: str = "the pose",
    ) -> None:
        """Take the facts.

        Args:
            position_error: By how much the nearest answer misses the position, m; 0: not at all.
            orientation_error: By how much it misses the orientation, rad; 0: not at all.
            joint: The joint whose limit is in the way, if one is.
            reason: Why, and what would help, in the user's units.
            what: What cannot be reached ("waypoint 3").
        """
        self.position_error = position_error
        self.orientation_error = orientation_error
        self.joint = joint
        self.reason = reason
        self.what = what
        misses = []
        if position_error > 0.0 or orientation_error == 0.0:
            misses.append(f"{position_error * 1e3:.4g} mm")
        if orientation_error > 0.0:
            misses.append(f"{orientation_error * 180.0 / pi:.4g} deg")
        message = f"{what} is out of reach by {' and '.join(misses)}"
        super().__init__(f"{message}: {reason}" if reason else message)


class PathError(KinematicsError):
    """No branch follows a path of the tool to its end."""

    def __init__(self, point: int, reason: str, joint: str | None = None) -> None:
        """Take the facts.

        Args:
            point: The first point that could not be followed to, counted from 0.
            reason: Where and why the path ends, in the user's units.
            joint: The joint whose limit or jump is in the way, if one is.
        """
        self.point = point
        self.reason = reason
        self.joint = joint
        super().__init__(f"no branch follows the path to its end: {reason}")


class SingularityError(KinematicsError):
    """The arm has lost a direction of motion there."""

    def __init__(self, q: object, manipulability: float) -> None:
        self.q = q
        self.manipulability = manipulability
        super().__init__(
            f"the arm is singular there (manipulability {manipulability:.3g}); "
            "move the path away from it or bend a joint"
        )


class TrajectoryError(SplinearmError):
    """Base of what goes wrong with curves and motions."""


# unit name and how many of it an SI unit holds, by quantity, for turning and sliding joints
_ANGULAR = {
    "position": ("deg", 180.0 / pi),
    "velocity": ("deg/s", 180.0 / pi),
    "acceleration": ("deg/s2", 180.0 / pi),
    "jerk": ("deg/s3", 180.0 / pi),
    "torque": ("N m", 1.0),
}
_LINEAR = {
    "position": ("mm", 1e3),
    "velocity": ("mm/s", 1e3),
    "acceleration": ("mm/s2", 1e3),
    "jerk": ("mm/s3", 1e3),
    "torque": ("N", 1.0),
}
_REMEDY = {"position": "move the waypoint or start elsewhere"}


def _position(value: float, *, linear: bool) -> str:
    """Give the position of a joint in the unit people use."""
    unit, per_si = (_LINEAR if linear else _ANGULAR)["position"]
    return f"{value * per_si:.4g} {unit}"


class LimitError(TrajectoryError):
    """A motion would break a limit of a joint."""

    def __init__(
        self,
        joint: str,
        quantity: str,
        value: float,
        limit: float,
        t: float | None = None,
        *,
        linear: bool = False,
    ) -> None:
        """Take the facts.

        Args:
            joint: Name of the joint.
            quantity: "position", "velocity", "acceleration", "jerk" or "torque".
            value: What the motion asks for, in SI.
            limit: What the joint may do, in SI; of a symmetric limit its magnitude.
            t: When in the motion, s.
            linear: Whether the joint slides.
        """
        self.joint = joint
        self.quantity = quantity
        self.value = value
        self.limit = limit
        self.t = t
        unit, per_si = (_LINEAR if linear else _ANGULAR)[quantity]
        if quantity != "position":
            limit = -abs(limit) if value < 0.0 else abs(limit)
        relation = "above" if value > limit else "below"
        when = "" if t is None else f" at t = {t:.3f} s"
        super().__init__(
            f"joint {joint!r}: {quantity} {value * per_si:.6g} {unit} is {relation} its limit "
            f"{limit * per_si:.6g} {unit}{when}; {_REMEDY.get(quantity, 'slow the motion down')}"
        )


class HoldError(LimitError):
    """A joint cannot hold the arm somewhere on its path, however slowly that is followed."""

    def __init__(
        self, joint: str, value: float, limit: float, where: str, *, linear: bool = False
    ) -> None:
        """Take the facts: the torque it takes to hold the arm, that of the joint, and where."""
        super().__init__(joint, "torque", value, limit, linear=linear)
        self.where = where
        unit = (_LINEAR if linear else _ANGULAR)["torque"][0]
        self.args = (
            f"joint {joint!r} cannot hold the arm at {where}: that takes {abs(value):.6g} {unit} "
            f"and it has {limit:.6g} {unit}; lighten the load or lead the path elsewhere",
        )


class CurveError(TrajectoryError):
    """A curve that cannot be made from what was given, or cannot be asked there."""

    def __init__(self, what: str, where: str = "") -> None:
        self.what = what
        self.where = where
        super().__init__(f"{where}: {what}" if where else what)


class StillError(CurveError):
    """Nothing moves in a recording."""

    def __init__(self, seconds: float) -> None:
        """Take the facts: how long it is, s."""
        self.seconds = seconds
        super().__init__(f"nothing moves in it, {seconds:.1f} s long", "recording")


class ToolpathError(SplinearmError):
    """Base of what goes wrong between a drawing and a cut part."""


class DrawingError(ToolpathError):
    """A drawing cannot be read or cut."""

    def __init__(self, file: str, where: str, reason: str) -> None:
        """Take the facts.

        Args:
            file: The drawing.
            where: The entity, line or attribute that is wrong; "" for the whole file.
            reason: What is wrong and what would help.
        """
        self.file = file
        self.where = where
        self.reason = reason
        super().__init__(f"{file}: {where}: {reason}" if where else f"{file}: {reason}")


class ContourError(ToolpathError):
    """Contours cross or lie where they cannot."""

    def __init__(self, what: str, where: tuple[float, float]) -> None:
        """Take the facts: what is wrong, and the place, m."""
        self.what = what
        self.where = where
        super().__init__(f"{what} at ({where[0] * 1e3:.6g}, {where[1] * 1e3:.6g}) mm")


class OffsetError(ToolpathError):
    """An offset cannot be made that passes its check."""

    def __init__(self, distance: float, what: str, where: tuple[float, float]) -> None:
        """Take the facts: the distance, m, what is wrong with the result, and the place, m."""
        self.distance = distance
        self.what = what
        self.where = where
        super().__init__(
            f"the offset by {distance * 1e3:.6g} mm: {what} at "
            f"({where[0] * 1e3:.6g}, {where[1] * 1e3:.6g}) mm"
        )


class GougeError(ToolpathError):
    """A toolpath would cut into the part."""

    def __init__(self, where: tuple[float, float], depth: float, remedy: str = "") -> None:
        """Take the facts.

        Args:
            where: The place, m.
            depth: How deep it would cut, m.
            remedy: What would help.
        """
        self.where = where
        self.depth = depth
        x, y = where
        super().__init__(
            f"the toolpath would cut {depth * 1e3:.6g} mm into the part at "
            f"({x * 1e3:.6g}, {y * 1e3:.6g}) mm" + (f"; {remedy}" if remedy else "")
        )


class GcodeError(ToolpathError):
    """An NC program says what cannot be understood or done."""

    def __init__(self, file: str, line: int, word: str, reason: str) -> None:
        """Take the facts.

        Args:
            file: The program.
            line: The line, from 1.
            word: The word in it that is wrong; "" for the whole line.
            reason: What is wrong and what would help.
        """
        self.file = file
        self.line = line
        self.word = word
        self.reason = reason
        at = f"{file}:{line}: {word}: " if word else f"{file}:{line}: "
        super().__init__(at + reason)


class BusError(SplinearmError):
    """Base of what goes wrong between the computer and the servos."""


class PortError(BusError):
    """The serial port cannot be used."""

    def __init__(self, port: str, reason: str, remedy: str) -> None:
        self.port = port
        self.reason = reason
        self.remedy = remedy
        super().__init__(f"port {port}: {reason}; {remedy}")


class BusTimeoutError(BusError, TimeoutError):
    """A servo does not answer."""

    def __init__(
        self, servo_id: int, register: str = "", *, port: str = "", name: str = ""
    ) -> None:
        """Take the facts.

        Args:
            servo_id: The servo that does not answer.
            register: What was asked of it, if it was a register.
            port: The port it was asked on.
            name: What the arm file calls the servo.
        """
        self.servo_id = servo_id
        self.register = register
        self.port = port
        self.name = name
        servo = f"servo {servo_id}" + (f" ({name})" if name else "")
        asked = f" when asked for {register}" if register else ""
        where = f" on {port}" if port else ""
        super().__init__(
            f"{servo} does not answer{asked}{where}; check its power, its cable and its id, "
            "and the baud rate"
        )


class SilentBusError(BusError, TimeoutError):
    """No servo answers."""

    def __init__(self, port: str) -> None:
        self.port = port
        super().__init__(
            f"no servo answers on {port}; check the servos' supply, the cable from the adapter to "
            "the first of them, and the baud rate"
        )


class PacketError(BusError):
    """Bytes came that were not the awaited ones."""

    def __init__(self, expected: str, actual: str) -> None:
        self.expected = expected
        self.actual = actual
        super().__init__(f"the bus answered {actual} where {expected} was awaited")


class ServoError(BusError):
    """A servo refused an instruction, reported a fault, or is not as the arm file says."""

    def __init__(
        self, servo_id: int, reason: str, *, code: int = 0, alert: bool = False, name: str = ""
    ) -> None:
        """Take the facts.

        Args:
            servo_id: The servo.
            reason: What it refused or reported, and what would help.
            code: The error number of its status packet; 0 if there was none.
            alert: Whether its alert bit was set (a hardware error is latched).
            name: What the arm file calls the servo.
        """
        self.servo_id = servo_id
        self.reason = reason
        self.code = code
        self.alert = alert
        self.name = name
        super().__init__(f"servo {servo_id}{f' ({name})' if name else ''}: {reason}")


class HealthError(ServoError):
    """A servo is too hot, badly fed or overloaded to go on; it still holds."""

    def __init__(  # noqa: PLR0913 - its facts
        self,
        servo_id: int,
        joint: str,
        quantity: str,
        value: float,
        limit: float,
        *,
        unit: str,
        remedy: str,
        low: bool = False,
        name: str = "",
    ) -> None:
        """Take the facts.

        Args:
            servo_id: The servo.
            joint: The joint that it moves.
            quantity: "temperature", "supply", "current" or "load".
            value: What it is, in ``unit``.
            limit: From where on the arm stops, in ``unit``.
            unit: "degC", "V", "A" or "%".
            remedy: What would help.
            low: Whether the limit is a lowest one.
            name: What the arm file calls the servo.
        """
        relation = "at or below" if low else "at or above"
        super().__init__(
            servo_id,
            f"joint {joint!r}: {quantity} {value:.4g} {unit} is {relation} {limit:.4g} {unit}, "
            f"where the arm stops; {remedy}",
            name=name,
        )
        self.joint = joint
        self.quantity = quantity
        self.value = value
        self.limit = limit
        self.unit = unit
        self.remedy = remedy


class MotionError(SplinearmError):
    """Base of what goes wrong while an arm moves."""

    stopped: object = None
    """Where on its path the motion was left, and what remains of it: a ``StoppedMotion``."""


class StartError(MotionError):
    """The arm is not where the motion starts."""

    def __init__(
        self,
        joint: str,
        wanted: float,
        measured: float,
        tolerance: float,
        *,
        linear: bool = False,
    ) -> None:
        """Take the facts: positions in rad, of a joint that slides (``linear``) in m."""
        self.joint = joint
        self.wanted = wanted
        self.measured = measured
        self.tolerance = tolerance
        super().__init__(
            f"joint {joint!r} is at {_position(measured, linear=linear)} but the motion starts at "
            f"{_position(wanted, linear=linear)} (allowed {_position(tolerance, linear=linear)}); "
            "plan an approach first or let one be planned"
        )


class FollowingError(MotionError):
    """The arm does not keep up with the motion."""

    def __init__(
        self,
        joint: str,
        wanted: float,
        measured: float,
        tolerance: float,
        t: float,
        *,
        linear: bool = False,
    ) -> None:
        """Take the facts: positions in rad, of a joint that slides (``linear``) in m; time in s."""
        self.joint = joint
        self.wanted = wanted
        self.measured = measured
        self.tolerance = tolerance
        self.t = t
        super().__init__(
            f"joint {joint!r} is at {_position(measured, linear=linear)} where "
            f"{_position(wanted, linear=linear)} was wanted at t = {t:.3f} s "
            f"(allowed {_position(tolerance, linear=linear)} off); "
            "look for a collision or an overload, or move slower"
        )


class StaleFeedbackError(MotionError):
    """What the arm last said is too old to go on."""

    def __init__(self, age: float, allowed: float, cause: str = "") -> None:
        """Take the facts: ages in s, and what was the last thing that went wrong."""
        self.age = age
        self.allowed = allowed
        self.cause = cause
        super().__init__(
            f"no feedback for {age * 1e3:.0f} ms (allowed {allowed * 1e3:.0f} ms)"
            + (f": {cause}" if cause else "; check cable and power")
        )


class DeclinedError(SplinearmError):
    """A person did not agree; nothing more was written."""

    def __init__(self, what: str) -> None:
        """Take what was not agreed to."""
        self.what = what
        super().__init__(what)


class TerminalLostError(SplinearmError):
    """The terminal in which a command ran was closed."""

    def __init__(self) -> None:
        super().__init__("the terminal was closed")
