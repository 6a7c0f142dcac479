"""Samples as numbers: the same in JSON, CSV, datagrams; in the units of people."""

import csv
import json
import math
import socket

import pytest

from splinearm.errors import ConfigError
from splinearm.joints import JointKind
from splinearm.monitoring.beat import Rhythm
from splinearm.monitoring.document import document, flat
from splinearm.monitoring.outlet import CsvFile, Datagrams, JsonLines
from splinearm.monitoring.sample import Level, Sample, ServoSample, Verdict


def sample(**changes):
    servo = ServoSample(
        servo_id=3,
        name="elbow",
        joint="elbow",
        model="XM430-W350",
        answers=True,
        position=math.pi / 3,
        velocity=-0.5,
        current=-1.2346,
        mean_current=0.8,
        temperature=41.0,
        voltage=11.9,
        errors=("overload", "overheating"),
        torque=True,
        moving=False,
        reads=1000,
        lost=3,
        damaged=2,
        retries=1,
        verdict=Verdict(level=Level.STOP, code="S10", what="overload error", remedy="free it"),
    )
    rail = ServoSample(
        servo_id=9, name="rail", joint="rail", model="", kind=JointKind.PRISMATIC, position=0.0125
    )
    whole = {
        "t": 1795375956.4158234,
        "number": 7,
        "port": "/dev/ttyUSB0",
        "baud": 1_000_000,
        "arm": "mine",
        "trouble": "",
        "rhythm": Rhythm(wanted=50.0, rate=49.876),
        "servos": (servo, rail),
    }
    return Sample(**(whole | changes))


def test_a_document_has_the_units_in_its_names():
    said = document(sample())
    elbow, rail = said["servos"]["elbow"], said["servos"]["rail"]
    assert elbow["position_deg"] == 60.0
    assert elbow["velocity_deg_s"] == pytest.approx(-28.65)
    assert elbow["current_a"] == -1.235
    assert elbow["load_percent"] is None
    assert elbow["errors"] == ["overload", "overheating"]
    assert (elbow["code"], elbow["remedy"], elbow["level"]) == ("S10", "free it", "stop")
    assert rail["position_mm"] == 12.5
    assert rail["answers"] is False
    assert said["lost"] == 3
    assert said["jitter_ms"] == {"p50": None, "p99": None, "max": None}
    assert said["level"] == "stop"


def test_a_port_that_is_gone_stops_everything():
    said = document(sample(trouble="it is gone", servos=()))
    assert (said["connected"], said["trouble"], said["level"]) == (False, "it is gone", "stop")


def test_json_csv_and_datagrams_say_the_same(tmp_path):
    said = document(sample())
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(5.0)
        with Datagrams(f"127.0.0.1:{listener.getsockname()[1]}") as udp:
            udp.take(said)
        datagram = json.loads(listener.recv(65536))
    with (tmp_path / "lines").open("w", encoding="utf-8") as stream:
        lines = JsonLines(stream)
        lines.take(said)
        lines.take(said)
        lines.close()
    rows = CsvFile(tmp_path / "rows.csv")
    rows.take(said)
    rows.take(said)
    rows.close()
    first, second = (tmp_path / "lines").read_text(encoding="utf-8").splitlines()
    assert json.loads(first) == json.loads(second) == datagram == said
    with (tmp_path / "rows.csv").open(newline="", encoding="utf-8") as stream:
        [row, again] = csv.DictReader(stream)
    assert row == again == flat(said)
    assert row["elbow.position_deg"] == "60.0"
    assert row["elbow.torque"] == "1"
    assert row["rail.temperature_degc"] == ""
    assert row["jitter_ms.p50"] == ""


def test_a_file_that_is_there_is_not_overwritten(tmp_path):
    file = tmp_path / "rows.csv"
    file.write_text("mine", encoding="utf-8")
    with pytest.raises(ConfigError, match="is there already"):
        CsvFile(file)
    with pytest.raises(ConfigError, match="cannot be written"):
        CsvFile(tmp_path / "nowhere" / "rows.csv")
    assert file.read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize("where", ["", "9870", "localhost", "localhost:0", "localhost:x", ":70000"])
def test_an_address_that_is_none_is_refused(where):
    with pytest.raises(ConfigError, match="want HOST:PORT"):
        Datagrams(where)


def test_what_cannot_be_sent_is_counted():
    with Datagrams("localhost:9") as udp:
        udp.take({"too": "long" * 20_000})
    assert udp.unsent == 1


def test_a_host_that_is_not_known_is_refused():
    with pytest.raises(ConfigError, match="not known here"):
        Datagrams("no.such.host.invalid:9870")
