"""Offsets of a thousand random pockets, measured by distances that nothing else is made by.

Pockets are mazes with rounded corners (walls of equal width in great number, which offsets meet
exactly), coasts (rough at every scale) and stars, half of them with islands. Some are offset with
corners that are not round, some with slits and spikes that have no width.
"""

from contextlib import suppress
from math import pi, tan

import numpy as np
import pytest

from splinearm.errors import ContourError
from splinearm.toolpaths.contour import Contour
from splinearm.toolpaths.offset import offset
from splinearm.toolpaths.region import Region

SIZE = 0.1


def maze(rng, n):
    """The outline of a random tree of corridors on a grid, its corners rounded where it pleases."""
    side = max(2, int(np.sqrt(n / 4.0)))
    cells = max(2, n // 4)
    rooms, edge = {(side // 2, side // 2)}, [(side // 2, side // 2)]
    walls = set()
    while len(rooms) < cells and edge:
        k = int(rng.integers(max(0, len(edge) - 12), len(edge)))
        x, y = edge[k]
        free = [
            (x + dx, y + dy)
            for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1))
            if (x + dx, y + dy) not in rooms
        ]
        if not free:
            edge.pop(k)
            continue
        new = free[int(rng.integers(len(free)))]
        rooms.add(new)
        walls.add(((x, y), new))
        edge.append(new)
    wide = rng.choice([0.25, 0.5, 0.6])
    corners = np.array(around(rooms, walls, wide))
    radius = rng.choice([0.0, 0.1, 0.5 * wide * 0.9]) if wide < 0.55 else 0.1
    return rounded(corners, radius, rng)


def around(rooms, walls, wide):
    """Corners of corridors along the edges of a tree, walked with a hand on the wall."""
    near = {room: set() for room in rooms}
    for a, b in walls:
        near[a].add((b[0] - a[0], b[1] - a[1]))
        near[b].add((a[0] - b[0], a[1] - b[1]))
    start = next(room for room in rooms if len(near[room]) == 1)
    (way,) = near[start]
    found, h = [], 0.5 * wide
    first = (start[0] + way[0], start[1] + way[1])
    room, heading = first, way
    while True:
        # keep the wall to the right: at a room, turn right if that is open, else on, else left
        right, left = (heading[1], -heading[0]), (-heading[1], heading[0])
        back = (-heading[0], -heading[1])
        for turn in (right, heading, left, back):
            if turn in near[room]:
                break
        c = np.array(room, dtype=float)
        ahead, side = np.array(heading, dtype=float), np.array(right, dtype=float)
        if turn == right:
            found.append(c + h * (side - ahead))
        elif turn == left:
            found.append(c + h * (side + ahead))
        elif turn == back:
            found += [c + h * (side + ahead), c + h * (ahead - side)]
        heading = turn
        room = (room[0] + turn[0], room[1] + turn[1])
        if (room, heading) == (first, way):
            return found


def rounded(corners, radius, rng):
    """The polygon with some corners rounded by arcs that touch both sides."""
    m = len(corners)
    vertices, bulges = [], []
    for k in range(m):
        before, here, behind = corners[k - 1], corners[k], corners[(k + 1) % m]
        a, b = here - before, behind - here
        la, lb = np.hypot(*a), np.hypot(*b)
        a, b = a / la, b / lb
        turn = np.arctan2(a[0] * b[1] - a[1] * b[0], a @ b)
        cut = radius * tan(0.5 * abs(turn))
        if radius == 0.0 or cut >= 0.49 * min(la, lb) or rng.uniform() < 0.3 or abs(turn) < 1e-6:
            vertices.append(here)
            bulges.append(0.0)
            continue
        vertices += [here - cut * a, here + cut * b]
        bulges += [tan(0.25 * turn), 0.0]
    return Contour(np.array(vertices), np.array(bulges))


def coast(rng, n):
    """A closed line broken up again and again, with arcs where they fit."""
    m = int(rng.integers(3, 7))
    angle = 2.0 * pi * np.arange(m) / m
    points = np.column_stack((np.cos(angle), np.sin(angle)))
    rough = rng.uniform(0.02, 0.16)
    while len(points) < n:
        way = np.roll(points, -1, axis=0) - points
        off = rng.uniform(-rough, rough, len(points))[:, None]
        middle = points + way * rng.uniform(0.4, 0.6, len(points))[:, None]
        middle = middle + off * np.column_stack((-way[:, 1], way[:, 0]))
        points = np.stack((points, middle), axis=1).reshape(-1, 2)
    bulges = np.where(rng.uniform(size=len(points)) < 0.5, rng.uniform(-0.2, 0.2, len(points)), 0.0)
    return Contour(points, bulges)


def star(rng, n):
    """A star: every point is seen from its middle."""
    n = max(3, n)
    angle = 2.0 * pi * (np.arange(n) + rng.uniform(-0.3, 0.3, n)) / n
    far = (
        1.0
        + 0.4 * np.cos(rng.integers(2, 6) * angle) * rng.uniform()
        + rng.uniform(-0.3, 0.3, n) * min(1.0, 30.0 / n)
    )
    points = far[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))
    return Contour(points, rng.uniform(-0.3, 0.3, n))


