"""Where pieces meet, snapped to shared nodes, and what of them is no nearer to the part than d.

All lengths are in units of the part, like in ``offset_kernel``.
"""

import math

import numpy as np
import numpy.typing as npt

from splinearm.arrays import FloatArray
from splinearm.compiled import bare_kernel, fast_kernel

from .arc_kernel import at_share, box_of, circles_meet, distance, share
from .offset_corner_kernel import goes_around, in_kites
from .tree_kernel import RUN, Disc, is_clear, nearest, overlapping, tree_of

IndexArray = npt.NDArray[np.int64]

SNAP = 1e-11
"""Points nearer to each other than this are one."""
_CELL = 20.0 * SNAP
_BESIDE = 0.3 * SNAP
"""How far beyond its ends a piece still meets others: less than what is snapped to its end."""
_SAME = 1e-9
"""Curvatures that differ by a smaller share are one."""
SURE = 2e-13
"""What is nearer to the part than d by no more than this is as near as rounding tells."""
SPARE = 1e-10
"""What is nearer by no more than this may close a gap that rounding left."""

EDGE = 6
"""Columns of an edge: from, to, piece, first share, last share, rank (2 sure, 1 spare)."""


@fast_kernel
def meetings(S: FloatArray) -> tuple[FloatArray, int]:
    """Give where pieces meet: rows (x, y, piece, other piece), and how many there are."""
    n = S.shape[0]
    T = tree_of(S, n, SNAP)
    runs = np.empty(T.shape[0] + 128)
    H = np.empty((8 * n + 64, 4))
    i, m = 0, 0
    while True:
        i, m = _meetings(S, (T, runs), i, H, m)
        if i == n:
            return H, m
        wider = np.empty((2 * H.shape[0], 4))
        wider[:m] = H[:m]
        H = wider


@bare_kernel
def _meetings(
    S: FloatArray, tree: tuple[FloatArray, FloatArray], i: int, H: FloatArray, m: int
) -> tuple[int, int]:
    """Write where pieces meet others behind them, from one on while there is room.

    Returns:
        The next piece, and how many meetings are written.
    """
    T, runs = tree
    n = S.shape[0]
    while i < n:
        box = box_of(S, i)
        count = overlapping(T, box, i + 1, runs)
        if m + 6 * RUN * count > H.shape[0]:
            break
        for k in range(count):
            first = int(runs[k]) * RUN
            for j in range(max(first, i + 1), min(n, first + RUN)):
                other = box_of(S, j)
                if (
                    other[0] > box[2] + SNAP
                    or other[2] < box[0] - SNAP
                    or other[1] > box[3] + SNAP
                    or other[3] < box[1] - SNAP
                ):
                    continue
                m = _meet(S, i, j, H, m)
        i += 1
    return i, m


@bare_kernel
def _meet(S: FloatArray, i: int, j: int, H: FloatArray, m: int) -> int:
    """Write where two pieces meet, and ends that lie on the other piece."""
    found, ux, uy, vx, vy = 0, 0.0, 0.0, 0.0, 0.0
    # where one circle lies on another rounding alone says where they meet
    if abs(S[i, 4] - S[j, 4]) > _SAME * abs(S[i, 4]) or _off_circle(S, i, S, j) > SNAP:
        found, ux, uy, vx, vy = circles_meet(S, i, S, j)
    for k in range(found):
        x, y = (ux, uy) if k == 0 else (vx, vy)
        if _beside(S, i, x, y) and _beside(S, j, x, y):
            H[m, 0], H[m, 1], H[m, 2], H[m, 3] = x, y, i, j
            m += 1
    for c in (0, 2):
        for on, of in ((i, j), (j, i)):
            x, y = S[of, c], S[of, c + 1]
            if (x == S[on, 0] and y == S[on, 1]) or (x == S[on, 2] and y == S[on, 3]):
                continue  # one node as it is
            if distance(S, on, x, y) <= SNAP:
                H[m, 0], H[m, 1], H[m, 2], H[m, 3] = x, y, i, j
                m += 1
    return m


@bare_kernel
def _off_circle(S: FloatArray, i: int, R: FloatArray, j: int) -> float:
    """Give how far the ends of a piece are from the circle of another, to first order."""
    off = 0.0
    for c in (0, 2):
        qx, qy = R[j, c] - S[i, 0], R[j, c + 1] - S[i, 1]
        g = qx * S[i, 5] + qy * S[i, 6] - 0.5 * S[i, 4] * (qx * qx + qy * qy)
        off = max(off, abs(g))
    return off


