"""Job files: where an arm shall go, in which way and how fast.

The keys of a job file (``schema = "splinearm-job/1"``)::

    name, title             what it is called, and what it is
    arm                     a shipped arm, or the path of an arm file as seen from the job file
    start or start_deg      a named pose of the arm (default "home"), or one number a joint
    [motion]                for all waypoints; all optional
        through             "bspline" (default), "line", "arc" or "joint": how a waypoint is reached
        facing              "free" (default), "kept" or "tangent": how the tool stands on the way to
                            a waypoint that gives a position only
        speed_mm_s          of the tool; without it as fast as the joints may
        closed              true: back to the start in the end; B-splines make one closed curve
        limits_percent      share of the arm's speed limits that the motion may use (default 100)
        jerk_time_s         time in which a joint's acceleration grows to its limit; without it
                            acceleration may jump, unless the arm's file limits the jerk
        tool_acceleration_mm_s2   highest acceleration of the tool
        torque_percent      share of the joints' torques that the motion may use, by the masses in
                            the arm's file; without it torques are not looked at
        rate_hz             setpoints a second (default 100)
        feedforward         "off", "velocity" or "full": by what servos' goals are ahead of their
                            setpoints; without it as the arm's file says
        position_tolerance_mm   how far the tool may be off the wanted curve (default 0.02)
        timing              of pieces that were taught: "recorded" (default) or "fastest"
        times               how often all of it is carried out (default 1), or "endless"
    [tolerance]             how far the arm may be off before it is stopped; all optional, each one
                            number for all joints or a list with one a joint; joints that slide
                            have keys in ..._deg_mm with one number a joint
        start_deg           from where the motion starts, before anything moves (default 0.25)
        path_deg            from the setpoint on the way (default 8), besides
        lag_s               how long a joint may be behind its setpoint while it moves (default 0.1)
        goal_deg            from the end of the motion (default 5)
        settle_s            how long a joint may take to get there (default 1)
    toolpath                an NC program in place of waypoints; [place] says where it lies, as
                            splinearm.config.nc_program has it
    [[piece]]               pieces in place of waypoints, carried out one after the other, as
                            splinearm.config.piece has them; the arm goes slowly from the end of
                            one to the begin of the next where these differ
    [[waypoint]]            in order; where, and what differs from [motion]
        position_mm, and quat_wxyz or rpy_deg if the orientation matters; or joints_deg
        through, facing, speed_mm_s
        via_mm              of an arc: a point on the way, or
        centre_mm, axis     a point and the direction of its axis, by the right hand; if the end
                            lies farther along the axis it is a helix
        turns               full turns besides (default 0)
        blend_mm            how near to the corner here rounding it may begin (0: it stops there)
        stop, dwell_s       whether to stop here, and for how long
        gripper             what the gripper does here; the arm stops for it, see
                            splinearm.config.piece for this key and those that go with it
        name

Poses are those of the tool in the arm's base frame. For an arm with sliding joints the keys are
``start_deg_mm`` and ``joints_deg_mm``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.resources import files
from os import PathLike
from pathlib import Path
from types import MappingProxyType

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.drivers.feedforward import KINDS
from splinearm.kinematics import Pose
from splinearm.trajectories.taught import TIMINGS, Timing
from splinearm.trajectories.waypoint import ArcAbout, ArcThrough, Facing, Move, Waypoint

from .cell import Cell, load_cell, read_positions, shipped_arms
from .frame import read_quat
from .nc_program import NcProgram, read_program
from .piece import GripAction, Piece, read_grip, read_pieces, start_of
from .reader import Table, read_file
from .unit import positions_key

JOB_SCHEMA = "splinearm-job/1"
"""What a job file says it is."""

_MOVES = [move.value for move in Move]
_FACINGS = [facing.value for facing in Facing]
_MOST_TIMES = 1_000_000


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Job:
    """What a job file says."""

    name: str
    """What it is called."""
    title: str
    """What it is, in words."""
    file: Path
    """The file."""
    arm: Path
    """The file of the arm that it is for."""
    q_start: FloatArray
    """Where the motion starts, shape (n,), rad or m."""
    waypoints: tuple[Waypoint, ...]
    """Where it goes."""
    closed: bool
    """Whether it leads back to the start in the end."""
    limits_share: float
    """Share of the arm's speed limits that it may use, above 0 and at most 1."""
    jerk_time: float | None = None
    """Time in which a joint's acceleration grows to its limit, s; None: as the arm's limits say."""
    tool_acceleration: float | None = None
    """Highest acceleration of the tool, m/s2; None: not limited."""
    torque_share: float | None = None
    """Share of the joints' torques that it may use; None: torques are not looked at."""
    rate: float
    """Setpoints a second, Hz."""
    position_tolerance: float
    """How far the tool may be off the wanted curve, m."""
    feedforward: str | None = None
    """By what servos' goals are ahead of their setpoints; None: as the arm's file says."""
    program: NcProgram | None = None
    """The NC program that it carries out in place of waypoints; None: it has waypoints."""
    grips: Mapping[int, GripAction] = field(default_factory=dict)
    """By number of a waypoint, from 0, what the gripper does there."""
    pieces: tuple[Piece, ...] = ()
    """What it carries out in place of waypoints, one after the other."""
    timing: Timing | None = None
    """How quick motions are that were taught; None: as they were recorded."""
    times: int | None = 1
    """How often all of it is carried out; None: without end."""
    tolerances: Mapping[str, FloatArray] = field(default_factory=dict)
    """How far joints may be off while they move, by what of ``Tolerances`` the file says, each of
    shape (n,): ``start``, ``path`` and ``goal`` in rad or m, ``lag`` and ``settle`` in s."""


