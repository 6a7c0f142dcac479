"""What a verification found, as facts, as text and as a document."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import isfinite

from .stock import HeightMap

_MM = 1e3
_MM_MIN = 60e3


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Fault:
    """Something that a program does and must not, or leaves undone: the worst case of its kind."""

    kind: str
    """In the plane: gouge, too deep, left over; by depth: too low, standing, rapid, plunge, feed,
    step down, cutting length; besides: unreached (G41) and dialect."""
    line: int = 0
    """The line of the program, from 1; 0 if no line is to blame."""
    where: tuple[float, float, float]
    """The place, m."""
    amount: float
    """By how much: m, or m/s for feeds."""
    count: int = 1
    """How many ways or places have it."""
    says: str
    """What it is, for a person."""

    def __str__(self) -> str:
        line = f"line {self.line}: " if self.line else ""
        x, y, z = (_MM * v for v in self.where)
        place = "" if self.kind == "dialect" else f" at ({x:.4f}, {y:.4f}, {z:.4f}) mm"
        more = f"; {self.count} such" if self.count > 1 else ""
        return f"{self.kind}: {line}{self.says}{place}{more}"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Verification:
    """What a program does to its stock."""

    faults: tuple[Fault, ...]
    """What is wrong, the worst of each kind."""
    gouge: float
    """How far it cuts into the part at the most in the plane, m; below 0: how far it stays off."""
    left: float
    """How much is left at most where the cutter could have been, in the plane, m."""
    unreachable: float
    """How much is left at most where this cutter cannot be, m."""
    removed: float
    """What is taken away, m3, to within the cells."""
    bound: float
    """How far distances in the plane may be wrong, m."""
    map: HeightMap
    """What is left of the stock."""
    wanted: HeightMap
    """How low it may be."""

    @property
    def ok(self) -> bool:
        """Whether nothing is wrong."""
        return not self.faults

    def text(self) -> str:
        """Give it as lines for a person."""
        cell = self.map.cell * _MM
        stated = f"plane to {self.bound * _MM:.2g} mm, depth on cells of {cell:.3g} mm"
        head = "verified" if self.ok else "wrong"
        facts = [f"gouge {max(self.gouge, 0.0) * _MM:.6f} mm", f"left {self.left * _MM:.6f} mm"]
        if self.unreachable > 0.0:
            facts.append(f"{self.unreachable * _MM:.4f} mm where the cutter cannot be")
        facts.append(f"{self.removed * 1e9:.1f} mm3 taken away")
        return "\n".join([f"{head}: {', '.join(facts)} ({stated})", *map(str, self.faults)])

    def document(self) -> dict[str, object]:
        """Give it as what JSON can say: m, m/s, m3; None where nothing is cut at all."""
        return {
            "ok": self.ok,
            "gouge": self.gouge,
            "left": self.left if isfinite(self.left) else None,
            "unreachable": self.unreachable,
            "removed": self.removed,
            "bound": self.bound,
            "cell": self.map.cell,
            "faults": [
                {
                    "kind": fault.kind,
                    "line": fault.line,
                    "where": list(fault.where),
                    "amount": fault.amount if isfinite(fault.amount) else None,
                    "count": fault.count,
                    "says": fault.says,
                }
                for fault in self.faults
            ],
        }


def worst(faults: Iterable[Fault]) -> tuple[Fault, ...]:
    """Give of each kind of fault the worst, with how many there are, in the order they came."""
    kinds: dict[str, list[Fault]] = {}
    for fault in faults:
        kinds.setdefault(fault.kind, []).append(fault)
    found = []
    for kind, several in kinds.items():
        top = max(several, key=lambda fault: fault.amount)
        found.append(
            Fault(
                kind=kind,
                line=top.line,
                where=top.where,
                amount=top.amount,
                count=sum(fault.count for fault in several),
                says=top.says,
            )
        )
    return tuple(found)