@bare_kernel
def _beside(S: FloatArray, i: int, x: float, y: float) -> bool:
    """Say whether a point of the circle of a piece is on the piece itself."""
    qx, qy = x - S[i, 0], y - S[i, 1]
    rx, ry = x - S[i, 2], y - S[i, 3]
    ahead: float = qx * S[i, 6] - qy * S[i, 5]
    behind: float = rx * S[i, 8] - ry * S[i, 7]
    return ahead >= -_BESIDE and behind <= _BESIDE


@bare_kernel
def root(parent: FloatArray, i: int) -> int:
    """Give the first of the points that are one with a point."""
    while parent[i] != i:
        parent[i] = parent[int(parent[i])]
        i = int(parent[i])
    return i


@fast_kernel
def _snapped(X: FloatArray) -> FloatArray:
    """Give for each point the one that stands for all that are nearer to each other than SNAP."""
    n = X.shape[0]
    size = 64
    while size < 2 * n:
        size *= 2
    head, after = np.full(size, -1, np.int64), np.empty(n, np.int64)
    parent = np.empty(n)
    for i in range(n):
        parent[i] = i
        # cells are much wider than what is snapped: mostly one of them is near, at most four
        fx, fy = X[i, 0] / _CELL, X[i, 1] / _CELL
        cx, cy = math.floor(fx), math.floor(fy)
        sx, sy = _border(fx - cx), _border(fy - cy)
        for k in range(4):
            if (k % 2 == 1 and sx == 0.0) or (k // 2 == 1 and sy == 0.0):
                continue
            slot = _slot(cx + sx * (k % 2), cy + sy * (k // 2), size)
            j = head[slot]
            while j >= 0:
                if (X[j, 0] - X[i, 0]) ** 2 + (X[j, 1] - X[i, 1]) ** 2 <= SNAP * SNAP:
                    a, b = root(parent, i), root(parent, j)
                    parent[max(a, b)] = min(a, b)
                j = after[j]
        slot = _slot(cx, cy, size)
        after[i] = head[slot]
        head[slot] = i
    for i in range(n):
        parent[i] = root(parent, i)
    return parent


@bare_kernel
def _border(share: float) -> float:
    """Give to which side of a cell the next one is near what lies at a share of it; 0: to none."""
    near = 1.01 * SNAP / _CELL
    return -1.0 if share < near else (1.0 if share > 1.0 - near else 0.0)


@bare_kernel
def _slot(cx: float, cy: float, size: int) -> int:
    """Give the place of a cell in a table whose size is a power of two."""
    mixed = np.int64(cx) * 73856093 ^ np.int64(cy) * 19349663
    slot: int = (mixed ^ (mixed >> 17)) & (size - 1)  # type: ignore[assignment]
    return slot


@fast_kernel
def edges_of(
    S: FloatArray,
    part: tuple[FloatArray, FloatArray, Disc],
    d: float,
    kites: tuple[FloatArray, FloatArray],
    around: float,
) -> tuple[FloatArray, FloatArray]:
    """Give what is no nearer to the part than d, and in no corner, from node to node.

    Args:
        S: Pieces moved by d.
        part: Pieces of the part, their tree, and a disc that none of them reaches into.
        d: How far they were moved.
        kites: Corners that reach farther than d, as `kites_of` gives them.
        around: 1 if the part is what its pieces go around, 0 if it is what they do not, or -1 if
            nothing that is far enough is elsewhere. It is where corners reach through walls, and
            beside spikes and slits that have no width.

    Returns:
        Edges, shape (m, 6), see `EDGE`, and the nodes, shape (k, 2).
    """
    n = S.shape[0]
    H, hits = meetings(S)
    X = np.empty((hits + 2 * n, 2))
    at = np.zeros(n + 1, np.int64)
    for h in range(hits):
        X[h, 0], X[h, 1] = H[h, 0], H[h, 1]
        at[int(H[h, 2]) + 1] += 1
        at[int(H[h, 3]) + 1] += 1
    for i in range(n):
        for c in range(2):
            X[hits + 2 * i + c, 0], X[hits + 2 * i + c, 1] = S[i, 2 * c], S[i, 2 * c + 1]
        at[i + 1] += at[i] + 2
    node = _snapped(X)
    # shares and nodes along each piece, sorted
    U, N = np.empty(2 * hits + 2 * n), np.empty(2 * hits + 2 * n, np.int64)
    fill = np.empty(n, np.int64)
    for i in range(n):
        U[at[i]], N[at[i]] = 0.0, int(node[hits + 2 * i])
        U[at[i] + 1], N[at[i] + 1] = 1.0, int(node[hits + 2 * i + 1])
        fill[i] = at[i] + 2
    for h in range(hits):
        for c in (2, 3):
            i = int(H[h, c])
            u = min(1.0, max(0.0, share(S, i, X[h, 0], X[h, 1])))
            k = fill[i]
            fill[i] += 1
            while k > at[i] and U[k - 1] > u:
                U[k], N[k] = U[k - 1], N[k - 1]
                k -= 1
            U[k], N[k] = u, int(node[h])
    # what meets in each node: 2 where one piece ends, another begins and nothing else is
    shared = np.zeros(X.shape[0], np.int64)
    for h in range(X.shape[0]):
        shared[int(node[h])] += 4 if h < hits else 1
    E = np.empty((2 * hits + n + 1, EDGE))
    runs = np.empty(max(part[1].shape[0], kites[1].shape[0]) + 128)
    model = (part[0], part[1], d, part[2])
    m = _edges(S, model, kites, (at, U, N, shared), E, (np.empty((128, 2)), runs, around))
    return E[:m], X


@bare_kernel
def _edges(
    S: FloatArray,
    model: tuple[FloatArray, FloatArray, float, Disc],
    kites: tuple[FloatArray, FloatArray],
    along: tuple[IndexArray, FloatArray, IndexArray, IndexArray],
    E: FloatArray,
    work: tuple[FloatArray, FloatArray, float],
) -> int:
    """Write the edges between nodes along pieces that are far enough, and give how many."""
    at, U, N, shared = along
    stack, runs, around = work
    edged = kites[0].shape[0] > 0 or around >= 0.0
    m, hint = 0, -1
    rank, last = -1.0, -1
    for i in range(S.shape[0]):
        u, start = U[at[i]], N[at[i]]
        for k in range(at[i] + 1, at[i + 1]):
            if N[k] == start:
                u = U[k]
                continue
            v = U[k]
            # how a way lies changes only where another meets it, not from one piece into the next;
            # round corners are all there to be met
            if start != last or shared[start] != 2 or rank == 1.0 or edged:
                rank, hint = _rank(S, i, 0.5 * (u + v), model, hint, stack)
                if edged and rank > 0.0:
                    spot = at_share(S, i, 0.5 * (u + v))
                    rank = min(rank, _beside_kites(spot, model, kites, around, runs))
            last = N[k]
            if rank > 0.0:
                E[m, 0], E[m, 1], E[m, 2], E[m, 3], E[m, 4], E[m, 5] = start, N[k], i, u, v, rank
                m += 1
            u, start = v, N[k]
    return m


@bare_kernel
def _rank(
    S: FloatArray,
    i: int,
    u: float,
    model: tuple[FloatArray, FloatArray, float, Disc],
    hint: int,
    stack: FloatArray,
) -> tuple[float, int]:
    """Say how a piece lies at a share: 2 surely far enough, 1 nearly, 0 too near, and to what."""
    P, T, d, heart = model
    x, y = at_share(S, i, u)
    if hint >= 0 and distance(P, hint, x, y) < d - SPARE:
        return 0.0, hint
    if is_clear(heart, x, y, d - SURE):
        return 2.0, hint
    far, near = nearest(P, P.shape[0], T, (x, y), (d - SURE, d - SPARE), stack)
    if near < 0:
        return 2.0, hint
    return (1.0 if far >= d - SPARE else 0.0), near


@bare_kernel
def _beside_kites(
    spot: tuple[float, float],
    model: tuple[FloatArray, FloatArray, float, Disc],
    kites: tuple[FloatArray, FloatArray],
    around: float,
    runs: FloatArray,
) -> float:
    """Say how a place lies: 2 surely in no corner, 1 nearly, 0 in one or not in the part."""
    deep = in_kites(kites[0], kites[1], spot, model[2], runs)
    if deep > SPARE:
        return 0.0
    # what a corner reaches through a wall may lie where nothing is to be
    if around >= 0.0 and goes_around(model[0], model[1], spot, runs) != (around > 0.0):
        return 0.0
    return 1.0 if deep > SURE else 2.0
