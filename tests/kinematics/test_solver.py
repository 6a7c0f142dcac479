import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.kinematics import DHConvention, Pose, descent, search_kernel, solver, start
from splinearm.kinematics.ik import goal_of

seeds = st.integers(0, 100_000)

ASKED = """
import json, sys
import numpy as np
from splinearm.kinematics import descent_kernel, search_kernel
question = {name: np.array(value) for name, value in json.load(sys.stdin).items()}
O, B, G, q = (question[name] for name in ("O", "B", "G", "q"))
n = len(q)
J, miss = np.empty((n, 6)), np.empty(6)
"""

DESCENT_AND_SEARCH = f"""{ASKED}
seen = descent_kernel.look(O, G, B[2], q, J, miss)
ended = descent_kernel.descend(O, B[0], B[1], B[2], G, q, 1.0, 40, descent_kernel.workspace(n))
answers = np.empty((1, n + 4))
search_kernel.search_batch(
    O, B, G[None], question["starts"], question["tools"], question["seeds"], question["how"],
    np.array([20]), answers,
)
found = [seen, J, miss, q, ended[:4], answers]
"""

SINGLE_STEPS = f"""{ASKED}
found = []
for start in question["starts"]:
    found += [descent_kernel.look(O, G, B[2], start, J, miss), J.copy(), miss.copy()]
    work = descent_kernel.workspace(n)
    found += [descent_kernel.descend(O, B[0], B[1], B[2], G, start, 0.5, 1, work)[:4], start]
"""


def question_of(arm, there, q, starts):
    """Give what a process of its own needs to go to where joints bring the tool, as text."""
    model = solver.model_of(arm)
    goal = goal_of(arm, Pose.from_matrix(arm.fk(np.array(there))), 1e-9, 1e-9)
    question = {
        "O": model.packed,
        "B": model.bounds,
        "G": solver.goal_numbers(goal),
        "q": np.array(q),
        "starts": model.starts[:starts],
        "tools": model.tools[:, :starts],
        "seeds": np.array([[model.middle, model.middle]]),
        "how": solver.how(),
    }
    return json.dumps({name: value.tolist() for name, value in question.items()})


def test_kernels_say_the_same_compiled_and_not(known_arm, compiled_as_plain):
    there, q = [0.3, -0.5, 0.2, -1.8, 0.4, 1.6], [0.1, -0.3, 0.1, -1.5, 0.3, 1.4]
    question = question_of(known_arm("puma"), there, q, 64)
    compiled_as_plain(DESCENT_AND_SEARCH, 6, given=question)


def test_single_steps_of_a_redundant_arm_are_the_same_compiled_and_not(
    known_arm, compiled_as_plain
):
    # of seven joints only steps: what rounding leaves of the free direction grows from step to step
    there = [0.3, -0.5, 0.2, -1.8, 0.4, 1.6, 0.1]
    question = question_of(known_arm("panda"), there, np.zeros(7), 24)
    compiled_as_plain(SINGLE_STEPS, 24 * 5, given=question)


@pytest.mark.property
@given(seeds, st.integers(2, 8), st.sampled_from(list(DHConvention)), st.booleans())
@settings(deadline=None, max_examples=40)
def test_compiled_descents_end_where_those_on_numpy_end(
    random_arm, joints_inside, seed, n, convention, whole
):
    arm = random_arm(seed, n, convention)
    rng = np.random.default_rng(seed)
    T = arm.fk(joints_inside(arm, rng))
    goal = goal_of(arm, Pose.from_matrix(T) if whole else T[:3, 3], 1e-6, 1e-6)
    q = joints_inside(arm, rng)
    solver.load()
    compiled = solver.descend(arm.packed, goal, q, max_step=0.5, max_iterations=8)
    plain = descent.descend(arm.packed, goal, q, max_step=0.5, max_iterations=8)
    np.testing.assert_allclose(compiled.q, plain.q, atol=1e-6)
    assert compiled.position_error == pytest.approx(plain.position_error, abs=1e-7)
    assert compiled.orientation_error == pytest.approx(plain.orientation_error, abs=1e-7)


def test_starts_are_tried_in_the_order_that_numpy_tries_them(widowx):
    target = Pose([2.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0])
    goal = goal_of(widowx, target, 1e-6, 1e-6)
    # so many starts that this is not one of the hopeless targets that get a few
    solver.load()
    inquiry = solver.inquiry(widowx, (1e-6, 1e-6), 40, seeded=False, posed=True)
    inquiry.terms[search_kernel.REACH] = 9.0
    _, _, said, rests = inquiry.put(target.p, target.quat, inquiry.middle)
    assert said[0] == 0.0
    loose = solver.loosened(widowx, goal)
    starts = start.near_and_far(widowx.packed, goal, 40)
    for row, q in zip(rests[: len(starts)], starts, strict=True):
        plain = descent.descend(
            widowx.packed,
            loose,
            q,
            max_step=solver.STEP,
            max_iterations=solver.FIRST_ITERATIONS,
        )
        assert row[6] == pytest.approx(plain.cost, rel=1e-3)


def test_one_search_does_not_load_numba(python):
    code = (
        "import sys; import numpy as np; import splinearm.kinematics as k\n"
        "rows = [k.DHLink('a', 0.3, 0, 0, 0), k.DHLink('b', 0.2, 0, 0, 0)]\n"
        "from splinearm.joints import JointKind, JointLimits\n"
        "two = np.ones(2)\n"
        "limits = JointLimits(names=('a', 'b'), kinds=(JointKind.REVOLUTE,) * 2, q_min=-2 * two,\n"
        "    q_max=2 * two, qd_max=two, qdd_max=two)\n"
        "arm = k.Arm.from_dh('two', rows, k.DHConvention.STANDARD, limits)\n"
        "assert k.search(arm, [0.3, 0.2, 0.0]).reached\n"
        "assert 'numba' not in sys.modules\n"
        "from splinearm.kinematics import solver\n"
        "solver.prepare()\n"
        "assert 'numba' in sys.modules\n"
        "assert k.search(arm, [0.3, 0.2, 0.0]).reached\n"
    )
    python(code)
