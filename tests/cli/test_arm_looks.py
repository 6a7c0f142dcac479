"""``splinearm arms show | compare | reach``."""

import csv
import re

import numpy as np
import pytest

from splinearm.cli.main import DONE, REFUSED
from splinearm.config import load_cell, shipped_arms
from splinearm.kinematics.mjcf import write_mjcf
from splinearm.kinematics.urdf import write_urdf


@pytest.mark.parametrize("name", shipped_arms())
@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_show_prints_a_row_for_each_joint_in_either_convention(cli, name, convention):
    assert cli("arms", "show", name, "--convention", convention) == DONE
    assert f"{convention} DH table" in cli.out
    for joint in load_cell(name).arm.joint_names:
        assert len(re.findall(rf"\b{joint}\b", cli.out)) == 2
    assert re.search(r"reach: \d+ mm from the base", cli.out)


def test_show_keeps_the_arms_own_table_and_draws_it(cli):
    assert cli("arms", "show", "planar_2r", "--plot", "arm.png") == DONE
    assert "standard DH table: Rz(theta) Tz(d) Tx(a) Rx(alpha)" in cli.out
    assert re.search(r"joint1 \D* 300 ", cli.out)
    assert "moved by 250 mm along x" in cli.out
    assert re.search(r"reach: 5[45]\d mm", cli.out)
    assert (cli.folder / "arm.png").read_bytes().startswith(b"\x89PNG")


def test_show_reads_descriptions(cli):
    arm = load_cell("wx250s").arm
    cli.write("mine.urdf", write_urdf(arm))
    cli.write("mine.xml", write_mjcf(arm))
    assert cli("arms", "show", "mine.urdf") == DONE
    assert "254.902" in cli.out
    assert cli("arms", "show", "mine.xml", "--convention", "modified") == DONE
    assert "254.902" in cli.out
    assert cli("arms", "show", "mine.urdf", "--tip", "elbow_link") == DONE
    assert "3 joints" in cli.out
    assert cli("arms", "show", "mine.urdf", "--tip", "nose") == REFUSED
    assert "mine.urdf: link 'nose': is not there" in cli.err


def test_show_says_when_no_table_is_exact(cli):
    # half a turn written down as vendors do
    text = write_urdf(load_cell("planar_2r").arm)
    cli.write("mine.urdf", text.replace('rpy="0.0 0.0 0.0"', 'rpy="0.0 3.1415927 0.0"'))
    assert cli("arms", "show", "mine.urdf") == DONE
    words = " ".join(cli.out.split())
    assert "no exact standard DH table" in words
    assert "'joint1' and 'joint2'" in words
    assert "taken as parallel, off by" in words
    assert re.search(r"joint2 \D* ", cli.out)


def test_compare_says_that_an_arm_is_the_same_in_another_file(cli):
    cli.write("mine.urdf", write_urdf(load_cell("koch_v1_1").arm))
    assert cli("arms", "compare", "koch_v1_1", "mine.urdf") == DONE
    assert "They are the same." in cli.out


def test_compare_says_in_words_what_differs(cli):
    cli.arm()
    changed = cli.arm(("theta_deg = 0.0", "theta_deg = 90.0")).rename(cli.folder / "other.toml")
    cli.arm()
    assert cli("arms", "compare", "mine.toml", changed) == 1
    words = " ".join(cli.out.split())
    assert "deg about its z axis (or shoulder counts from elsewhere" in words
    assert "explain all that differs" in words


def test_arms_that_cannot_be_compared(cli):
    assert cli("arms", "compare", "planar_2r", "wx250s") == REFUSED
    assert "want as many joints, got 2 of 'planar_2r' and 6" in cli.err


def test_reach_writes_and_draws_a_map(cli):
    words = ("--spacing-mm", "100", "--processes", "1", "--out", "map.csv", "--plot", "map.png")
    assert cli("arms", "reach", "planar_2r", *words) == DONE
    assert re.search(r"\d+ of \d+ points reached, 100 mm apart", cli.out)
    rows = list(csv.DictReader((cli.folder / "map.csv").read_text().splitlines()))
    assert {row["z_mm"] for row in rows} == {"60"}
    reached = [row for row in rows if row["reached"] == "1"]
    assert all(np.hypot(float(r["x_mm"]), float(r["y_mm"])) < 551.0 for r in reached)
    assert (cli.folder / "map.png").read_bytes().startswith(b"\x89PNG")
    assert cli("arms", "reach", "planar_2r", *words) == REFUSED
    assert "not overwritten" in cli.err


def test_reach_writes_arrays(cli):
    words = ("--spacing-mm", "300", "--orientations", "6", "--processes", "1")
    assert cli("arms", "reach", "wx250s", *words, "--out", "map.npz") == DONE
    assert "of 6 orientations" in cli.out
    with np.load(cli.folder / "map.npz") as found:
        assert found["points"].shape[1] == 3
        assert found["quats"].shape == (6, 4)
        assert 0.0 < found["fraction"].max() <= 1.0


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--spacing-mm", "-1"), "spacing"),
        (("--spacing-mm", "0.01"), "points; want at most"),
        (("--orientations", "-1"), "orientations"),
        (("--processes", "0"), "processes"),
        (("--out", "map.txt"), ".npz or .csv"),
    ],
)
def test_numbers_that_make_no_map(cli, words, says):
    assert cli("arms", "reach", "wx250s", *words) == REFUSED
    assert says in cli.err
    assert not cli.files()
