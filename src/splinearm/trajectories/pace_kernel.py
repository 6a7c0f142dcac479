"""How the pace of a motion may change without breaking a limit, on bare arrays.

A motion q(tau) is carried out as q(tau(t)): its pace is r = d tau/dt, which changes at the rate
p = dr/dt, which changes at w. By the chain rule, with derivatives of q by tau::

    velocity      q' r
    acceleration  q'' r^2 + q' p
    jerk          q''' r^3 + 3 q'' r p + q' w

The motion itself keeps its limits, so at an even pace of at most 1 nothing can break. Every step
taken here leaves a way back to such a pace, which has been looked at all along: that way is taken
where nothing better is found.

``box`` has for each stretch of the motion and each joint the lowest and highest q', q'' and q''',
shape (k, n, 6); ``edges`` the k + 1 ends of the stretches; ``limits`` rows velocity, acceleration
and jerk (infinite: none), shape (3, n). ``state`` is tau, r, p.
"""

from math import inf, sqrt

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

_SLACK = 1e-9
_MOST_STEPS = 400
_SWING = 0.02
"""By so much may a pace swing past the one that was asked for."""
_GOALS = 5
_NEARER = 0.4
_EFFORTS = 5
_AGAIN = 8
"""So many steps of a way are taken before a quicker one is looked for."""
_LESS = 0.4
_ROUNDING = 1e-12
_FULL = 1.0 + 1e-12


@kernel
def stretch_of(edges: FloatArray, tau: float) -> int:
    """Give the stretch that a moment of the motion lies in."""
    low, high = 0, len(edges) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if edges[middle] <= tau:
            low = middle
        else:
            high = middle
    return low


@kernel
def keeps_limits(box: FloatArray, limits: FloatArray, r: float, p: float, w: float) -> bool:
    """Tell whether a pace and its changes are allowed in a stretch; ``box`` is its own, (n, 6)."""
    if r <= _FULL and p == 0.0 and w == 0.0:
        return True
    square, cube = r * r, r * r * r
    bend, push = 3.0 * r * p, w
    for j in range(limits.shape[1]):
        v_low, v_high, a_low, a_high = box[j, 0], box[j, 1], box[j, 2], box[j, 3]
        if r > _FULL and max(-v_low, v_high) * r > limits[0, j] * (1.0 + _SLACK):
            return False
        first, second = v_low * p, v_high * p
        if max(first, second) + a_high * square > limits[1, j] * (1.0 + _SLACK):
            return False
        if min(first, second) + a_low * square < -limits[1, j] * (1.0 + _SLACK):
            return False
        if limits[2, j] < inf:
            most = box[j, 5] * cube + max(a_low * bend, a_high * bend)
            least = box[j, 4] * cube + min(a_low * bend, a_high * bend)
            most += max(v_low * push, v_high * push)
            least += min(v_low * push, v_high * push)
            if max(most, -least) > limits[2, j] * (1.0 + _SLACK):
                return False
    return True


@kernel
def push_range(
    box: FloatArray, limits: FloatArray, state: FloatArray, effort: float, most: float, h: float
) -> tuple[float, float]:
    """Give the lowest and highest w of a step that jerk and acceleration allow, within +-most.

    With less effort more of the acceleration is left for what comes.
    """
    r, p = state[1], state[2]
    low, high = -most, most
    slowest, fastest = -inf, inf
    for j in range(limits.shape[1]):
        v_low, v_high, a_low, a_high = box[j, 0], box[j, 1], box[j, 2], box[j, 3]
        above = max(limits[1, j] - a_high * r * r, 0.0)
        below = max(limits[1, j] + a_low * r * r, 0.0)
        if v_high > 0.0:
            fastest, slowest = min(fastest, above / v_high), max(slowest, -below / v_high)
        if v_low < 0.0:
            fastest, slowest = min(fastest, -below / v_low), max(slowest, above / v_low)
        if limits[2, j] == inf:
            continue
        bend, cube = 3.0 * r * p, r * r * r
        above = limits[2, j] - (box[j, 5] * cube + max(a_low * bend, a_high * bend))
        below = limits[2, j] + (box[j, 4] * cube + min(a_low * bend, a_high * bend))
        above, below = max(above, 0.0), max(below, 0.0)
        if v_high > 0.0:
            high, low = min(high, above / v_high), max(low, -below / v_high)
        if v_low < 0.0:
            high, low = min(high, -below / v_low), max(low, above / v_low)
    # as far as the jerk allows towards a change that the acceleration allows
    share = 0.5 + 0.48 * effort
    wanted_low, wanted_high = (share * slowest - p) / h, (share * fastest - p) / h
    return min(max(low, wanted_low), high), max(min(high, wanted_high), low)


@kernel
def copy(state: FloatArray, to: FloatArray) -> None:
    """Write a state into another; a slice would do, but takes seconds to compile."""
    for i in range(3):
        to[i] = state[i]


@kernel
def advance(state: FloatArray, w: float, h: float) -> None:
    """Move a state on by a step of even w."""
    tau, r, p = state[0], state[1], state[2]
    state[0] = tau + h * (r + h * (0.5 * p + h * w / 6.0))
    state[1] = r + h * (p + 0.5 * h * w)
    state[2] = p + h * w


