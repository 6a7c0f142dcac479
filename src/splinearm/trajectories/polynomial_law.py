"""Time laws that are one polynomial of the time."""

from dataclasses import dataclass, field
from math import comb

import numpy as np

from splinearm.arrays import FloatArray, frozen_array

_ROUNDS = 60


@dataclass(frozen=True, slots=True, eq=False)
class PolynomialLaw:
    """s(t), a polynomial of the time that never goes backwards."""

    coefficients: FloatArray
    """Of powers of t / duration, shape (degree + 1,)."""
    duration: float
    """How long it takes, s, above 0."""
    s: FloatArray = field(init=False)
    """Where it starts and ends, shape (2,)."""
    t: FloatArray = field(init=False)
    """When, shape (2,), s."""
    _rows: tuple[tuple[float, ...], ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        c = frozen_array(self.coefficients, (None,), "coefficients")
        if c.size == 0:
            raise ValueError("coefficients: want at least one, got none")
        if not 0.0 < self.duration < np.inf:
            raise ValueError(f"duration: want a number above 0, got {self.duration}")
        rows = [c]
        for _ in range(3):
            rows.append(rows[-1][1:] * np.arange(1, rows[-1].size) / self.duration)
        object.__setattr__(self, "coefficients", c)
        object.__setattr__(self, "_rows", tuple(tuple(row[::-1].tolist()) for row in rows))
        object.__setattr__(self, "s", np.array([c[0], c.sum()]))
        object.__setattr__(self, "t", np.array([0.0, self.duration]))

    def at(self, t: float) -> tuple[float, float, float]:
        """Give s, ds/dt and d2s/dt2 at a time from 0 to the duration."""
        x = t / self.duration
        values = [0.0, 0.0, 0.0]
        for k in range(3):
            value = 0.0
            for c in self._rows[k]:
                value = value * x + c
            values[k] = value
        return values[0], values[1], values[2]

    def sample(self, ts: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Give the same at many times, each of shape (k,)."""
        x = np.asarray(ts) / self.duration
        return _values(self._rows[0], x), _values(self._rows[1], x), _values(self._rows[2], x)

    def jerk(self, ts: FloatArray) -> FloatArray:
        """Give d3s/dt3 at many times, shape (k,)."""
        return _values(self._rows[3], np.asarray(ts) / self.duration)

    def time_at(self, s: float) -> float:
        """Give when s is passed, s."""
        if s <= self.s[0]:
            return 0.0
        if s >= self.s[1]:
            return self.duration
        low, high = 0.0, self.duration
        t = high * (s - float(self.s[0])) / float(self.s[1] - self.s[0])
        for _ in range(_ROUNDS):
            at, speed, _ = self.at(t)
            low, high = (t, high) if at < s else (low, t)
            step = (s - at) / speed if speed > 0.0 else 0.0
            new = t + step if low < t + step < high else 0.5 * (low + high)
            if abs(new - t) <= 1e-16 * self.duration:
                break
            t = new
        return t

    def slower(self, share: float) -> "PolynomialLaw":
        """Give the same way at ``share`` of the speed everywhere."""
        return PolynomialLaw(self.coefficients, self.duration / share)

    def reversed(self) -> "PolynomialLaw":
        """Give the law that passes the same places backwards, by the parameter s[0] + s[-1] - s."""
        backwards = -_moved(self.coefficients, 1.0, -1.0)
        backwards[0] += self.s[0] + self.s[1]
        return PolynomialLaw(backwards, self.duration)

    def between(self, start: float, end: float) -> "PolynomialLaw":
        """Give what happens from one time to a later one, both from 0 to the duration."""
        first, length = start / self.duration, (end - start) / self.duration
        return PolynomialLaw(_moved(self.coefficients, first, length), end - start)


def _values(row: tuple[float, ...], x: FloatArray) -> FloatArray:
    """Give a polynomial, highest power first, at many places."""
    values = np.zeros(x.shape)
    for c in row:
        values = values * x + c
    return values


def _moved(c: FloatArray, first: float, length: float) -> FloatArray:
    """Give the coefficients of the polynomial of first + length x."""
    moved = np.zeros_like(c)
    for i in range(c.size):
        for k in range(i + 1):
            moved[k] += c[i] * comb(i, k) * first ** (i - k) * length**k
    return moved
