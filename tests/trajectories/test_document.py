import json
from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.curves.interpolation import interpolate
from splinearm.trajectories.document import from_document, to_document
from splinearm.trajectories.joint_path import JointPath
from splinearm.trajectories.polynomial_law import PolynomialLaw
from splinearm.trajectories.section import Section
from splinearm.trajectories.smooth_timing import quickest_smooth
from splinearm.trajectories.trajectory import JointTrajectory


@pytest.mark.property
@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 9999), dwell=st.sampled_from([0.0, 0.4]))
def test_through_json_a_motion_keeps_every_bit(seed, dwell, make_motion):
    motion = make_motion(seed, dwell)
    again = from_document(json.loads(json.dumps(to_document(motion, "an arm"))))
    ts = np.linspace(-0.1, motion.duration + 0.1, 300)
    for have, want in zip(again.sample(ts), motion.sample(ts), strict=True):
        assert np.array_equal(have, want)
    assert again.limits.names == motion.limits.names
    assert np.array_equal(again.limits.q_max, motion.limits.q_max)
    assert np.array_equal(again.limits.qdd_max, motion.limits.qdd_max)


def test_every_kind_of_law_is_kept(make_limits):
    limits = replace(make_limits([1.0, 2.0], [5.0, 9.0]), qddd_max=[50.0, 90.0])
    points = np.array([[0.0, 0.0], [0.5, 0.2], [0.3, 0.9], [0.1, 0.1]])
    path = JointPath(interpolate(points, degree=5))
    smooth = quickest_smooth(path, limits)
    first, last = path.domain
    law = PolynomialLaw(
        np.array([first, 0.0, 0.0, *((last - first) * np.array([10, -15, 6]))]), 3.0
    )
    motion = JointTrajectory(
        (Section(path, smooth, 0.2), Section(path.mirrored(first, last), law)), points[0], limits
    )
    stop = motion.stop_from(0.4 * smooth.duration)
    for whole in (motion, stop):
        again = from_document(json.loads(json.dumps(to_document(whole))))
        ts = np.linspace(-0.1, whole.duration + 0.1, 200)
        for have, want in zip(again.sample(ts), whole.sample(ts), strict=True):
            assert np.array_equal(have, want)
        assert [type(part.law) for part in again.sections] == [type(p.law) for p in whole.sections]


def _without(key):
    return lambda document: document.pop(key)


def _set(*keys, value):
    def change(document):
        for key in keys[:-1]:
            document = document[key]
        document[keys[-1]] = value

    return change


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (_without("sections"), "document: sections is missing"),
        (_set("format", value="splinearm-motion/9"), "want 'splinearm-motion/1'"),
        (_set("sections", value="all"), "sections: want a list"),
        (_set("sections", 0, "dwell_s", value=-1.0), r"sections\[0\].dwell_s: want a time"),
        (_set("sections", 0, "law", "kind", value="magic"), r"sections\[0\].law.kind"),
        (_set("sections", 0, "law", "s", 1, value=-5.0), r"sections\[0\].law.s: want rising"),
        (_set("sections", 0, "law", "x", 1, value=-5.0), r"sections\[0\].law.x: want none below"),
        (_set("sections", 0, "path", "degree", value=2), r"sections\[0\].path: "),
        (_set("sections", 0, "path", "knots", 0, value=None), r"sections\[0\].path: knots"),
        (_set("sections", 0, "path", value=3), r"sections\[0\].path: want names with values"),
        (_set("q_start", 0, value=9.0), r"sections\[0\]: begins .* from where the motion is"),
        (_set("sections", 0, "law", "x", -1, value=1.0), r"sections\[1\]: does not begin as fast"),
        (_set("joints", "qd_max", 0, value=0.0), "joints: qd_max: want numbers above zero"),
        (_set("joints", "kinds", 0, value="bends"), "joints: 'bends'"),
    ],
)
def test_a_document_that_holds_no_motion_is_refused_with_the_place(change, says, make_motion):
    document = deepcopy(to_document(make_motion(1)))
    change(document)
    with pytest.raises((TypeError, ValueError), match=says):
        from_document(document)
