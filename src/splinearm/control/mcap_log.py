"""What happens, as an MCAP file that Foxglove and PlotJuggler open while they know no splinearm.

Topics ``/joint_states`` (measured) and ``/joint_commands`` (written to the arm), both shaped like
``sensor_msgs/JointState`` in JSON, SI units; ``/loop`` has what the loop itself did. The package
``mcap`` comes with the extra ``log``.
"""

import json
import time
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import IO, Self

from splinearm.errors import ConfigError

from .cycle import Cycle
from .row_pipe import RowPipe


class McapLog:
    """Writes every cycle to an MCAP file, in a process of its own; use it in a with-block."""

    def __init__(self, names: Sequence[str], file: Path) -> None:
        """Open the file.

        Args:
            names: Names of the joints.
            file: Where to write; it must not be there yet.

        Raises:
            ConfigError: If it is there already, cannot be written, or ``mcap`` is not installed.
        """
        stream = _open(file)
        try:
            import mcap.writer  # noqa: F401 - the process that writes needs it
        except ImportError as error:
            stream.close()
            file.unlink()
            raise ConfigError(
                file, "", "needs the package mcap: pip install 'splinearm[log]'"
            ) from error
        # the loop counts from its begin; the file's times are those of the day
        words = (json.dumps(list(names)), str(time.time_ns()))
        with stream:
            self._pipe = RowPipe("mcap_scribe", words, len(names), stream)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._pipe.close()

    def __call__(self, cycle: Cycle) -> None:
        """Keep one cycle; never waits for the disk."""
        self._pipe.send(cycle)


def _open(file: Path) -> IO[bytes]:
    try:
        return file.open("xb")
    except FileExistsError as error:
        raise ConfigError(file, "", "is there already and is not overwritten") from error
    except OSError as error:
        raise ConfigError(file, "", f"cannot be written: {error.strerror}") from error
