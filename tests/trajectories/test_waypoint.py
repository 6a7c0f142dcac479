import numpy as np
import pytest

from splinearm.kinematics.pose import Pose
from splinearm.trajectories.waypoint import Move, Waypoint

POSITION = np.array([0.3, 0.1, 0.0])


def test_a_waypoint_keeps_its_own_frozen_copy():
    p = POSITION.copy()
    waypoint = Waypoint(position=p)
    p[0] = 9.0
    assert waypoint.position[0] == 0.3
    assert not waypoint.position.flags.writeable


@pytest.mark.parametrize(
    "places",
    [
        {},
        {"position": POSITION, "q": np.zeros(2)},
        {"pose": Pose.identity(), "position": POSITION},
        {"pose": Pose.identity(), "position": POSITION, "q": np.zeros(2)},
    ],
)
def test_a_place_is_said_exactly_once(places):
    with pytest.raises(ValueError, match="exactly one of pose, position and q"):
        Waypoint(**places)


@pytest.mark.parametrize(
    ("wrong", "error", "says"),
    [
        ({"speed": 0.0}, ValueError, "speed"),
        ({"speed": -1.0}, ValueError, "speed"),
        ({"speed": float("nan")}, ValueError, "speed"),
        ({"speed": float("inf")}, ValueError, "speed"),
        ({"blend": -0.001}, ValueError, "blend"),
        ({"blend": float("nan")}, ValueError, "blend"),
        ({"dwell": -1.0}, ValueError, "dwell"),
        ({"dwell": float("inf")}, ValueError, "dwell"),
        ({"move": "line"}, TypeError, "move"),
        ({"position": [1.0, 2.0]}, ValueError, "position"),
        ({"position": [1.0, float("nan"), 0.0]}, ValueError, "position"),
        ({"move": Move.LINE, "blend": 0.01, "stop": True}, ValueError, "blend"),
        ({"move": Move.LINE, "blend": 0.01, "dwell": 0.5}, ValueError, "blend"),
        ({"move": Move.BSPLINE, "blend": 0.01}, ValueError, "blend"),
    ],
)
def test_what_makes_no_sense_is_refused(wrong, error, says):
    with pytest.raises(error, match=says):
        Waypoint(**{"position": POSITION, **wrong})


def test_a_pose_must_be_a_pose():
    with pytest.raises(TypeError, match="pose: want a Pose, got ndarray"):
        Waypoint(pose=np.eye(4))


def test_a_dwell_is_a_stop():
    assert Waypoint(position=POSITION, dwell=0.1).stops
    assert Waypoint(position=POSITION, stop=True).stops
    assert not Waypoint(position=POSITION).stops


def test_moves_are_named_as_in_files():
    assert [move.value for move in Move] == ["bspline", "line", "arc", "joint"]
