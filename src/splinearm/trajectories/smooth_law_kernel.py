"""Where a smooth time law is at many times, compiled.

A cell is a row (t, s, v, a, j, c): at its begin at time t it is at s with speed v and acceleration
a, and on it d3s/dt3 = j + c ds/dt, where one of j and c is zero.
"""

from splinearm.arrays import FloatArray
from splinearm.compiled import kernel

from .smooth_motion import circular

_circular = kernel(circular)


@kernel
def sample_into(cells: FloatArray, ts: FloatArray, out: FloatArray) -> None:
    """Write s and its first three derivatives by the time, shape (4, k), at times of the law."""
    last, i = cells.shape[0] - 1, 0
    for k in range(ts.size):
        t = ts[k]
        if not (cells[i, 0] <= t and (i == last or t < cells[i + 1, 0])):
            low, high = 0, last
            if i < last and cells[i + 1, 0] <= t:
                low = i + 1
                if low == last or t < cells[low + 1, 0]:
                    high = low
            while low < high:
                middle = (low + high + 1) // 2
                if cells[middle, 0] <= t:
                    low = middle
                else:
                    high = middle - 1
            i = low
        dt = t - cells[i, 0]
        v, a, j, c = cells[i, 2], cells[i, 3], cells[i, 4], cells[i, 5]
        if c == 0.0:
            out[0, k] = cells[i, 1] + dt * (v + dt * (0.5 * a + dt * (j / 6.0)))
            out[1, k] = max(v + dt * (a + dt * (0.5 * j)), 0.0)
            out[2, k] = a + dt * j
            out[3, k] = j
        else:
            even, odd, next_even = _circular(c, dt)
            speed = max(v * even + a * odd, 0.0)
            out[0, k] = cells[i, 1] + v * odd + a * next_even
            out[1, k] = speed
            out[2, k] = a * even + c * v * odd
            out[3, k] = c * speed