def pocket(seed, n):
    """A valid pocket of about n segments and about the size 0.1; islands if the seed is odd."""
    rng = np.random.default_rng(seed)
    outer = (maze, coast, star)[seed % 3](rng, n)
    for _ in range(12):
        try:
            part = Region(outer)
            break
        except ContourError:
            outer = Contour(outer.vertices, 0.6 * outer.bulges)
    else:
        return pocket(seed + 7_000_003, n)
    x0, y0, x1, y1 = part.bounds
    scale = SIZE / max(x1 - x0, y1 - y0)
    angle = rng.uniform(0.0, 6.3) if rng.uniform() < 0.5 else 0.0
    part = part.transformed(scale=scale, angle=angle)
    return with_islands(part, rng) if seed % 2 else part


def with_islands(part, rng):
    x0, y0, x1, y1 = part.bounds
    spots = rng.uniform((x0, y0), (x1, y1), (200, 2))
    spots = spots[part.contains(spots)]
    room = part.distance(spots) if len(spots) else np.empty(0)
    for k in np.argsort(-room)[:8]:
        size = rng.uniform(0.2, 0.9) * room[k]
        plate = Contour.rectangle([-0.7, -0.5], [1.4, 1])
        island = (Contour.circle([0, 0], 1.0), star(rng, 7), plate)[int(rng.integers(3))]
        island = island.transformed(scale=0.55 * size, angle=rng.uniform(0, 6), shift=spots[k])
        try:
            part = Region(part.outer, (*part.islands, island))
        except ContourError:
            continue
    return part


def rows(regions):
    from splinearm.toolpaths.verify_way import outline_of

    return outline_of([contour for region in regions for contour in region.contours])


def measure(part, d, found, rng):
    """Say what is wrong with an offset inwards by d, by distances both ways and by places."""
    from splinearm.toolpaths.verify_kernel import clearances, gaps, insides

    Q, R = rows([part]), rows(found)
    off = 1e-9 * SIZE
    if len(R):
        near = np.empty((len(R), 3))
        clearances(R, np.full(len(R), d + 1e-3 * SIZE), Q, near)
        if not near[:, 0].min() >= d - off:
            return f"gouges {d - near[:, 0].min():.3g} at {near[near[:, 0].argmin(), 1:]}"
        if not near[:, 0].max() <= d + off:
            return f"strays {near[:, 0].max() - d:.3g}"
        ends, far = np.ascontiguousarray(R[:, :2]), np.empty(len(R))
        gaps(Q, ends, 0.0, far)
        if not far.max() <= d + off:
            return f"is {far.max() - d:.3g} too far at {ends[far.argmax()]}"
    x0, y0, x1, y1 = part.bounds
    places = rng.uniform((x0, y0), (x1, y1), (600, 2))
    # and beside the part, where narrow regions are
    which = rng.integers(0, len(Q), 600)
    side = np.column_stack((-Q[which, 6], Q[which, 5])) * d
    beside = 0.5 * (Q[which, :2] + Q[which, 2:4]) + side * rng.choice([0.99, 1.01, 1.3], (600, 1))
    places = np.ascontiguousarray(np.vstack((places, beside)))
    far, free, kept = (np.empty(len(places)) for _ in range(3))
    gaps(Q, places, 0.0, far)
    insides(Q, places, free)
    insides(R, places, kept)
    wanted = (free == 1.0) & (far > d)
    wrong = (wanted != (kept == 1.0)) & (np.abs(far - d) > 10.0 * off)
    return f"{int(wrong.sum())} places wrong, {places[wrong][0]}" if wrong.any() else ""


