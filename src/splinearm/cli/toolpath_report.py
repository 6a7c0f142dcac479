"""What ``splinearm toolpath`` tells of what it read, planned and verified."""

from typing import TYPE_CHECKING

from .ways_report import ways_document, ways_facts

if TYPE_CHECKING:
    from splinearm.arrays import FloatArray
    from splinearm.config.toolpath_job import ToolpathJob
    from splinearm.toolpaths.action import Action
    from splinearm.toolpaths.drawing import Drawing
    from splinearm.toolpaths.verify_report import Verification
    from splinearm.toolpaths.work import Done

_MM = 1e3
_SHOWN = 6


def print_report(
    job: "ToolpathJob",
    drawing: "Drawing",
    actions: "tuple[Action, ...]",
    done: "tuple[Done, ...]",
    found: "Verification | None",
) -> None:
    """Print it for a person."""
    from .output import console, table

    rows = [["read", _read(drawing)]]
    for one in done:
        cutter = one.work.milling.cutter
        rows.append([str(one.work.kind), f"{cutter.name}; {_wires(one)}"])
        rows += [["", note] for note in one.milled.notes]
    rows += _amounts(actions)
    console.print(table(("", str(job.drawing)), rows))
    if found is None:
        console.print("not verified", highlight=False)
    else:
        console.print(found.text(), markup=False, highlight=False)


def _read(drawing: "Drawing") -> str:
    layers = ", ".join(repr(name) for name in drawing.layers[:_SHOWN])
    left = ", ".join(f"{count} {name}" for name, count in drawing.left_out.items())
    return f"{len(drawing.pieces)} pieces in {drawing.unit} on layers {layers}" + (
        f"; left out: {left}" if left else ""
    )


def _wires(one: "Done") -> str:
    chaining = one.chaining
    closed = sum(wire.closed for wire in chaining.wires)
    words = [f"{closed} closed wires, {len(chaining.wires) - closed} open"]
    for name, places in (
        ("open ends", chaining.open_ends),
        ("branches", chaining.branches),
        ("drawn twice", chaining.duplicates),
    ):
        if len(places):
            words.append(f"{len(places)} {name} at {_places(places)}")
    return "; ".join(words)


def _places(places: "FloatArray") -> str:
    shown = ", ".join(f"({x * _MM:.6g}, {y * _MM:.6g})" for x, y in places[:_SHOWN])
    return f"{shown}{' ...' if len(places) > _SHOWN else ''} mm"


def _amounts(actions: "tuple[Action, ...]") -> list[list[str]]:
    from splinearm.toolpaths.duration import estimate
    from splinearm.toolpaths.summary import summarise

    summary = summarise(actions)
    slow, quick = ((feed or 0.0) * 60e3 for feed in (summary.slowest, summary.quickest))
    return [
        *([name, value] for name, value in ways_facts(summary).items()),
        ["cutting", f"{summary.cutting_length * _MM:.1f} mm"],
        ["rapid", f"{summary.rapid_length * _MM:.1f} mm"],
        ["feed", f"{slow:.6g} to {quick:.6g} mm/min"],
        [
            "time",
            f"about {estimate(actions):.0f} s; cutting at full feed {summary.cutting_time:.0f} s",
        ],
    ]


def document(
    job: "ToolpathJob",
    drawing: "Drawing",
    actions: "tuple[Action, ...]",
    done: "tuple[Done, ...]",
    found: "Verification | None",
) -> dict[str, object]:
    """Give it for other programs: lengths in m, times in s, feeds in m/s."""
    from splinearm.toolpaths.duration import estimate
    from splinearm.toolpaths.summary import summarise

    summary = summarise(actions)
    return {
        "drawing": str(job.drawing),
        "unit": drawing.unit,
        "layers": list(drawing.layers),
        "pieces": len(drawing.pieces),
        "left_out": drawing.left_out,
        "dialect": job.dialect.name,
        "operations": [
            {
                "kind": str(one.work.kind),
                "tool": one.work.milling.cutter.name,
                "closed": sum(wire.closed for wire in one.chaining.wires),
                "open": sum(not wire.closed for wire in one.chaining.wires),
                "open_ends": one.chaining.open_ends.tolist(),
                "branches": one.chaining.branches.tolist(),
                "duplicates": one.chaining.duplicates.tolist(),
                "notes": list(one.milled.notes),
            }
            for one in done
        ],
        **ways_document(summary),
        "time": estimate(actions),
        "verification": None if found is None else found.document(),
    }
