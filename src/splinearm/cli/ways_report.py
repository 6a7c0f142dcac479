"""What the ways of a program amount to, as `toolpath` and `gcode check` tell it."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from splinearm.toolpaths.summary import Summary

_MM = 1e3


def ways_facts(summary: "Summary") -> dict[str, str]:
    """Give how many ways there are and where they are, for a person."""
    low, high = summary.low * _MM, summary.high * _MM
    extent = " x ".join(f"{a:g} to {b:g}" for a, b in zip(low.round(4), high.round(4), strict=True))
    return {
        "ways": f"{summary.lines} lines, {summary.arcs} arcs, {summary.splines} splines, "
        f"{summary.rapids} rapid",
        "extent": f"{extent} mm",
    }


def ways_document(summary: "Summary") -> dict[str, object]:
    """Give them for other programs: lengths in m, times in s, feeds in m/s."""
    return {
        "ways": {
            "lines": summary.lines,
            "arcs": summary.arcs,
            "splines": summary.splines,
            "rapids": summary.rapids,
        },
        "low": summary.low.tolist(),
        "high": summary.high.tolist(),
        "cutting_length": summary.cutting_length,
        "cutting_time": summary.cutting_time,
        "rapid_length": summary.rapid_length,
        "feed": [summary.slowest, summary.quickest],
    }
