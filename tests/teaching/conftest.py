"""Hands that lead arms: motions as encoders see them."""

from dataclasses import dataclass

import numpy as np
import pytest

from splinearm.config import load_cell
from splinearm.teaching.recording import Recording
from splinearm.units import DEG

TICK = 2.0 * np.pi / 4096


@dataclass
class Led:
    """A motion that a hand led, and what was measured of it."""

    t: np.ndarray
    true: np.ndarray
    q: np.ndarray
    wrong: np.ndarray
    pauses: list[tuple[float, float]]


@dataclass(kw_only=True)
class Hand:
    """What a hand does: strokes one into the other, pauses, tremor; and what encoders see."""

    seconds: float = 12.0
    rate: float = 100.0
    tremor_deg: float = 0.02
    wrong: int = 3
    pauses: int = 2
    still: float = 0.5

    def leads(self, cell, seed: int) -> Led:
        rng = np.random.default_rng(seed)
        limits, n = cell.arm.limits, cell.arm.n
        t = np.arange(int(self.seconds * self.rate)) / self.rate
        true, pauses = self._strokes(t, cell.poses["home"], limits, rng)
        shaking = np.fft.rfft(rng.normal(size=(len(t), n)), axis=0)
        f = np.fft.rfftfreq(len(t), 1.0 / self.rate)
        shaking[(f < 7.0) | (f > 12.0)] = 0.0
        tremor = np.fft.irfft(shaking, len(t), axis=0)
        tremor *= self.tremor_deg * DEG / max(tremor.std(), 1e-12)
        q = np.round((true + tremor) / TICK + 0.2 * rng.normal(size=true.shape)) * TICK
        q = np.clip(q, limits.q_min, limits.q_max)
        wrong = np.sort(rng.choice(np.arange(10, len(t) - 10, 12), self.wrong, replace=False))
        for i in wrong:
            length, joint = rng.integers(1, 3), rng.integers(n)
            q[i : i + length, joint] += rng.choice([-1, 1]) * rng.uniform(2.0, 30.0) * DEG
        return Led(t, true, q, wrong, pauses)

    def _strokes(self, t, home, limits, rng):
        low = np.maximum(limits.q_min, -3.0) + 0.2
        high = np.minimum(limits.q_max, 3.0) - 0.2
        here, begin, pauses = np.array(home), self.still, []
        track = np.tile(here, (len(t), 1))
        rests = set(rng.choice(np.arange(1, 5), self.pauses, replace=False).tolist())
        stroke = 0
        while begin < t[-1] - self.still - 2.0:
            lasts = rng.uniform(0.6, 1.8)
            goal = np.clip(here + rng.normal(size=len(home)) * 0.4, low, high)
            share = min(
                1.0,
                (0.6 * limits.qd_max * lasts / 1.9 / np.maximum(np.abs(goal - here), 1e-9)).min(),
            )
            goal = here + share * (goal - here)
            x = np.clip((t - begin) / lasts, 0.0, 1.0)[:, None]
            track += (goal - here) * (10 * x**3 - 15 * x**4 + 6 * x**5)
            here, stroke = goal, stroke + 1
            if stroke in rests:
                length = rng.uniform(0.6, 1.2)
                pauses.append((begin + lasts, length))
                begin += lasts + length
            else:
                begin += lasts * rng.uniform(0.6, 0.95)
        return track, pauses


@pytest.fixture
def hand():
    """What makes a hand."""
    return Hand


@pytest.fixture(params=["planar_2r", "wx250s"])
def cell(request):
    return load_cell(request.param)


@pytest.fixture(scope="session")
def planar():
    return load_cell("planar_2r")


@pytest.fixture
def recording_of():
    """Makes a recording of positions by time."""

    def make(cell, t, q, **more) -> Recording:
        return Recording(names=cell.arm.joint_names, t=t, q=q, **more)

    return make