def distance(seed, part):
    rng = np.random.default_rng(seed + 1)
    x0, y0, x1, y1 = part.bounds
    return float(np.exp(rng.uniform(np.log(1e-4), np.log(0.5))) * min(x1 - x0, y1 - y0))


def verdict(seed, n):
    part = pocket(seed, n)
    d = distance(seed, part)
    return measure(part, d, offset(part, -d), np.random.default_rng(seed + 2))


def clipped(pyclipr, part, d, tolerance):
    """Area by Clipper2 of the offset of chords."""
    work = pyclipr.ClipperOffset()
    work.scaleFactor = int(1e11)
    work.arcTolerance = tolerance * 1e11
    paths = [contour.flattened(tolerance) for contour in part.contours]
    work.addPaths(paths, pyclipr.JoinType.Round, pyclipr.EndType.Polygon)
    total = 0.0
    for path in work.execute(d):
        x, y = path[:, 0], path[:, 1]
        total += 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
    return total


@pytest.mark.parametrize("first", [0, 20, 40])
def test_offsets_of_random_pockets_are_right_to_a_tenth_of_a_nanometre(first):
    found = {seed: verdict(seed, 10 + 3 * seed) for seed in range(first, first + 20)}
    assert not {seed: says for seed, says in found.items() if says}


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_a_thousand_pockets_of_10_to_30000_segments():
    sizes = np.exp(np.linspace(np.log(10), np.log(30_000), 1000)).astype(int)
    found = {k: verdict(1000 + k, int(n)) for k, n in enumerate(sizes)}
    assert not {k: says for k, says in found.items() if says}


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_areas_are_those_of_clipper_but_for_its_chords():
    pyclipr = pytest.importorskip("pyclipr", reason="pyclipr is not installed")
    tolerance = 2e-9
    for seed in range(60):
        part = pocket(seed, 40)
        d = min(distance(seed, part), 0.1 * SIZE)
        ours = offset(part, -d)
        area, length = sum(r.area for r in ours), sum(r.length for r in ours) + part.length
        theirs = clipped(pyclipr, part, -d, tolerance)
        assert area == pytest.approx(theirs, abs=4.0 * tolerance * length), seed


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("seed", range(12))
def test_pockets_with_islands_are_the_same_from_every_start_and_side(seed):
    part = pocket(2 * seed + 1, 30)
    d = min(distance(seed, part), 0.03 * SIZE)

    def facts(region, scale=1.0):
        found = offset(region, -scale * d)
        return (
            len(found),
            sum(len(r.contours) for r in found),
            pytest.approx(sum(r.area for r in found) / scale**2, rel=1e-9, abs=1e-15),
            pytest.approx(sum(r.length for r in found) / scale, rel=1e-8, abs=1e-12),
        )

    wanted = facts(part)
    plain = tuple(getattr(value, "expected", value) for value in wanted)
    for vertex in range(len(part.outer.vertices)):
        assert plain == facts(Region(part.outer.starting_at(vertex), part.islands))
    turned = Region(part.outer.reversed(), tuple(i.reversed() for i in part.islands[::-1]))
    assert plain == facts(turned)
    for scale in (1e-3, 1e3):
        for angle, shift in ((0.0, (5.0, -2.0)), (1.0, (0.0, 0.0)), (4.0, (-1.0, 1.0))):
            moved = part.transformed(scale=scale, angle=angle, shift=np.array(shift) * scale * SIZE)
            assert plain == facts(moved, scale)


def sized(seed, largest=400):
    """A number of segments from 10 on."""
    return int(10 * (largest / 10) ** ((seed % 120) / 120))


def holds(regions, places):
    return np.any([region.contains(places) for region in regions], axis=0) | np.zeros(300, bool)


