"""Edges between nodes made into closed loops, compiled.

What is to remain lies to the left of every edge. Where rounding has kept an edge too many or one
too few, the fewest doubtful ones are dropped or taken that let every node be left as often as it is
reached; where that is impossible there is no answer.
"""

import math

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.compiled import bare_kernel, fast_kernel

from .arc_kernel import at_share, distance
from .arrangement_kernel import SNAP, edges_of, root
from .offset_corner_kernel import Corner, kites_of
from .offset_kernel import raw_pieces
from .offset_left_kernel import surviving
from .tree_kernel import heart_of

_SHORT = 1e-7
"""Edges shorter than this may be dropped to let loops close."""
_TIE = 1e-6
_HALF = math.pi * (1.0 + 1e-9)


@fast_kernel
def _chain(E: FloatArray, column: int, nodes: int) -> tuple[FloatArray, FloatArray]:
    """Give the first edge at each node, and of each edge the next at its node; -1: none."""
    head, after = np.full(nodes, -1.0), np.empty(E.shape[0])
    for e in range(E.shape[0]):
        at = int(E[e, column])
        after[e] = head[at]
        head[at] = e
    return head, after


@bare_kernel
def _cancel(E: FloatArray, S: FloatArray, head: FloatArray, after: FloatArray) -> None:
    """Drop edges that lie on each other: both that run against each other, one of equal ones."""
    for e in range(E.shape[0]):
        if E[e, 5] != 2.0:
            continue
        x, y = at_share(S, int(E[e, 2]), 0.5 * (E[e, 3] + E[e, 4]))
        for against in range(2):
            f = int(head[int(E[e, 1 - against])])
            while f >= 0 and E[e, 5] == 2.0:
                joins = f != e and E[f, 5] == 2.0 and E[f, 1] == E[e, against]
                if joins and distance(S, int(E[f, 2]), x, y) <= 8.0 * SNAP:
                    E[f, 5] = 0.0
                    if against == 0:
                        E[e, 5] = 0.0
                f = int(after[f])


@fast_kernel
def _cancel_near(E: FloatArray, X: FloatArray, S: FloatArray) -> None:
    """Drop one of two edges that lie along each other, if where they end short edges part them.

    Where a line touches an arc, what is snapped together along it may have been parted again.
    """
    one = np.arange(float(X.shape[0]))
    for e in range(E.shape[0]):
        a, b = int(E[e, 0]), int(E[e, 1])
        if E[e, 5] > 0.0 and math.hypot(X[a, 0] - X[b, 0], X[a, 1] - X[b, 1]) < _SHORT:
            a, b = root(one, a), root(one, b)
            one[max(a, b)] = min(a, b)
    head, after = np.full(X.shape[0], -1.0), np.empty(E.shape[0])
    for e in range(E.shape[0]):
        begin, end = root(one, int(E[e, 0])), root(one, int(E[e, 1]))
        if E[e, 5] != 2.0 or begin == end:
            continue
        x, y = at_share(S, int(E[e, 2]), 0.5 * (E[e, 3] + E[e, 4]))
        f = int(head[begin])
        while f >= 0 and E[e, 5] == 2.0:
            i = int(E[f, 2])
            if root(one, int(E[f, 1])) == end and distance(S, i, x, y) <= 8.0 * SNAP:
                E[e, 5] = 0.0
            f = int(after[f])
        if E[e, 5] == 2.0:
            after[e], head[begin] = head[begin], e


@fast_kernel
def _balance(E: FloatArray, X: FloatArray) -> int:
    """Take or drop doubtful edges until all nodes are left as often as reached.

    Returns:
        -1, or a node where that is impossible.
    """
    nodes = X.shape[0]
    extra = np.zeros(nodes)
    for e in range(E.shape[0]):
        if E[e, 5] == 2.0:
            extra[int(E[e, 0])] -= 1.0
            extra[int(E[e, 1])] += 1.0
    wrong = 0
    for node in range(nodes):
        if extra[node] > 0.0:
            wrong += 1
    if wrong == 0:
        return -1
    out, out_after = _chain(E, 0, nodes)
    into, into_after = _chain(E, 1, nodes)
    came, seen, queue = np.empty(nodes), np.full(nodes, -1.0), np.empty(nodes)
    for node in range(nodes):
        while extra[node] > 0.0:
            # breadth first: over edges that may be taken, and back over those that may be dropped
            queue[0], first, last, target = node, 0, 1, -1
            seen[node] = node
            while first < last and target < 0:
                at = int(queue[first])
                first += 1
                for back in range(2):
                    e = int(into[at]) if back else int(out[at])
                    while e >= 0:
                        to = int(E[e, 0]) if back else int(E[e, 1])
                        may = E[e, 5] == 1.0
                        if back:
                            length = math.hypot(X[to, 0] - X[at, 0], X[to, 1] - X[at, 1])
                            may = E[e, 5] == 2.0 and length < _SHORT
                        if may and seen[to] != node:
                            seen[to] = node
                            came[to] = e
                            queue[last] = to
                            last += 1
                            if extra[to] < 0.0:
                                target = to
                                break
                        e = int(into_after[e]) if back else int(out_after[e])
                    if target >= 0:
                        break
            if target < 0:
                return node
            extra[node] -= 1.0
            extra[target] += 1.0
            at = target
            while at != node:
                e = int(came[at])
                if E[e, 5] == 1.0:
                    E[e, 5] = 2.0
                    at = int(E[e, 0])
                else:
                    E[e, 5] = 1.0
                    at = int(E[e, 1])
    return -1


