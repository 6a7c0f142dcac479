"""``--json`` of commands that look: what programs read is what people are told."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from splinearm.backends import centred
from splinearm.cli.arm_document import arm_document
from splinearm.config import load_cell, shipped_arms
from splinearm.control.stop import StopRequest
from splinearm.sim.virtual_bus import VirtualBus


@pytest.fixture
def said(cli):
    """Runs a command with --json; gives the document, after checking that it is all there is."""

    def run(*words, code=0):
        assert cli(*words, "--json") == code
        document = json.loads(cli.out)
        assert re.fullmatch(r"splinearm-[a-z-]+/1", document["schema"])
        return document

    return run


def test_the_list_of_arms(said, cli):
    arms = said("arms")["arms"]
    assert tuple(arm["name"] for arm in arms) == shipped_arms()
    cli("arms")
    for arm in arms:
        assert arm["title"].split()[0] in cli.out
        assert load_cell(arm["file"]).arm.n == arm["joint_count"]


@pytest.mark.parametrize("name", ["koch_v1_1", "planar_2r", "wx250s"])
def test_an_arm_in_full(said, name):
    arm, cell = said("arms", "show", name), load_cell(name)
    limits = cell.arm.limits
    assert [joint["name"] for joint in arm["joints"]] == list(limits.names)
    assert [joint["max_deg"] for joint in arm["joints"]] == pytest.approx(
        cell.to_file_units(limits.q_max).tolist()
    )
    assert [s["id"] for s in arm["servos"]] == [s.servo_id for s in cell.chain.servos]
    assert arm["bus"]["baud"] == cell.chain.baud
    assert set(arm["poses"]) == set(cell.poses)
    assert arm["reach"]["farthest_mm"] > 100.0
    if cell.arm.dh is not None:
        assert len(arm["dh"]["rows"]) == cell.arm.n
        assert arm["dh"]["own"] is True


def test_a_joint_that_never_ends_has_no_bounds():
    cell = load_cell("planar_2r")
    endless = np.array([np.inf, 1.0])
    limits = replace(cell.arm.limits, q_min=-endless, q_max=endless)
    joints = arm_document(replace(cell, arm=replace(cell.arm, limits=limits)), None)["joints"]
    assert (joints[0]["min_deg"], joints[0]["max_deg"]) == (None, None)
    assert joints[1]["max_deg"] == pytest.approx(57.29577951)


def test_two_arms_compared(said):
    same = said("arms", "compare", "rx150", "rx150")
    assert (same["same"], same["differences"]) == (True, [])
    other = said("arms", "compare", "rx150", "wx200", code=1)
    assert other["same"] is False
    assert any("shoulder" in words for words in other["differences"])


def test_the_word_may_stand_before_the_look(cli):
    assert cli("arms", "--json", "compare", "rx150", "rx150") == 0
    assert json.loads(cli.out)["same"] is True


@pytest.mark.kernel
def test_a_map_of_reach(said):
    found = said("arms", "reach", "planar_2r", "--processes", "1")
    assert 0 < found["reached"] <= found["points"]
    assert found["mean_percent"] is None


def test_a_plan(said, cli):
    job = cli.job()
    plan = said("plan", job)
    assert cli("plan", job) == 0
    assert f"duration: {plan['duration_s']:.3f} s" in cli.out
    assert plan["waypoint_times_s"][-1] == pytest.approx(plan["duration_s"])
    assert all(peak["share"] is None or peak["share"] <= 1.0 + 1e-6 for peak in plan["peaks"])
    assert {peak["joint"] for peak in plan["peaks"]} == {"joint1", "joint2"}


WHEEL = """<robot name="wheel"><link name="base"/><link name="tip"/>
<joint name="turn" type="continuous"><parent link="base"/><child link="tip"/>
<axis xyz="0 0 1"/><limit velocity="2" effort="5"/></joint></robot>"""


def test_a_plan_of_a_joint_that_turns_for_ever_is_json_too(said, cli):
    cli.write("wheel.urdf", WHEEL)
    head = 'schema = "splinearm-job/1"\nname = "w"\ntitle = "W"\narm = "wheel.urdf"\n'
    place = 'start_deg = [0.0]\n[[waypoint]]\nthrough = "joint"\njoints_deg = [100.0]\n'
    place_of, *rates = said("plan", cli.write("job.toml", head + place))["peaks"]
    assert "Infinity" not in cli.out
    assert (place_of["quantity"], place_of["limit"], place_of["share"]) == ("position", None, None)
    assert all(0.0 < rate["share"] <= 1.0 + 1e-6 for rate in rates)


@pytest.mark.bus
def test_servos_that_are_recovered_and_led(said, monkeypatch):
    cell = load_cell("wx250s")
    home = cell.poses["home"]
    with VirtualBus(cell.arm, centred(cell.chain), home, transport="socket") as bus:
        with bus.lock:
            bus.servos[4].fail("overload")
        look = said("recover", "wx250s", "--port", bus.port, "--look", code=2)
        assert look["faults"] == [
            {"id": 4, "name": "elbow", "joint": "elbow", "status": 32, "causes": ["overload"]}
        ]
        assert (look["recovered"], look["holds_at"]) == (False, None)
        done = said("recover", "wx250s", "--port", bus.port)
        assert done["recovered"] is True
        assert done["holds_at"]["wrist_angle"] == pytest.approx(60.0, abs=2.0)
        monkeypatch.setattr(StopRequest, "requested", property(lambda self: True))
        led = said("guide", "wx250s", "--port", bus.port)
        assert led["holds_at"] == pytest.approx(done["holds_at"], abs=5.0)
