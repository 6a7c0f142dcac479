"""What happens, as an MCAP file that Foxglove and PlotJuggler open while they know no splinearm.

Topics ``/joint_states`` (measured) and ``/joint_commands`` (written to the arm), both shaped like
``sensor_msgs/JointState`` in JSON, SI units; ``/loop`` has what the loop itself did. The package
``mcap`` comes with the extra ``log``.
"""

import json
import logging
import queue
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.errors import ConfigError

from .record import Cycle

_log = logging.getLogger(__name__)

_FLUSH = 0.2
"""After so long at most, in s, what was written is handed to the operating system."""

_NANO = 1_000_000_000
_NUMBERS = {"type": "array", "items": {"type": "number"}}
_STAMP = {
    "type": "object",
    "properties": {"sec": {"type": "integer"}, "nanosec": {"type": "integer"}},
}
_JOINT_STATE = {
    "title": "sensor_msgs/JointState",
    "type": "object",
    "properties": {
        "header": {
            "type": "object",
            "properties": {"stamp": _STAMP, "frame_id": {"type": "string"}},
        },
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
        "header": _JOINT_STATE["properties"]["header"],  # type: ignore[index] # made above
        "cycle": {"type": "integer"},
        "motion_t": {"type": "number"},
        "lateness": {"type": "number"},
        "busy": {"type": "number"},
        "answered": {"type": "boolean"},
        "current": {"type": "array", "items": {"type": ["number", "null"]}},
    },
}


class McapLog:
    """Writes every cycle to an MCAP file, in a thread of its own; use it in a with-block.

    Rows stand one after the other, not in chunks: a program that is killed leaves all but the last
    fifth of a second readable.
    """

    def __init__(self, names: Sequence[str], file: Path) -> None:
        """Open the file.

        Args:
            names: Names of the joints.
            file: Where to write; it must not be there yet.

        Raises:
            ConfigError: If it is there already, cannot be written, or ``mcap`` is not installed.
        """
        self._names = list(names)
        self._stream = _open(file)
        self._writer, self._channels = _begin(self._stream, file)
        # the loop counts from its begin; the file's times are those of the day
        self._begun = time.time_ns()
        self._waiting: queue.SimpleQueue[Cycle | None] = queue.SimpleQueue()
        self._trouble: OSError | None = None
        self._thread = threading.Thread(target=self._write_all, name="mcap", daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._waiting.put(None)
        self._thread.join()
        try:
            self._writer.finish()
            self._stream.close()
        except OSError as failed:
            self._trouble = failed
        if self._trouble is not None:
            _log.warning("the log %s is not whole: %s", self._stream.name, self._trouble)

    def __call__(self, cycle: Cycle) -> None:
        """Keep one cycle; never waits for the disk."""
        self._waiting.put(cycle)

    def _write_all(self) -> None:
        flushed = time.monotonic()
        while True:
            try:
                cycle = self._waiting.get(timeout=_FLUSH)
            except queue.Empty:
                cycle = None
                ended = False
            else:
                ended = cycle is None
            try:
                if cycle is not None:
                    self._write(cycle)
                if ended or time.monotonic() - flushed >= _FLUSH:
                    self._stream.flush()
                    flushed = time.monotonic()
            except OSError as error:
                self._trouble = error
                return
            if ended:
                return

    def _write(self, cycle: Cycle) -> None:
        at = self._begun + round(cycle.t * _NANO)
        wanted, state = cycle.setpoint, cycle.state
        self._add("/joint_commands", at, self._joints(at, wanted.q, wanted.qd))
        if state is not None:
            self._add("/joint_states", at, self._joints(at, state.q, state.qd))
        currents = [] if state is None else state.current.tolist()
        loop = {
            "header": _header(at),
            "cycle": cycle.index,
            "motion_t": wanted.t,
            "lateness": cycle.lateness,
            "busy": cycle.busy,
            "answered": state is not None,
            "current": [None if np.isnan(value) else value for value in currents],
        }
        self._add("/loop", at, loop)

    def _joints(self, at: int, q: FloatArray, qd: FloatArray) -> dict[str, Any]:
        return {
            "header": _header(at),
            "name": self._names,
            "position": q.tolist(),
            "velocity": qd.tolist(),
            "effort": [],
        }

    def _add(self, topic: str, at: int, values: dict[str, Any]) -> None:
        self._writer.add_message(
            channel_id=self._channels[topic],
            log_time=at,
            publish_time=at,
            data=json.dumps(values).encode(),
        )


def _header(at: int) -> dict[str, Any]:
    sec, nanosec = divmod(at, _NANO)
    return {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": ""}


def _open(file: Path) -> IO[bytes]:
    try:
        return file.open("xb")
    except FileExistsError as error:
        raise ConfigError(file, "", "is there already and is not overwritten") from error
    except OSError as error:
        raise ConfigError(file, "", f"cannot be written: {error.strerror}") from error


def _begin(stream: IO[bytes], file: Path) -> tuple[Any, dict[str, int]]:
    """Write what stands before the rows; give the writer and the channel of each topic."""
    try:
        from mcap.writer import Writer
    except ImportError as error:
        stream.close()
        file.unlink()
        raise ConfigError(
            file, "", "needs the package mcap: pip install 'splinearm[log]'"
        ) from error
    writer = Writer(stream, use_chunking=False)
    writer.start(profile="", library="splinearm")
    channels = {}
    for schema, topics in (
        (_JOINT_STATE, ("/joint_states", "/joint_commands")),
        (_LOOP, ("/loop",)),
    ):
        number = writer.register_schema(
            name=str(schema["title"]), encoding="jsonschema", data=json.dumps(schema).encode()
        )
        for topic in topics:
            channels[topic] = writer.register_channel(topic, "json", number)
    stream.flush()
    return writer, channels
