"""The turn of a tool about its own axis, and the configuration of the arm."""

import numpy as np
import pytest

from splinearm import load_cell
from splinearm.toolpaths.setting import Setting, rotations_about, standing, tool_axis_of
from splinearm.toolpaths.turn_search import STEP, TurnQuestion, bounds_of, search_turns, solver_of

CELL = load_cell("wx250s")
ARM, HOME = CELL.arm, CELL.poses["home"]
DOWN = np.array([0.0, 0.0, -1.0])
X = np.array([1.0, 0.0, 0.0])


def question(p, turns=24, turn=0.0):
    s = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))))
    return TurnQuestion(p=p, s=s, R=standing(X, DOWN, turn), axis=X, turns=turns)


def circle(x, y, radius, count=60, z=0.06):
    t = np.linspace(0.0, 2.0 * np.pi, count)
    return np.stack((x + radius * np.cos(t), y + radius * np.sin(t), np.full(count, z)), axis=1)


def test_the_tool_stands_at_every_place_as_it_shall():
    p = circle(0.25, 0.0, 0.05)
    found = search_turns(ARM, question(p), HOME)
    T = ARM.fk(found.q)
    assert np.abs(T[:, :3, 3] - p).max() < 1e-9
    assert np.abs(T[:, :3, 0] - DOWN).max() < 1e-9
    turned = standing(X, DOWN, 0.0) @ rotations_about(X, found.turn)
    assert np.abs(T[:, :3, :3] - turned).max() < 1e-9


def test_no_joint_jumps_or_leaves_its_limits():
    p = circle(0.1, 0.0, 0.22, count=240)  # behind the shoulder as well
    found = search_turns(ARM, question(p, turns=72), HOME)
    assert len(found.q) > 100
    assert np.abs(np.diff(found.q, axis=0)).max() <= STEP
    assert (found.q >= ARM.limits.q_min).all()
    assert (found.q <= ARM.limits.q_max).all()


def test_a_free_turn_leads_where_a_kept_one_runs_into_a_limit():
    # the last joint would pass its limit if the tool did not turn with the waist
    p = circle(0.0, 0.0, 0.2, count=200)[:180]
    held = [len(search_turns(ARM, question(p, 1, turn), HOME).q) for turn in (0.0, 1.5, 3.0)]
    assert max(held) < len(p)
    around = p[:80]
    assert len(search_turns(ARM, question(around, 72), HOME).q) == len(around)


@pytest.mark.kernel
def test_it_is_the_cheapest_way_of_all():
    p = circle(0.25, 0.05, 0.02, count=4)
    asked = question(p, turns=3)
    found = search_turns(ARM, asked, HOME)
    # of every way through all turns and branches by hand
    solve = solver_of(ARM, HOME)
    T = np.zeros((3, 4, 4, 4))
    T[..., 3, 3] = 1.0
    T[..., :3, :3] = asked.R @ rotations_about(X, 2.0 * np.pi * np.arange(3) / 3)[:, None]
    T[..., :3, 3] = p
    nodes = solve(T.reshape(-1, 4, 4)).reshape(3, 4, -1, 6).transpose(1, 0, 2, 3).reshape(4, -1, 6)
    low, high = ARM.limits.q_min, ARM.limits.q_max
    speed = ARM.limits.qd_max
    best = np.inf
    for first in nodes[0][np.isfinite(nodes[0, :, 0])]:
        if not ((first >= low) & (first <= high)).all():
            continue
        cost, q = 0.3 * (np.abs(first - HOME) / speed).sum(), first
        for layer in nodes[1:]:
            step = np.abs(layer - q)
            step[~np.isfinite(step)] = np.inf
            fits = (step <= STEP).all(axis=1)
            if not fits.any():
                cost = np.inf
                break
            sums = np.where(fits, (step / speed).sum(axis=1), np.inf)
            cost, q = cost + sums.min(), layer[np.argmin(sums)]
        best = min(best, cost)
    own = 0.3 * (np.abs(found.q[0] - HOME) / speed).sum()
    own += (np.abs(np.diff(found.q, axis=0)) / speed).sum()
    assert own <= best * (1.0 + 1e-9)