@bare_kernel
def _way(S: FloatArray, i: int, u: float) -> tuple[float, float]:
    """Give the direction of a piece at a share, of length 1 but for rounding."""
    x, y = at_share(S, i, u)
    k = S[i, 4]
    return S[i, 6] - k * (y - S[i, 1]), -(S[i, 5] - k * (x - S[i, 0]))


@bare_kernel
def _next_edge(
    E: FloatArray, S: FloatArray, e: int, outgoing: tuple[FloatArray, FloatArray], start: int
) -> int:
    """Give the edge that goes on farthest to the left, or -1."""
    head, after = outgoing
    f = int(head[int(E[e, 1])])
    best, angle, bend = -1, 0.0, 0.0
    alone = True
    while f >= 0:
        if E[f, 5] == 2.0 or f == start:
            if best >= 0 and alone:
                angle, bend = _turn_into(E, S, e, best)
                alone = False
            if best < 0:
                best = f
            else:
                turn, k = _turn_into(E, S, e, f)
                if turn > angle + _TIE or (turn > angle - _TIE and k > bend):
                    best, angle, bend = f, turn, k
        f = int(after[f])
    return best


@bare_kernel
def _turn_into(E: FloatArray, S: FloatArray, e: int, f: int) -> tuple[float, float]:
    """Give how far the way turns left from one edge into another, and the other's curvature."""
    i, j = int(E[e, 2]), int(E[f, 2])
    tx, ty = _way(S, i, E[e, 4])
    vx, vy = _way(S, j, E[f, 3])
    turn = math.atan2(tx * vy - ty * vx, tx * vx + ty * vy)
    if abs(turn) > math.pi - _TIE:
        # straight back: to the left if it bends away to the left of the way that came
        turn = math.pi if S[i, 4] + S[j, 4] < 0.0 else -math.pi
    return turn, S[j, 4]


@fast_kernel
def loops_of(
    E: FloatArray, X: FloatArray, S: FloatArray, numbers: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, int]:
    """Give the closed loops of edges, one line or arc for what is one.

    Args:
        E: Edges; their ranks are used up.
        X: Nodes.
        S: Pieces.
        numbers: Of each piece a number that is the same along one line or arc.

    Returns:
        Rows (x, y, bulge, number) of the vertices and what begins there, loop after loop; the first
        row of each loop and how many there are; the area of each loop, that of one running
        clockwise negative; and -1, or a node where no loop can be closed.
    """
    nodes = X.shape[0]
    head, after = _chain(E, 0, nodes)
    _cancel(E, S, head, after)
    wrong = _balance(E, X)
    if wrong >= 0:
        _cancel_near(E, X, S)
        wrong = _balance(E, X)
    V, starts, areas = np.empty((E.shape[0] + 2, 4)), np.empty(E.shape[0] + 1), np.empty(E.shape[0])
    starts[0] = 0
    if wrong >= 0:
        return V[:0], starts[:1], areas[:0], wrong
    way = np.empty(E.shape[0])
    loops, rows = _loops((E, X, S, numbers), (head, after), way, (V, starts, areas))
    return V[:rows], starts[: loops + 1], areas[:loops], -1


@bare_kernel
def _loops(
    graph: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    outgoing: tuple[FloatArray, FloatArray],
    way: FloatArray,
    written: tuple[FloatArray, FloatArray, FloatArray],
) -> tuple[int, int]:
    """Walk all loops and write them; give how many there are, and how many rows."""
    E, X, S, numbers = graph
    V, starts, areas = written
    loops, rows = 0, 0
    for start in range(E.shape[0]):
        if E[start, 5] != 2.0:
            continue
        count, e = 0, start
        while True:
            way[count] = e
            count += 1
            E[e, 5] = 0.0
            e = _next_edge(E, S, e, outgoing, start)
            if e == start or e < 0:
                break
        rows, area, length = _write_loop(E, X, S, numbers, (way, count), V, rows)
        if abs(area) <= 4.0 * SNAP * length:
            rows = int(starts[loops])  # it encloses nothing
            continue
        areas[loops] = area
        loops += 1
        starts[loops] = rows
    return loops, rows