@dataclass(frozen=True, slots=True)
class _Motion:
    """What holds for every waypoint that does not say otherwise."""

    move: str
    facing: str
    speed: float | None


def load_job(path: str | PathLike[str], *, arm: str | PathLike[str] | None = None) -> Job:
    """Read a job file.

    Args:
        path: The job file.
        arm: Use this arm (a shipped one or the path of its file) in place of the file that the job
            names, such as a calibrated copy. It must be the same arm by name.

    Raises:
        ConfigError: If the file says something that cannot be used, or is for another arm.
    """
    file = Path(path)
    root = read_file(file, JOB_SCHEMA)
    name, title = root.text("name"), root.text("title")
    cell = _load_arm(root, file, arm)
    says_start = any(
        key in root for key in ("start", positions_key("start", cell.arm.limits.kinds))
    )
    q_start = _read_start(root, cell)
    motion, waypoint_tables = root.table("motion"), root.tables("waypoint")
    piece_tables = root.tables("piece")
    tolerances = _read_tolerances(root.table("tolerance"), cell)
    program = read_program(root, file)
    root.finish()
    _require_one_kind(root, program, waypoint_tables, piece_tables)
    pieces = read_pieces(piece_tables, file, cell, lambda other: load_job(other, arm=cell.file))
    begins = None if says_start else start_of(pieces)
    usual = _read_usual(motion)
    waypoints = [_read_waypoint(table, cell, usual) for table in waypoint_tables]
    job = Job(
        name=name,
        title=title,
        file=file,
        arm=cell.file,
        q_start=q_start if begins is None else begins,
        waypoints=tuple(waypoint for waypoint, _ in waypoints),
        grips=MappingProxyType({i: grip for i, (_, grip) in enumerate(waypoints) if grip}),
        pieces=pieces,
        timing=_read_timing(motion),
        times=_read_times(motion, program),
        closed=motion.flag("closed"),
        limits_share=motion.number("limits_percent", 1.0, above=0.0, high=1.0),
        jerk_time=_optional(motion, "jerk_time_s"),
        tool_acceleration=_optional(motion, "tool_acceleration_mm_s2"),
        torque_share=_optional(motion, "torque_percent", high=1.0),
        rate=motion.number("rate_hz", 100.0, low=1.0, high=2000.0),
        position_tolerance=motion.number("position_tolerance_mm", 2e-5, above=0.0),
        feedforward=motion.choice("feedforward", KINDS) if "feedforward" in motion else None,
        program=program,
        tolerances=tolerances,
    )
    motion.finish()
    return job