def test_a_place_out_of_reach_ends_the_way_and_is_said_to_be_so():
    p = np.linspace((0.25, 0.0, 0.06), (0.9, 0.0, 0.06), 120)
    found = search_turns(ARM, question(p), HOME)
    assert 10 < len(found.q) < 120
    assert not found.reached
    assert len(search_turns(ARM, question(p[::-1].copy()), HOME).q) == 0


@pytest.mark.parametrize(
    ("name", "axis"),
    [("wx250s", X), ("rx150", X), ("koch_v1_1", -X), ("open_manipulator_x", X)],
)
def test_shipped_arms_point_along_their_gripper(name, axis):
    arm = load_cell(name).arm
    assert np.allclose(tool_axis_of(arm, Setting(T_base_work=np.eye(4))), axis, atol=1e-9)


@pytest.mark.parametrize("points", [DOWN, -DOWN, X, -X, np.array([0.6, 0.0, -0.8])])
def test_the_axis_of_a_standing_tool_points_where_it_shall(points):
    R = standing(X, points, 0.7)
    assert np.allclose(R @ X, points)
    assert np.allclose(R.T @ R, np.eye(3))
    assert np.linalg.det(R) == pytest.approx(1.0)


@pytest.mark.kernel
@pytest.mark.parametrize("name", ["rx150", "open_manipulator_x"])
def test_arms_of_fewer_joints_point_down_too(name):
    cell = load_cell(name)
    arm, home = cell.arm, cell.poses["home"]
    p = circle(0.17, 0.0, 0.008, count=8)
    turns = 9 if arm.n == 5 else 1
    found = search_turns(arm, question(p, turns), home)
    T = arm.fk(found.q)
    assert len(T) == 8
    assert np.abs(T[:, :3, 3] - p).max() < 1e-8
    assert np.abs(T[:, :3, 0] - DOWN).max() < 1e-8


def test_compiled_and_plain_agree(compiled_as_plain):
    compiled_as_plain(
        """
import numpy as np
from splinearm import load_cell
from splinearm.toolpaths.setting import standing
from splinearm.toolpaths.turn_search import TurnQuestion, search_turns
cell = load_cell("rx150")
t = np.linspace(0.0, 2.0, 6)
p = np.stack((0.17 + 0.02 * np.cos(t), 0.02 * np.sin(t), np.full(6, 0.06)), axis=1)
x = np.array([1.0, 0.0, 0.0])
R = standing(x, np.array([0.0, 0.0, -1.0]), 0.0)
asked = TurnQuestion(p=p, s=0.01 * t, R=R, axis=x, turns=8)
answer = search_turns(cell.arm, asked, cell.poses["home"])
found = [answer.q, answer.turn]
""",
        2,
    )


@pytest.mark.kernel
def test_what_is_near_a_limit_costs_and_the_more_the_nearer():
    from splinearm.toolpaths import turn_search_kernel

    bounds = bounds_of(ARM)
    middle = 0.5 * (ARM.limits.q_min + ARM.limits.q_max)
    costs = []
    for share in (0.0, 0.85, 0.95, 1.0):
        q = middle.copy()
        q[3] += share * 0.5 * (bounds[1, 3] - bounds[0, 3])
        costs.append(turn_search_kernel.near_limits(q, bounds))
    assert costs[0] == 0.0
    assert 0.0 < costs[1] < costs[2] < costs[3] == pytest.approx(1.0)


def test_singular_postures_are_gone_round():
    # straight past the place above the shoulder's axis, where waist and wrist turn about one line
    p = np.linspace((0.12, -0.1, 0.25), (0.12, 0.1, 0.25), 80)
    found = search_turns(ARM, question(p, turns=36), HOME)
    J = ARM.jacobian(found.q)
    J[:, 3:] *= 0.1
    least = np.linalg.svd(J, compute_uv=False)[:, -1]
    held = search_turns(ARM, question(p, turns=1), HOME)
    J = ARM.jacobian(held.q)
    J[:, 3:] *= 0.1
    assert least.min() > 0.001
    assert least.min() >= 0.9 * np.linalg.svd(J, compute_uv=False)[:, -1].min()
