"""An arm described one way after the other stays the same arm."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from splinearm.joints import JointKind, JointLimits
from splinearm.kinematics import DHConvention, Inertia, Link, screw
from splinearm.kinematics.dh_conversion import to_dh
from splinearm.kinematics.mjcf import read_mjcf, write_mjcf
from splinearm.kinematics.urdf import read_urdf, write_urdf

seeds = st.integers(0, 100_000)


def through_screws(arm):
    return screw.from_screws(
        arm.name,
        screw.screws_of(arm),
        arm.fk(np.zeros(arm.n)),
        arm.limits,
        inertias=screw.inertias_of(arm),
        T_world_base=arm.T_world_base,
    )


def through_tool_screws(arm):
    return screw.from_screws(
        arm.name,
        screw.screws_of(arm, "tool"),
        arm.fk(np.zeros(arm.n)),
        arm.limits,
        frame="tool",
        inertias=screw.inertias_of(arm),
        T_world_base=arm.T_world_base,
    )


WAYS = {
    "standard DH": lambda arm: to_dh(arm, DHConvention.STANDARD),
    "modified DH": lambda arm: to_dh(arm, DHConvention.MODIFIED),
    "screws": through_screws,
    "tool screws": through_tool_screws,
    "URDF": lambda arm: read_urdf(write_urdf(arm)).arm,
    "MJCF": lambda arm: read_mjcf(write_mjcf(arm)).arm,
}


def some_inertia(rng):
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    body = rng.uniform(0.001, 0.01, 3)
    tensor = R @ np.diag(body.sum() - body) @ R.T
    return Inertia(rng.uniform(0.1, 2.0), rng.uniform(-0.1, 0.1, 3), 0.5 * (tensor + tensor.T))


def furnished(arm, seed):
    """Give the arm all that an arm may have: inertias, jerk and torque limits, a place."""
    rng = np.random.default_rng(seed)
    endless = np.array([kind is JointKind.REVOLUTE for kind in arm.limits.kinds])
    endless &= rng.random(arm.n) < 0.3
    limits = JointLimits(
        names=arm.joint_names,
        kinds=arm.limits.kinds,
        q_min=np.where(endless, -inf, arm.limits.q_min),
        q_max=np.where(endless, inf, arm.limits.q_max),
        qd_max=rng.uniform(0.5, 3.0, arm.n),
        qdd_max=rng.uniform(0.5, 9.0, arm.n),
        qddd_max=rng.uniform(10.0, 90.0, arm.n) if rng.random() < 0.5 else None,
        torque_max=rng.uniform(1.0, 90.0, arm.n) if rng.random() < 0.5 else None,
    )
    known = rng.random() < 0.7
    links = tuple(replace(link, inertia=some_inertia(rng) if known else None) for link in arm.links)
    turned = np.eye(4)
    turned[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turned[:3, :3] *= np.linalg.det(turned[:3, :3])
    turned[:3, 3] = rng.uniform(-1, 1, 3)
    return replace(arm, limits=limits, links=links, T_world_base=turned)


@pytest.mark.property
@given(
    seeds,
    st.integers(2, 8),
    st.sampled_from(list(DHConvention)),
    st.lists(st.sampled_from(sorted(WAYS)), min_size=1, max_size=5),
)
@settings(deadline=None, max_examples=150)
def test_a_round_trip_in_any_order_loses_nothing(
    random_arm, assert_same_arm, seed, n, convention, ways
):
    arm = furnished(random_arm(seed, n, convention), seed)
    there = arm
    for way in ways:
        there = WAYS[way](there)
    assert_same_arm(there, arm)


@pytest.mark.parametrize("way", sorted(WAYS))
def test_each_way_keeps_the_name_and_does_not_mind_being_gone_twice(
    random_arm, assert_same_arm, way
):
    arm = furnished(random_arm(5, 6, DHConvention.STANDARD), 5)
    once = WAYS[way](arm)
    assert once.name == arm.name
    assert_same_arm(WAYS[way](once), arm)


def test_links_whose_frames_are_anywhere_go_round_too(assert_same_arm, limits_of):
    rng = np.random.default_rng(3)

    def anywhere():
        T = np.eye(4)
        T[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        T[:3, :3] *= np.linalg.det(T[:3, :3])
        T[:3, 3] = rng.uniform(-0.5, 0.5, 3)
        return T

    kinds = [JointKind.PRISMATIC, JointKind.REVOLUTE, JointKind.REVOLUTE, JointKind.PRISMATIC]
    names = ["base", "base_link", "tool", "world"]  # as awkward as names may be
    links = tuple(
        Link(name, kind, anywhere(), anywhere(), some_inertia(rng))
        for name, kind in zip(names, kinds, strict=True)
    )
    from splinearm.kinematics import Arm

    limits = limits_of(names, kinds, -np.ones(4), np.ones(4))
    arm = Arm("free", links, limits, T_flange_tool=anywhere(), T_base_first=anywhere())
    for way in WAYS.values():
        assert_same_arm(way(arm), arm)
