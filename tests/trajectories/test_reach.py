import numpy as np
import pytest

from splinearm.curves.segment import Arc, Line
from splinearm.kinematics import quaternion
from splinearm.trajectories.path import ToolPlaces, course_path, spline_path
from splinearm.trajectories.reach import PathLabels

NAMES = ("waypoint 1", "waypoint 2 'top'", "waypoint 3")


def test_a_place_is_named_and_a_way_is_measured_in_millimetres():
    p = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.1, 0.0]])
    path = course_path(
        ToolPlaces(p, None), [Line(p[0], p[1]), Line(p[1], p[2])], np.zeros(3), NAMES
    )
    labels = PathLabels(NAMES)
    assert labels.place(path, 0.1) == "waypoint 2 'top'"
    assert labels.place(path, 0.03).endswith("from waypoint 1 to waypoint 2 'top', 30 mm along it,")
    assert labels.place(path, 0.15).endswith("'top' to waypoint 3, 50 mm along it,")


def test_the_way_is_that_of_the_tool_where_it_turns_more_than_it_moves():
    p = np.array([[0.0, 0.0, 0.0], [0.02, 0.0, 0.0]])
    quats = quaternion.exp(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    path = course_path(ToolPlaces(p, quats), [Line(*p)], np.zeros(2), NAMES)
    assert path.domain[1] == pytest.approx(0.1)
    assert "10 mm along it," in PathLabels(NAMES).place(path, 0.05)


def test_a_turn_on_the_spot_is_measured_in_degrees():
    quats = quaternion.exp(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, np.radians(80.0)]]))
    path = course_path(
        ToolPlaces(np.zeros((2, 3)), quats), [Line(np.zeros(3), np.zeros(3))], np.zeros(2), NAMES
    )
    place = PathLabels(NAMES).place(path, 0.25 * path.domain[1])
    assert place == "the way from waypoint 1 to waypoint 2 'top', 20 deg into it,"


def test_arcs_and_splines_are_measured_along_themselves():
    start, via, end = np.array([[1.0, 0, 0], [np.sqrt(0.5), np.sqrt(0.5), 0], [0, 1.0, 0]])
    arc = Arc.through(start, via, end)
    path = course_path(ToolPlaces(np.array([start, end]), None), [arc], np.zeros(2), NAMES)
    place = PathLabels(NAMES).place(path, 0.5 * path.domain[1])
    assert f"{1e3 * np.pi / 4:.4g} mm along it," in place
    bent = spline_path(ToolPlaces(np.array([start, via, end]), None))
    middle = 0.5 * bent.waypoint_s[1]
    walked = np.linalg.norm(
        np.diff(bent.position.at(np.linspace(0.0, middle, 20_001)), axis=0), axis=1
    )
    assert f"{1e3 * walked.sum():.4g} mm along it," in PathLabels(NAMES).place(bent, middle)
