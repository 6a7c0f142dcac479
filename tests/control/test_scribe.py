"""What the writing processes do, called here in this one."""

import csv
import io
import json
import os
import struct

import pytest

from splinearm.control.csv_scribe import write_lines
from splinearm.control.row import read_rows, row_length

NAN = float("nan")


@pytest.fixture
def pipe_of():
    """Gives the reading end of a pipe that holds bytes and was closed after them."""
    ends = []

    def make(*pieces: bytes) -> int:
        read, write = os.pipe()
        ends.append(read)
        for piece in pieces:
            os.write(write, piece)
        os.close(write)
        return read

    yield make
    for end in ends:
        os.close(end)


def row(index, *, answered=True):
    """Bytes of a row of two joints."""
    measured = (0.1, 0.2, 0.3, 0.4, 0.5, NAN) if answered else (NAN,) * 6
    values = (index, 0.01 * index, 0.02, 1e-4, 2e-4, *(1.0, 2.0, 3.0, 4.0, 5.0, 6.0), *measured)
    assert len(values) == row_length(2)
    return struct.pack(f"={len(values)}d", *values)


def test_rows_are_whole_however_the_bytes_come(pipe_of):
    data = row(0) + row(1) + row(2)
    for cut in (1, 100, len(row(0)), len(row(0)) + 7):
        batches = list(read_rows(pipe_of(data[:cut], data[cut:]), 2))
        assert [one.cycle for rows in batches for one in rows] == [0, 1, 2]


def test_a_row_that_was_cut_off_in_the_end_is_left_out(pipe_of):
    batches = list(read_rows(pipe_of(row(0) + row(1)[:-1]), 2))
    assert [one.cycle for rows in batches for one in rows] == [0]


def test_a_line_has_units_and_empty_cells_for_what_is_not_known(pipe_of):
    out = io.StringIO()
    write_lines(pipe_of(row(7), row(8, answered=False)), ["deg", "mm"], out)
    full, empty = csv.reader(out.getvalue().splitlines())
    assert full[:5] == ["7", "0.070000", "0.020000", "0.1000", "0.2000"]
    assert float(full[5]) == pytest.approx(57.29577951)
    assert float(full[6]) == pytest.approx(2000.0)
    assert full[-2:] == ["0.5", ""]
    assert empty[-6:] == [""] * 6
    assert len(full) == len(empty) == 17


def test_a_row_becomes_messages_that_readers_know(pipe_of):
    pytest.importorskip("mcap", reason="the extra log is not installed")
    from mcap.reader import make_reader

    from splinearm.control.mcap_scribe import McapScribe

    out = io.BytesIO()
    McapScribe(["a", "b"], 10**18, out).write_all(pipe_of(row(7), row(8, answered=False)))
    out.seek(0)
    found = [(c.topic, json.loads(m.data)) for _, c, m in make_reader(out).iter_messages()]
    topics = [topic for topic, _ in found]
    assert sorted(topics) == sorted(["/joint_commands", "/loop"] * 2 + ["/joint_states"])
    states = dict(found)["/joint_states"]
    assert (states["name"], states["position"]) == (["a", "b"], [0.1, 0.2])
    assert dict(found)["/loop"]["current"] == []