@kernel
def step_is_allowed(
    edges: FloatArray, box: FloatArray, limits: FloatArray, before: FloatArray, after: FloatArray,
    w: float,
) -> bool:  # fmt: skip
    """Tell whether all limits hold on the step between two states."""
    if after[1] < 0.0 or after[0] < before[0]:
        return False
    last = len(box)
    i = stretch_of(edges, before[0])
    while i < last and edges[i] <= after[0]:
        if not keeps_limits(box[i], limits, before[1], before[2], w):
            return False
        if not keeps_limits(box[i], limits, after[1], after[2], w):
            return False
        i += 1
    return True


@kernel
def free_push(box: FloatArray, limits: FloatArray, most: float) -> float:
    """Give the w that the jerk limits would allow in a stretch if the motion had no jerk itself."""
    free = most
    for j in range(limits.shape[1]):
        speed = max(-box[j, 0], box[j, 1])
        if speed * free > limits[2, j]:
            free = limits[2, j] / speed
    return free


@kernel
def push_towards(
    edges: FloatArray, box: FloatArray, limits: FloatArray, state: FloatArray, target: float,
    effort: float, most: float, h: float,
) -> float:  # fmt: skip
    """Give the w that leads a pace to a target, and there to rest, with a share of the effort."""
    stretch = box[stretch_of(edges, state[0])]
    low, high = push_range(stretch, limits, state, effort, most, h)
    gap, p = target - state[1], state[2]
    # two steps that end exactly there
    first: float = (gap - 1.5 * p * h) / (h * h)
    second = -(p / h + first)
    if low <= first <= high and low <= second <= high:
        return first
    # otherwise as fast as it can still be caught
    room = effort * free_push(stretch, limits, most)
    fastest: float = sqrt(2.0 * room * abs(gap)) * (1.0 if gap > 0.0 else -1.0)
    push: float = min(max((fastest - p) / h, low, -room), high, room)
    return push


@kernel
def reaches(
    edges: FloatArray, box: FloatArray, limits: FloatArray, begin: FloatArray, target: float,
    effort: float, most: float, h: float, work: FloatArray,
) -> bool:  # fmt: skip
    """Tell whether a pace of at most 1 is reached from a state by such pushes within the limits.

    A way that swings far past it does not count.
    """
    here, after = work[0], work[1]
    copy(begin, here)
    side = 1.0 if begin[1] >= target else -1.0
    for _ in range(_MOST_STEPS):
        if (here[2] == 0.0 and here[1] == target) or here[0] >= edges[-1]:
            return True
        w = push_towards(edges, box, limits, here, target, effort, most, h)
        copy(here, after)
        advance(after, w, h)
        clean(after, target)
        if side * (target - after[1]) > _SWING:
            return False
        if not step_is_allowed(edges, box, limits, here, after, w):
            return False
        copy(after, here)
    return False


@kernel
def clean(state: FloatArray, target: float) -> None:
    """Take out what rounding leaves of a pace that has settled."""
    if abs(state[2]) < _ROUNDING and abs(state[1] - target) < _ROUNDING:
        state[1] = target
        state[2] = 0.0


@kernel
def choose_push(
    edges: FloatArray, box: FloatArray, limits: FloatArray, state: FloatArray, command: FloatArray,
    work: FloatArray,
) -> float:  # fmt: skip
    """Give the w of the next step towards a pace; there is a way on from where it leads.

    ``command`` is the pace, the step, the highest w, and where the way on is kept: the pace that it
    leads to and its effort.
    """
    target, h, most = command[0], command[1], command[2]
    after, goal = work[2], target
    for _ in range(_GOALS):
        effort = 1.0
        for _attempt in range(_EFFORTS):
            w = push_towards(edges, box, limits, state, goal, effort, most, h)
            copy(state, after)
            advance(after, w, h)
            clean(after, goal)
            if step_is_allowed(edges, box, limits, state, after, w) and reaches(
                edges, box, limits, after, min(goal, 1.0), effort, most, h, work
            ):
                command[3], command[4] = min(goal, 1.0), effort
                return w
            effort *= _LESS
        # not all the way yet: as far as it goes
        goal = state[1] + _NEARER * (goal - state[1])
    return push_towards(edges, box, limits, state, command[3], command[4], most, h)


@kernel
def step_into(
    edges: FloatArray, box: FloatArray, limits: FloatArray, command: FloatArray, state: FloatArray,
    work: FloatArray,
) -> float:  # fmt: skip
    """Move a state on by one step towards a pace; give its w."""
    w = choose_push(edges, box, limits, state, command, work)
    advance(state, w, command[1])
    clean(state, command[0])
    clean(state, command[3])
    return w


@kernel
def run_into(
    edges: FloatArray, box: FloatArray, limits: FloatArray, command: FloatArray, state: FloatArray,
    work: FloatArray, out: FloatArray,
) -> int:  # fmt: skip
    """Write the states and w of steps until a pace of at most 1 is met or the motion ends.

    Gives how many they are.
    ``out`` has rows tau, r, p, w; if it is too short its length is given.
    """
    for i in range(len(out)):
        copy(state, out[i])
        if (state[1] == command[0] and state[2] == 0.0) or state[0] >= edges[-1]:
            out[i, 3] = 0.0
            return i + 1
        if i % _AGAIN == 0:
            w = choose_push(edges, box, limits, state, command, work)
        else:
            # the way on has been looked at already
            w = push_towards(
                edges, box, limits, state, command[3], command[4], command[2], command[1]
            )
        out[i, 3] = w
        advance(state, w, command[1])
        clean(state, command[3])
    return len(out)
