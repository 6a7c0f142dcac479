"""The toolpath of the bracket: two pockets with an island, two holes, and the outline with tabs."""

from pathlib import Path

from matplotlib.figure import Figure
from style import MM, WIDTH, save, styled

from splinearm.config.toolpath_job import load_toolpath_job
from splinearm.toolpaths.action import Cutting, Rapid
from splinearm.toolpaths.drawing import read_drawing
from splinearm.toolpaths.work import carry_out
from splinearm.viewer.toolpath_plot import draw_toolpath

JOB = Path(__file__).parents[2] / "examples" / "bracket" / "bracket.toml"


@styled
def draw() -> Figure:
    """Draw its ways, coloured by feed."""
    job = load_toolpath_job(JOB)
    actions, done = carry_out(read_drawing(job.drawing, job.unit), job.works, job.exactness)
    figure = Figure(figsize=(WIDTH, 4.4), layout="constrained")
    axes = figure.subplots()
    # of the passes over each other the last
    floors = {one.work.milling.levels[-1] for one in done} | {-6.5 * MM}
    last = [a for a in actions if isinstance(a, Rapid | Cutting) and a.end[2] in floors]
    draw_toolpath(axes, last, by="feed")
    return figure


if __name__ == "__main__":
    save(draw(), __file__)
