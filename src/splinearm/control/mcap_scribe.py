"""The process that writes rows as MCAP: ``python -m splinearm.control.mcap_scribe NAMES BEGUN``.

Rows come on standard input as ``row`` has them, records leave on standard output. They stand one
after the other, not in chunks: what was written can be read whatever happens next.
"""

import json
import math
import sys
from collections.abc import Sequence
from typing import IO, Any

from .row import Row, read_rows

_NANO = 1_000_000_000
_NUMBERS = {"type": "array", "items": {"type": "number"}}
_HEADER = {
    "type": "object",
    "properties": {
        "stamp": {
            "type": "object",
            "properties": {"sec": {"type": "integer"}, "nanosec": {"type": "integer"}},
        },
        "frame_id": {"type": "string"},
    },
}
_JOINT_STATE = {
    "title": "sensor_msgs/JointState",
    "type": "object",
    "properties": {
        "header": _HEADER,
        "name": {"type": "array", "items": {"type": "string"}},
        "position": _NUMBERS,
        "velocity": _NUMBERS,
        "effort": _NUMBERS,
    },
}
_LOOP = {
    "title": "splinearm/Loop",
    "type": "object",
    "properties": {
        "header": _HEADER,
        "cycle": {"type": "integer"},
        "motion_t": {"type": "number"},
        "lateness": {"type": "number"},
        "busy": {"type": "number"},
        "answered": {"type": "boolean"},
        "current": {"type": "array", "items": {"type": ["number", "null"]}},
    },
}


class McapScribe:
    """Writes rows as messages.

    Args:
        names: Names of the joints.
        begun: When the loop began, ns of the day's clock; rows count from there.
        out: Where to write.
    """

    def __init__(self, names: Sequence[str], begun: int, out: IO[bytes]) -> None:
        from mcap.writer import Writer

        self._names = list(names)
        self._begun = begun
        self._out = out
        self._writer = Writer(out, use_chunking=False)
        self._writer.start(profile="", library="splinearm")
        self._channels: dict[str, int] = {}
        self._register(_JOINT_STATE, "/joint_states", "/joint_commands")
        self._register(_LOOP, "/loop")
        out.flush()

    def write_all(self, pipe: int) -> None:
        """Write every row that comes through a pipe, until its other end is closed."""
        for rows in read_rows(pipe, len(self._names)):
            for row in rows:
                self._write(row)
            self._out.flush()
        self._writer.finish()  # type: ignore[no-untyped-call] # mcap says nothing
        self._out.flush()

    def _register(self, schema: dict[str, Any], *topics: str) -> None:
        number = self._writer.register_schema(
            name=schema["title"], encoding="jsonschema", data=json.dumps(schema).encode()
        )
        for topic in topics:
            self._channels[topic] = self._writer.register_channel(topic, "json", number)

    def _write(self, row: Row) -> None:
        at = self._begun + round(row.t * _NANO)
        q, qd, _, seen_q, seen_qd, current = zip(*row.joints, strict=True)
        answered = not math.isnan(seen_q[0])
        self._add("/joint_commands", at, self._joints(q, qd))
        if answered:
            self._add("/joint_states", at, self._joints(seen_q, seen_qd))
        loop = {
            "cycle": row.cycle,
            "motion_t": row.motion_t,
            "lateness": row.lateness,
            "busy": row.busy,
            "answered": answered,
            "current": [None if math.isnan(value) else value for value in current if answered],
        }
        self._add("/loop", at, loop)

    def _joints(self, q: Sequence[float], qd: Sequence[float]) -> dict[str, Any]:
        return {"name": self._names, "position": q, "velocity": qd, "effort": []}

    def _add(self, topic: str, at: int, values: dict[str, Any]) -> None:
        sec, nanosec = divmod(at, _NANO)
        header = {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": ""}
        self._writer.add_message(
            channel_id=self._channels[topic],
            log_time=at,
            publish_time=at,
            data=json.dumps({"header": header, **values}).encode(),
        )


if __name__ == "__main__":
    with open(1, "wb") as stdout:
        McapScribe(json.loads(sys.argv[1]), int(sys.argv[2]), stdout).write_all(sys.stdin.fileno())