@bare_kernel
def _turn_of(E: FloatArray, X: FloatArray, S: FloatArray, e: int) -> float:
    """Give by how much an edge turns."""
    a, b = int(E[e, 0]), int(E[e, 1])
    c = math.sqrt((X[a, 0] - X[b, 0]) ** 2 + (X[a, 1] - X[b, 1]) ** 2)
    return 2.0 * math.asin(max(-1.0, min(1.0, 0.5 * S[int(E[e, 2]), 4] * c)))


@bare_kernel
def _write_loop(
    E: FloatArray,
    X: FloatArray,
    S: FloatArray,
    numbers: FloatArray,
    loop: tuple[FloatArray, int],
    V: FloatArray,
    rows: int,
) -> tuple[int, float, float]:
    """Write a loop; give how many rows there are then, its area and its length."""
    way, count = loop
    first = 0
    for k in range(count):
        if not _one(E, S, numbers, int(way[k - 1 if k > 0 else count - 1]), int(way[k])):
            first = k
            break
    area, length, turn = 0.0, 0.0, 0.0
    last = -1
    for k in range(count + 1):
        e = int(way[(first + k) % count])
        bend = _turn_of(E, X, S, e)
        if k < count and last >= 0 and abs(turn + bend) <= _HALF and _one(E, S, numbers, last, e):
            turn += bend
            last = e
            continue
        if last >= 0:
            V[rows - 1, 2] = math.tan(0.25 * turn)
            a, b = int(V[rows - 1, 3]), int(E[e, 0])
            V[rows - 1, 3] = numbers[int(E[last, 2])]
            cross, c = (
                X[a, 0] * X[b, 1] - X[a, 1] * X[b, 0],
                math.hypot(X[b, 0] - X[a, 0], X[b, 1] - X[a, 1]),
            )
            # Green's theorem: the triangle to the origin and the segment of the circle
            if abs(turn) < 1e-3:
                area += 0.5 * cross + c * c * turn / 12.0 * (1.0 + turn * turn / 30.0)
                length += c * (1.0 + turn * turn / 24.0)
            else:
                s = math.sin(0.5 * turn)
                area += 0.5 * cross + c * c * (turn - math.sin(turn)) / (8.0 * s * s)
                length += 0.5 * c * turn / s
        if k < count:
            at = int(E[e, 0])
            V[rows, 0], V[rows, 1], V[rows, 3] = X[at, 0], X[at, 1], at
            rows += 1
            last, turn = e, bend
    return rows, area, length


@bare_kernel
def _one(E: FloatArray, S: FloatArray, numbers: FloatArray, e: int, f: int) -> bool:
    """Say whether one edge goes on along the line or arc of another."""
    i, j = int(E[e, 2]), int(E[f, 2])
    if i == j:
        return True
    k = S[i, 4]
    same: bool = numbers[i] == numbers[j] and abs(k - S[j, 4]) <= 1e-9 * abs(k)
    return same


@fast_kernel
def offset_loops(
    P: FloatArray,
    segment: FloatArray,
    firsts: FloatArray,
    T: FloatArray,
    d: float,
    corner: Corner,
    around: float,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Give the loops of the offset of closed loops to the left.

    Args:
        P: Pieces of the part.
        segment: The segment of each.
        firsts: The first piece of each loop and how many there are.
        T: Their tree.
        d: How far.
        corner: How corners are joined and ends go.
        around: See `edges_of`.

    Returns:
        Rows (x, y, bulge, number), the first of each loop and how many there are, the areas, and
        where no loop can be closed: (-1, 0, 0), or (0, x, y).
    """
    raw = raw_pieces(P, segment, firsts, d, corner)
    heart = heart_of(P, T, firsts, np.empty((128, 2)))
    S, numbers = surviving(P, T, firsts, raw, d, heart)
    kites = kites_of(P, segment, firsts, d, corner)
    E, X = edges_of(S, (P, T, heart), d, kites, around)
    V, starts, areas, node = loops_of(E, X, S, numbers)
    wrong = np.zeros(3)
    wrong[0] = -1.0
    if node >= 0:
        wrong[0], wrong[1], wrong[2] = 0.0, X[node, 0], X[node, 1]
    return V, starts, areas, wrong
