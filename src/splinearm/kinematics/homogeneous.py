"""Points, lines and planes in homogeneous coordinates. Bare arrays, batches lead.

A point of the plane is (X, Y, W), at (X/W, Y/W), or infinitely far along (X, Y) when W = 0; a
line is (A, B, C) with A x + B y + C = 0. In space a point has four coordinates and a plane is
(A, B, C, D). A multiple of any of these is the same point, line or plane.
"""

import numpy as np
import numpy.typing as npt

from splinearm.arrays import ArrayInput, FloatArray


def from_cartesian(points: ArrayInput) -> FloatArray:
    """Give points, shape (..., d), m, in homogeneous coordinates with W = 1, shape (..., d+1)."""
    return _append(points, 1.0)


def at_infinity(directions: ArrayInput) -> FloatArray:
    """Give the points infinitely far along directions (..., d): W = 0, shape (..., d + 1)."""
    return _append(directions, 0.0)


def to_cartesian(points: ArrayInput) -> FloatArray:
    """Give homogeneous points, shape (..., d + 1), in Cartesian coordinates, shape (..., d), m.

    Raises:
        ValueError: If one is infinitely far.
    """
    points = np.asarray(points, dtype=np.float64)
    weights = points[..., -1:]
    if (weights == 0.0).any():
        raise ValueError(f"points: want none at infinity (last number 0), got {points.tolist()}")
    cartesian: FloatArray = points[..., :-1] / weights
    return cartesian


def line_through(a: ArrayInput, b: ArrayInput) -> FloatArray:
    """Give the lines, shape (..., 3), through homogeneous points of the plane (..., 3).

    Raises:
        ValueError: If two points are the same.
    """
    return _cross(a, b, "want two different points to lay a line through")


def meeting_point(a: ArrayInput, b: ArrayInput) -> FloatArray:
    """Give the homogeneous points, shape (..., 3), where lines (..., 3) meet.

    Parallel lines meet at infinity, along their direction.

    Raises:
        ValueError: If two lines are the same.
    """
    return _cross(a, b, "want two different lines to meet")


def are_parallel(a: ArrayInput, b: ArrayInput, tolerance: float = 1e-12) -> npt.NDArray[np.bool_]:
    """Say whether lines of the plane, or planes of space, are parallel, shape (...).

    Args:
        a: Lines, shape (..., 3), or planes, shape (..., 4).
        b: The same.
        tolerance: Largest sine of the angle between them; 0 asks for A1 B2 = A2 B1 exactly.
    """
    u, v = _normals(a), _normals(b)
    lengths = np.linalg.norm(u, axis=-1) * np.linalg.norm(v, axis=-1)
    return np.asarray(_sine(u, v) <= tolerance * lengths)


def angle_between_lines(a: ArrayInput, b: ArrayInput) -> FloatArray:
    """Give the angle, anticlockwise, from lines a to lines b, shape (...), in (-pi/2, pi/2] rad."""
    # D. Marsh, Applied Geometry for Computer Graphics and CAD, 2nd ed. 2005, chapter 2:
    # tan(theta) = (A1 B2 - A2 B1) / (A1 A2 + B1 B2)
    u, v = _normals(a), _normals(b)
    sine, cosine = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0], np.sum(u * v, axis=-1)
    turned = (cosine < 0.0) | ((cosine == 0.0) & (sine < 0.0))
    sign = np.where(turned, -1.0, 1.0)
    angle: FloatArray = np.arctan2(sign * sine, sign * cosine)
    return angle


def distance(lines: ArrayInput, points: ArrayInput) -> FloatArray:
    """Give the signed distance of Cartesian points from lines or planes, shape (...), m.

    It is above zero on the side to which the normal (A, B) or (A, B, C) points.
    """
    lines = np.asarray(lines, dtype=np.float64)
    normals = _normals(lines)
    height = np.sum(normals * np.asarray(points, dtype=np.float64), axis=-1) + lines[..., -1]
    signed: FloatArray = height / np.linalg.norm(normals, axis=-1)
    return signed


