"""An arm as a picture: its joints and links from three sides and in space."""

from pathlib import Path
from typing import Any

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind
from splinearm.kinematics import Arm, chain
from splinearm.units import MM

_VIEWS = ((0, 1, "from above"), (0, 2, "from the front"), (1, 2, "from the side"))
_AXES = ("C3", "C2", "C0")


def plot_arm(file: Path, arm: Arm, q: FloatArray, title: str) -> None:
    """Draw an arm at joint positions, shape (n,), rad or m, as a PNG."""
    from matplotlib.figure import Figure

    frames = chain.joint_frames(arm.packed, np.asarray(q, dtype=np.float64))
    line = np.concatenate((np.zeros((1, 3)), frames[:, :3, 3])) / MM
    figure = Figure(figsize=(12.0, 9.0), layout="constrained")
    figure.suptitle(title)
    size = max(float(np.ptp(line, axis=0).max()), 1.0)
    space: Any = figure.add_subplot(2, 2, 1, projection="3d")
    _draw(space, arm, frames, line, (0, 1, 2), size)
    middle = 0.5 * (line.min(axis=0) + line.max(axis=0))
    for which, centre in zip("xyz", middle, strict=True):
        getattr(space, f"set_{which}lim")(centre - 0.6 * size, centre + 0.6 * size)
        getattr(space, f"set_{which}label")(f"{which} / mm")
    space.set_box_aspect((1.0, 1.0, 1.0))
    for place, (i, j, side) in enumerate(_VIEWS, start=2):
        axes: Any = figure.add_subplot(2, 2, place)
        _draw(axes, arm, frames, line, (i, j), size)
        axes.set(xlabel=f"{'xyz'[i]} / mm", ylabel=f"{'xyz'[j]} / mm", aspect="equal", title=side)
        axes.set_xlim(middle[i] - 0.6 * size, middle[i] + 0.6 * size)
        axes.set_ylim(middle[j] - 0.6 * size, middle[j] + 0.6 * size)
        axes.grid(alpha=0.3)
    space.legend(fontsize="small", loc="upper left")
    figure.savefig(file, dpi=110)


def _draw(
    axes: Any,  # noqa: ANN401 - matplotlib's axes of either kind
    arm: Arm,
    frames: FloatArray,
    line: FloatArray,
    shown: tuple[int, ...],
    size: float,
) -> None:
    """Draw links, joints and the tool frame along the axes that are shown."""
    axes.plot(*(line[:, i] for i in shown), "-", color="0.4", linewidth=3.0, zorder=1)
    for k, link in enumerate(arm.links):
        marker = "o" if link.kind is JointKind.REVOLUTE else "s"
        axes.plot(*([line[k + 1, i]] for i in shown), marker, color=f"C{k}", label=link.name)
        ends = line[k + 1] + np.outer((-0.06 * size, 0.06 * size), frames[k, :3, 2])
        axes.plot(*(ends[:, i] for i in shown), "-", color=f"C{k}", linewidth=1.0)
    for which, colour in zip(range(3), _AXES, strict=True):
        ends = line[-1] + np.outer((0.0, 0.1 * size), frames[-1, :3, which])
        axes.plot(*(ends[:, i] for i in shown), "-", color=colour, linewidth=1.5)