def is_as_far_as_corners_reach(part, d, corner):
    """Whether such corners keep off as far as round ones, and only near corners farther."""
    sharp, blunt = offset(part, d, corner=corner), offset(part, d)
    low, high = np.reshape(part.bounds, (2, 2)) + max(0.0, d) * np.array([[-1.0], [1.0]])
    places = np.random.default_rng(0).uniform(low, high, (300, 2))
    taken, wanted = holds(sharp, places) == (d > 0.0), holds(blunt, places) == (d > 0.0)
    beyond = part.distance(places) > (2.0 if corner == "mitre" else 1.4143) * abs(d)
    return (taken >= wanted).all() and (taken == wanted)[beyond].all()


@pytest.mark.parametrize("corner", ["mitre", "chamfer"])
def test_no_corner_of_random_pockets_fails(corner):
    for seed in (5, 9, 63, 81, 99, 105, 193, 228, 438, 837, 924, 1085):
        part = pocket(seed, sized(seed))
        d = distance(seed, part)
        assert is_as_far_as_corners_reach(part, -d, corner)
        assert is_as_far_as_corners_reach(part, d, corner)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("corner", ["mitre", "chamfer"])
def test_no_corner_of_a_thousand_random_pockets_fails(corner):
    for seed in range(1000):
        part = pocket(5000 + seed, sized(seed, 3000))
        d = distance(seed, part)
        assert is_as_far_as_corners_reach(part, -d, corner), seed
        assert is_as_far_as_corners_reach(part, d, corner), seed


# what has no width


def spiked(part, rng):
    """The part with ways out and back at some of its vertices, up to three at one."""
    vertices, bulges = part.outer.vertices, part.outer.bulges
    n = len(vertices)
    chosen = rng.choice(n, min(n, int(rng.integers(1, 5))), replace=False)
    places, bends = [], []
    for i in range(n):
        places.append(vertices[i])
        bends.append(bulges[i])
        for _ in range(int(rng.integers(1, 4)) if i in chosen else 0):
            length, angle = SIZE * np.exp(rng.uniform(-7.0, -1.2)), rng.uniform(0.0, 6.3)
            bend = rng.choice([0.0, 0.0, rng.uniform(-0.5, 0.5)])
            tip = vertices[i] + length * np.array([np.cos(angle), np.sin(angle)])
            bends[-1] = bend
            places += [tip, vertices[i]]
            bends += [-bend, bulges[i]]
    return Region(Contour(np.array(places), np.array(bends)), part.islands)


def keyholed(part):
    """The part with islands joined to its outer contour by slits, and how many."""
    outer, rest = part.outer, list(part.islands)
    for island in part.islands:
        V, B = outer.vertices, outer.bulges
        far = np.hypot(*(V[:, None] - island.vertices[None]).transpose(2, 0, 1))
        i, j = np.unravel_index(far.argmin(), far.shape)
        own = island.starting_at(int(j))
        places = np.concatenate((V[: i + 1], own.vertices, own.vertices[:1], V[i:]))
        bends = np.concatenate((B[:i], [0.0], own.bulges, [0.0], B[i:]))
        others = [other for other in rest if other is not island]
        try:
            outer = Region(Contour(places, bends), tuple(others)).outer
        except ContourError:
            continue
        rest = others
    return Region(outer, tuple(rest)), len(part.islands) - len(rest)


def wrong_with_offsets(part, seed):
    """Say what is wrong with offsets of a part to both sides."""
    d = distance(seed, part)
    for corner in ("round", "mitre", "chamfer"):
        inner = offset(part, -d, corner=corner)
        offset(part, d, corner=corner)
        if corner == "round":
            says = measure(part, d, inner, np.random.default_rng(seed))
    return says


@pytest.mark.parametrize("count", [25, pytest.param(400, marks=pytest.mark.slow)])
def test_spikes_without_width_are_kept_off_from(count):
    made = 0
    for seed in range(count):
        rng = np.random.default_rng(seed + 77)
        part = pocket(seed, int(rng.integers(10, 80)))
        for _ in range(60):
            with suppress(ContourError):
                part = spiked(part, rng)
                made += 1
                break
        assert not wrong_with_offsets(part, seed), seed
    assert made > 0.9 * count


@pytest.mark.parametrize("count", [15, pytest.param(300, marks=pytest.mark.slow)])
def test_islands_joined_by_slits_are_islands(count):
    made = 0
    for seed in range(count):
        part, slits = keyholed(pocket(2 * seed + 1, 20 + seed % 60))
        made += slits
        assert not wrong_with_offsets(part, seed), seed
    assert made > 2 * count
