import builtins
import json
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from splinearm.control.mcap_log import McapLog
from splinearm.control.record import Cycle
from splinearm.errors import ConfigError
from splinearm.joints import JointSetpoint, JointState

mcap = pytest.importorskip("mcap", reason="the extra log is not installed")

NAMES = ["shoulder", "elbow"]


def cycle(k, *, answered=True):
    q = np.array([0.1 * k, -0.2 * k])
    state = JointState(t=0.01 * k, q=q + 0.001, qd=q, current=np.array([0.5, np.nan]))
    return Cycle(
        index=k,
        t=0.01 * k,
        lateness=1e-4,
        setpoint=JointSetpoint(t=0.01 * k, q=q, qd=q, qdd=q),
        state=state if answered else None,
        busy=2e-3,
    )


def rows_of(file):
    """Read what is whole of a file, as a reader of a stream does."""
    from mcap.exceptions import McapError
    from mcap.records import Channel, Message
    from mcap.stream_reader import StreamReader

    topics, rows = {}, {}
    with file.open("rb") as stream:
        try:
            for record in StreamReader(stream).records:
                if isinstance(record, Channel):
                    topics[record.id] = record.topic
                if isinstance(record, Message):
                    topic = topics[record.channel_id]
                    rows.setdefault(topic, []).append((record.log_time, json.loads(record.data)))
        except McapError:
            pass  # the last record of a killed program
    return rows


def test_every_cycle_is_kept_in_the_shape_of_a_joint_state(tmp_path):
    file = tmp_path / "run.mcap"
    with McapLog(NAMES, file) as log:
        for k in range(50):
            log(cycle(k, answered=k != 7))
    rows = rows_of(file)
    assert {topic: len(found) for topic, found in rows.items()} == {
        "/joint_states": 49,
        "/joint_commands": 50,
        "/loop": 50,
    }
    at, command = rows["/joint_commands"][10]
    assert command["name"] == NAMES
    assert command["position"] == pytest.approx([1.0, -2.0])
    stamp = command["header"]["stamp"]
    assert stamp["sec"] * 10**9 + stamp["nanosec"] == at
    assert at - rows["/joint_commands"][0][0] == pytest.approx(0.1e9, abs=2)
    assert rows["/joint_states"][10][1]["position"][0] == pytest.approx(1.101)
    loop = rows["/loop"][7][1]
    assert (loop["answered"], loop["current"]) == (False, [])
    assert rows["/loop"][8][1]["current"] == [0.5, None]


def test_a_reader_of_whole_files_finds_schemas_and_topics(tmp_path):
    from mcap.reader import make_reader

    file = tmp_path / "run.mcap"
    with McapLog(NAMES, file) as log:
        log(cycle(0))
    with file.open("rb") as stream:
        found = [(s.name, s.encoding, c.topic) for s, c, _ in make_reader(stream).iter_messages()]
    assert ("sensor_msgs/JointState", "jsonschema", "/joint_states") in found


def test_a_killed_program_leaves_its_rows_up_to_the_last_flush(tmp_path):
    file = tmp_path / "run.mcap"
    code = f"""
import sys, time
sys.path.insert(0, {str(Path(__file__).parent)!r})
from pathlib import Path
from test_mcap_log import McapLog, NAMES, cycle
log = McapLog(NAMES, Path({str(file)!r}))
for k in range(40):
    log(cycle(k))
time.sleep(0.7)
print("written", flush=True)
log(cycle(40))
time.sleep(60)
"""
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as run:
        assert run.stdout.readline() == "written\n"
        run.send_signal(signal.SIGKILL)
    assert [row["cycle"] for _, row in rows_of(file)["/loop"]][:40] == list(range(40))


def test_a_file_that_is_there_is_kept_and_a_folder_that_is_not_is_named(tmp_path):
    (tmp_path / "run.mcap").write_text("mine")
    with pytest.raises(ConfigError, match="is there already"):
        McapLog(NAMES, tmp_path / "run.mcap")
    assert (tmp_path / "run.mcap").read_text() == "mine"
    with pytest.raises(ConfigError, match="cannot be written"):
        McapLog(NAMES, tmp_path / "none" / "run.mcap")


def test_without_the_package_the_extra_is_named(tmp_path, monkeypatch):
    real = builtins.__import__

    def refuse(name, *more, **others):
        if name.startswith("mcap"):
            raise ImportError(name)
        return real(name, *more, **others)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(ConfigError, match=r"pip install 'splinearm\[log\]'"):
        McapLog(NAMES, tmp_path / "run.mcap")
    assert not (tmp_path / "run.mcap").exists()