def image(T: FloatArray, lines: ArrayInput) -> FloatArray:
    """Give the images of lines, shape (..., 3), or planes, shape (..., 4), under a transform.

    Points map by the matrix T, lines and planes by its inverse transposed, so that a point on a
    line stays on it. The image is scaled by det T, as in the worked-out form of the plane.

    Raises:
        ValueError: If the transform flattens its space.
    """
    # D. Marsh, Applied Geometry for Computer Graphics and CAD, 2nd ed. 2005, lemma 1.5
    try:
        back = np.linalg.inv(T)
    except np.linalg.LinAlgError as error:
        raise ValueError(f"T: want a transform that flattens nothing, got {T.tolist()}") from error
    images: FloatArray = np.linalg.det(T) * (np.asarray(lines, dtype=np.float64) @ back)
    return images


def plane_at(point: ArrayInput, normal: ArrayInput) -> FloatArray:
    """Give the planes, shape (..., 4), through Cartesian points (..., 3) with normals (..., 3)."""
    normal = np.asarray(normal, dtype=np.float64)
    offset = -np.sum(normal * np.asarray(point, dtype=np.float64), axis=-1)
    return np.concatenate((normal, offset[..., None]), axis=-1)


def plane_through(a: ArrayInput, b: ArrayInput, c: ArrayInput) -> FloatArray:
    """Give the planes, shape (..., 4), through three Cartesian points, shape (..., 3) each.

    The normal points to where the three run anticlockwise.

    Raises:
        ValueError: If three points lie on one line.
    """
    a, b, c = (np.asarray(point, dtype=np.float64) for point in (a, b, c))
    normal = _cross(b - a, c - a, "want three points that are not on one line")
    return plane_at(a, normal)


def line_of_planes(a: ArrayInput, b: ArrayInput) -> tuple[FloatArray, FloatArray]:
    """Give the line where planes (..., 4) meet: a point (..., 3), m, and a unit direction.

    The point is the one nearest to the origin.

    Raises:
        ValueError: If two planes are parallel.
    """
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    direction = _cross(_normals(a), _normals(b), "want planes that meet in a line")
    square = np.sum(direction**2, axis=-1, keepdims=True)
    spread = b[..., 3:] * _normals(a) - a[..., 3:] * _normals(b)
    return np.cross(spread, direction) / square, direction / np.sqrt(square)


def line_meets_plane(point: ArrayInput, direction: ArrayInput, plane: ArrayInput) -> FloatArray:
    """Give the homogeneous points, shape (..., 4), where lines of space meet planes (..., 4).

    A line parallel to its plane meets it at infinity.

    Args:
        point: Cartesian points of the lines, shape (..., 3), m.
        direction: Directions of the lines, shape (..., 3).
        plane: Planes, shape (..., 4).

    Raises:
        ValueError: If a line lies in its plane.
    """
    near, far = from_cartesian(point), at_infinity(direction)
    plane = np.asarray(plane, dtype=np.float64)
    met = near * np.sum(plane * far, axis=-1, keepdims=True)
    met = met - far * np.sum(plane * near, axis=-1, keepdims=True)
    return _not_zero(met, "want lines that do not lie in their planes")


def _append(vectors: ArrayInput, last: float) -> FloatArray:
    vectors = np.asarray(vectors, dtype=np.float64)
    return np.concatenate((vectors, np.full((*vectors.shape[:-1], 1), last)), axis=-1)


def _normals(lines: ArrayInput) -> FloatArray:
    return np.asarray(lines, dtype=np.float64)[..., :-1]


def _sine(u: FloatArray, v: FloatArray) -> FloatArray:
    """Give the length of the cross product of vectors of the plane or of space."""
    if u.shape[-1] == 2:
        return np.abs(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])
    length: FloatArray = np.linalg.norm(np.cross(u, v), axis=-1)
    return length


def _cross(a: ArrayInput, b: ArrayInput, want: str) -> FloatArray:
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    return _not_zero(np.cross(a, b), want)


def _not_zero(vectors: FloatArray, want: str) -> FloatArray:
    if not np.any(vectors, axis=-1).all():
        raise ValueError(f"{want}, got {vectors.tolist()} for what they share")
    return vectors