def _require_one_kind(
    root: Table,
    program: NcProgram | None,
    waypoints: list[Table],
    pieces: list[Table],
) -> None:
    """Refuse a job that says nothing of what to do, or says it in two ways."""
    kinds = {"toolpath": program is not None, "waypoint": waypoints, "piece": pieces}
    given = [key for key, is_there in kinds.items() if is_there]
    if not given:
        raise root.refuse("waypoint", "is missing; give a [[waypoint]] table for each place")
    if len(given) > 1:
        raise root.refuse(given[1], f"contradicts {given[0]}; take one of them out")


def _read_timing(motion: Table) -> Timing | None:
    """Read how quick taught motions are."""
    if "timing" not in motion:
        return None
    named = motion.choice("timing", TIMINGS)
    return next(timing for timing in TIMINGS if timing == named)


def _read_times(motion: Table, program: NcProgram | None) -> int | None:
    """Read how often all of it is carried out."""
    if "times" not in motion:
        return 1
    if program is not None:
        raise motion.refuse("times", "is not for toolpaths, which cut their work once")
    return motion.integer_or("times", "endless", low=1, high=_MOST_TIMES)


def _read_tolerances(table: Table, cell: Cell) -> Mapping[str, FloatArray]:
    """Read how far joints may be off."""
    limits = cell.arm.limits
    tolerances = {}
    for name in ("start", "path", "goal"):
        key = positions_key(name, limits.kinds)
        if key not in table:
            continue
        if table.is_list(key) or key.endswith("_mm"):
            tolerances[name] = table.positions(name, limits.names, limits.kinds)
        else:
            tolerances[name] = np.full(limits.n, table.number(key))
        _require_above_zero(table, key, tolerances[name])
    for name in ("lag", "settle"):
        key = f"{name}_s"
        if key in table:
            is_list = table.is_list(key)
            one_each = table.numbers(key, limits.n) if is_list else table.number(key)
            tolerances[name] = np.full(limits.n, one_each)
            if name != "lag" or (tolerances[name] < 0.0).any():
                _require_above_zero(table, key, tolerances[name])
    table.finish()
    return MappingProxyType(tolerances)


def _require_above_zero(table: Table, key: str, values: FloatArray) -> None:
    if (values <= 0.0).any():
        raise table.refuse(key, "wants numbers above zero")


def demo_job() -> Job:
    """Give the shipped job: the planar arm draws a closed curve."""
    return load_job(Path(str(files("splinearm.config"))) / "jobs" / "heart.toml")


def _load_arm(root: Table, file: Path, wanted: str | PathLike[str] | None) -> Cell:
    named = root.text("arm")
    own = file.parent / named
    if named not in shipped_arms() and not own.is_file():
        shipped = ", ".join(shipped_arms())
        raise root.refuse("arm", f"{named!r} is no shipped arm ({shipped}) and {own} is no file")
    cell = load_cell(named if named in shipped_arms() else own)
    if wanted is None:
        return cell
    other = load_cell(wanted)
    if other.name != cell.name:
        raise root.refuse(
            "arm", f"this job is for {cell.name!r}, not for {other.name!r} ({other.file})"
        )
    return other


def _read_start(root: Table, cell: Cell) -> FloatArray:
    key = positions_key("start", cell.arm.limits.kinds)
    if key not in root:
        return cell.poses[root.choice("start", cell.poses, "home")]
    if "start" in root:
        raise root.refuse("start", f"says again what {key} says; take one of them out")
    return read_positions(root, "start", cell.arm.limits)


def _read_usual(table: Table) -> _Motion:
    move = table.choice("through", _MOVES, Move.BSPLINE.value)
    facing = table.choice("facing", _FACINGS, Facing.FREE.value)
    return _Motion(move, facing, _read_speed(table))


