"""Arms as MJCF, the XML of MuJoCo; reading is in ``mjcf_reader``.

What MJCF has no word for, the highest speed, acceleration and jerk of a joint, stands in
``<custom>`` as numbers named ``qd_max/JOINT`` and so on; MuJoCo keeps and ignores them.
"""

from collections.abc import Sequence
from math import inf
from xml.etree import ElementTree as ET

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind, JointLimits

from . import body, quaternion, space
from .arm import Arm
from .description import SideJoint, free_name, take_off, text_of
from .home import home_of
from .link import Inertia
from .mjcf_reader import read_mjcf as read_mjcf

_TYPES = {JointKind.REVOLUTE: "hinge", JointKind.PRISMATIC: "slide"}
_MASSLESS = {"boundmass": "1e-6", "boundinertia": "1e-9"}
"""MuJoCo moves no body without mass: what it shall put in its place."""


def write_mjcf(arm: Arm, side_joints: Sequence[SideJoint] = ()) -> str:
    """Give an arm as the text of an MJCF; ``read_mjcf`` gives it back.

    Each body's frame is the one of the joint that moves it; the tool is a site.

    Args:
        arm: The arm.
        side_joints: What else moves on it.
    """
    home = home_of(arm)
    inertias = dict(zip(arm.joint_names, home.inertias, strict=True))
    take_off(inertias, arm.joint_names, side_joints)
    known = [*inertias.values(), *(side.inertia for side in side_joints)]
    model = ET.Element("mujoco", model=arm.name)
    compiler = ET.SubElement(model, "compiler", angle="radian", autolimits="true")
    if any(inertia is None or _is_thin(inertia) for inertia in known):
        compiler.attrib.update(_MASSLESS)
    if any(inertia is not None and _is_no_body(inertia) for inertia in known):
        compiler.set("balanceinertia", "true")
    world = ET.SubElement(model, "worldbody")
    taken = {"world"}
    above, T_above = _add_body(world, free_name("base", taken), arm.T_world_base), np.eye(4)
    places = {"": (above, T_above)}
    for i, name in enumerate(arm.joint_names):
        T = home.joints[i]
        above = _add_body(above, free_name(name, taken), space.rigid_inverse(T_above) @ T)
        _add_inertial(above, inertias[name], T)
        limits = arm.limits
        joint = _add_joint(above, name, limits.kinds[i], limits.q_min[i], limits.q_max[i])
        if limits.torque_max is not None:
            torque = limits.torque_max[i]
            joint.set("actuatorfrcrange", text_of((-torque, torque)))
        T_above = T
        places[name] = (above, T_above)
    site = ET.SubElement(above, "site", name="tool")
    _place(site, space.rigid_inverse(T_above) @ home.tool)
    for side in side_joints:
        holder, T_holder = places[side.parent]
        T = side.T_base_joint
        holder = _add_body(holder, free_name(side.name, taken), space.rigid_inverse(T_holder) @ T)
        _add_inertial(holder, side.inertia, T)
        _add_joint(holder, side.name, side.kind, side.q_min, side.q_max)
        places[side.name] = (holder, T)
    _add_mimics(model, side_joints)
    _add_rates(model, arm.limits)
    ET.indent(model)
    return ET.tostring(model, encoding="unicode") + "\n"


def _add_body(parent: ET.Element, name: str, T: FloatArray) -> ET.Element:
    element = ET.SubElement(parent, "body", name=name)
    _place(element, T)
    return element


def _place(element: ET.Element, T: FloatArray) -> None:
    element.set("pos", text_of(T[:3, 3]))
    element.set("quat", text_of(quaternion.from_matrix(T[:3, :3])))


def _add_inertial(element: ET.Element, inertia: Inertia | None, T: FloatArray) -> None:
    """Write an inertia that is known in base to a body at T in base."""
    if inertia is None:
        return
    local = body.moved(inertia, space.rigid_inverse(T))
    inertial = ET.SubElement(element, "inertial", pos=text_of(local.com), mass=text_of(local.mass))
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = local.tensor
    moments, axes = np.linalg.eigh(local.tensor)
    if moments[0] > 0.0:
        inertial.set("fullinertia", text_of((xx, yy, zz, xy, xz, yz)))
        return
    # what has no inertia about some axis MuJoCo takes by its principal axes only
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    inertial.set("quat", text_of(quaternion.from_matrix(axes)))
    inertial.set("diaginertia", text_of(np.maximum(moments, 0.0)))


def _is_thin(inertia: Inertia) -> bool:
    """Whether mass or inertia is none at all."""
    return inertia.mass <= 0.0 or bool(np.linalg.eigvalsh(inertia.tensor)[0] <= 0.0)


def _is_no_body(inertia: Inertia) -> bool:
    """Whether its moments are such as no body has: one is more than the two others."""
    moments = np.linalg.eigvalsh(inertia.tensor)
    return bool(moments[0] + moments[1] < moments[2])


def _add_joint(
    element: ET.Element, name: str, kind: JointKind, q_min: float, q_max: float
) -> ET.Element:
    joint = ET.SubElement(element, "joint", name=name, type=_TYPES[kind], pos="0 0 0", axis="0 0 1")
    if q_min > -inf or q_max < inf:
        largest = np.finfo(np.float64).max
        joint.set("range", text_of((max(q_min, -largest), min(q_max, largest))))
    else:
        joint.set("limited", "false")
    return joint


def _add_mimics(model: ET.Element, side_joints: Sequence[SideJoint]) -> None:
    mimics = [side for side in side_joints if side.mimics]
    if not mimics:
        return
    equality = ET.SubElement(model, "equality")
    for side in mimics:
        ET.SubElement(
            equality,
            "joint",
            joint1=side.name,
            joint2=side.mimics,
            polycoef=text_of((side.offset, side.multiplier, 0.0, 0.0, 0.0)),
        )


def _add_rates(model: ET.Element, limits: JointLimits) -> None:
    custom = ET.SubElement(model, "custom")
    for key in ("qd_max", "qdd_max", "qddd_max"):
        values = getattr(limits, key)
        if values is None:
            continue
        for name, value in zip(limits.names, values, strict=True):
            ET.SubElement(custom, "numeric", name=f"{key}/{name}", data=text_of(value))