def _read_speed(table: Table) -> float | None:
    return _optional(table, "speed_mm_s")


def _optional(table: Table, key: str, *, high: float | None = None) -> float | None:
    """Read a number above 0, if it is there."""
    return table.number(key, above=0.0, high=high) if key in table else None


def _read_waypoint(table: Table, cell: Cell, usual: _Motion) -> tuple[Waypoint, GripAction | None]:
    """Read a waypoint, and what the gripper does there."""
    name = table.text("name", "")
    pose, position, q = _read_place(table, cell)
    move = Move(table.choice("through", _MOVES, usual.move))
    own_speed = _read_speed(table)
    speed = usual.speed if own_speed is None else own_speed
    blend = table.number("blend_mm", 0.0, low=0.0)
    dwell = table.number("dwell_s", 0.0, low=0.0)
    stop = table.flag("stop")
    facing = _read_facing(table, usual, move, position)
    arc = _read_arc(table, move)
    grip = read_grip(table)
    table.finish()
    if blend > 0.0:
        resting = {"stop": stop, "dwell_s": dwell > 0.0, "gripper": grip is not None}
        _check_blend(table, move, next((key for key, rests in resting.items() if rests), None))
    waypoint = Waypoint(
        pose=pose,
        position=position,
        q=q,
        move=move,
        arc=arc,
        facing=facing,
        speed=speed,
        blend=blend,
        stop=stop or grip is not None,
        dwell=dwell,
        name=name,
    )
    return waypoint, grip


def _read_facing(table: Table, usual: _Motion, move: Move, position: FloatArray | None) -> Facing:
    """Read how the tool stands; the usual way holds where it can be asked for."""
    asked = "facing" in table
    facing = Facing(table.choice("facing", _FACINGS, usual.facing))
    if position is not None and move is not Move.JOINT:
        return facing
    if asked and facing is not Facing.FREE:
        raise table.refuse(
            "facing", "is for tool moves to a position; a pose or joints say how the tool stands"
        )
    return Facing.FREE


def _read_arc(table: Table, move: Move) -> ArcThrough | ArcAbout | None:
    """Read which arc leads to a waypoint."""
    given = [key for key in ("via_mm", "centre_mm", "axis", "turns") if key in table]
    if move is not Move.ARC:
        if given:
            raise table.refuse(given[0], 'is for arcs; set through = "arc" or take it out')
        return None
    if "via_mm" in given:
        if len(given) > 1:
            raise table.refuse(given[1], "contradicts via_mm; an arc has a via or a centre")
        return ArcThrough(table.numbers("via_mm", 3))
    if "centre_mm" not in given:
        raise table.refuse("via_mm", "is missing, as is centre_mm; an arc needs one of them")
    axis = table.numbers("axis", 3)
    if not axis.any():
        raise table.refuse("axis", "want a direction, got zero")
    return ArcAbout(table.numbers("centre_mm", 3), axis, table.integer("turns", 0, low=0))


def _check_blend(table: Table, move: Move, resting: str | None) -> None:
    """Refuse to round a corner that is stopped at or does not exist."""
    if resting is not None:
        raise table.refuse(
            "blend_mm", f"contradicts {resting}: a corner is rounded or rested at; take one out"
        )
    if move is Move.BSPLINE:
        raise table.refuse(
            "blend_mm",
            'rounds corners, and a B-spline has none; take it out, or set through = "line"',
        )


def _read_place(
    table: Table, cell: Cell
) -> tuple[Pose | None, FloatArray | None, FloatArray | None]:
    """Read where a waypoint is: a pose, a position or joint positions."""
    limits = cell.arm.limits
    joints = positions_key("joints", limits.kinds)
    quat = read_quat(table)
    if joints in table:
        for key in ("position_mm", "quat_wxyz", "rpy_deg"):
            if key in table:
                raise table.refuse(key, f"says again what {joints} says; take one of them out")
        return None, None, read_positions(table, "joints", limits)
    position = table.numbers("position_mm", 3)
    if quat is None:
        return None, position, None
    return Pose(position, quat), None, None
