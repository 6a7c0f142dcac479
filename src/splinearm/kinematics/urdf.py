"""Arms from URDF and as URDF: the part of the format that kinematics and dynamics need.

Read are links with their inertias and joints: revolute, continuous, prismatic and fixed, with
origin, axis, limit and mimic. Fixed joints are folded in; meshes and all else are passed over. The
root link is the base; if it is called ``world`` and holds one fixed joint, its child is the base
and where that stands is kept. A limit's ``acceleration`` and ``jerk`` are read and written as
newer versions of the format have them; a file without them gets the defaults of ``description``.
"""

from collections.abc import Sequence
from math import inf
from os import PathLike
from xml.etree import ElementTree as ET

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind, JointLimits

from . import body, quaternion, space
from .arm import Arm
from .description import (
    ENDLESS,
    Description,
    JointNote,
    SideJoint,
    Source,
    free_name,
    take_off,
    text_of,
)
from .home import home_of
from .link import Inertia
from .tree import Node, choose_tip, describe

_KINDS = {
    "revolute": JointKind.REVOLUTE,
    "continuous": JointKind.REVOLUTE,
    "prismatic": JointKind.PRISMATIC,
}


def read_urdf(
    source: str | PathLike[str], tip: str | None = None, *, base: str | None = None
) -> Description:
    """Read the arm of a URDF file.

    Args:
        source: The file, or its text.
        tip: Name of the link that is the tool; None: the one that can only be meant (``tree``).
        base: Name of the link that is the base; None: the root.

    Raises:
        ConfigError: With file and element, if it cannot be read or holds no such arm.
    """
    text = Source.read(source, "robot")
    nodes = _nodes(text)
    by_name = {node.name: node for node in nodes}
    root = nodes[0]
    start, world = root, False
    stands = [node for node in nodes if node.parent is root]
    if root.name == "world" and len(stands) == 1 and _is_fixed(stands[0]):
        start, world = stands[0], True
    if base is not None:
        if base not in by_name:
            raise text.refuse(f"link {base!r}", f"is not there; links are {', '.join(by_name)}")
        start, world = by_name[base], world and by_name[base] is start
    end = choose_tip(text, "link", nodes, tip)
    return describe(text, text.root.get("name", "robot"), nodes, start, end, world=world)


def write_urdf(arm: Arm, side_joints: Sequence[SideJoint] = ()) -> str:
    """Give an arm as the text of a URDF; ``read_urdf`` with tip "tool" gives it back.

    Each link's frame is the one of the joint that moves it; the tool is a link of its own.

    Args:
        arm: The arm.
        side_joints: What else moves on it.
    """
    robot = ET.Element("robot", name=arm.name)
    home, taken = home_of(arm), {"world", "tool"}
    base = free_name("base_link", taken)
    ET.SubElement(robot, "link", name="world")
    _write_joint(robot, "world_to_base", "fixed", ("world", base), arm.T_world_base)
    ET.SubElement(robot, "link", name=base)
    above, T_above = base, np.eye(4)
    names = {"": (base, T_above)}
    inertias = dict(zip(arm.joint_names, home.inertias, strict=True))
    take_off(inertias, arm.joint_names, side_joints)
    for i, joint in enumerate(arm.joint_names):
        link = free_name(f"{joint}_link", taken)
        T = home.joints[i]
        _write_link(robot, link, inertias[joint], T)
        T_joint = space.rigid_inverse(T_above) @ T
        element = _write_joint(
            robot, joint, _type_of(arm.limits, i), (above, link), T_joint, axis=True
        )
        _write_limit(element, arm.limits, i)
        above, T_above = link, T
        names[joint] = (above, T_above)
    fixed = {"world_to_base", *arm.joint_names, *(side.name for side in side_joints)}
    ET.SubElement(robot, "link", name="tool")
    T_flange_tool = space.rigid_inverse(T_above) @ home.tool
    _write_joint(robot, free_name("to_tool", fixed), "fixed", (above, "tool"), T_flange_tool)
    for side in side_joints:
        names[side.name] = (free_name(f"{side.name}_link", taken), side.T_base_joint)
        _write_side(robot, side, names)
    ET.indent(robot)
    return '<?xml version="1.0"?>\n' + ET.tostring(robot, encoding="unicode") + "\n"


def _is_fixed(node: Node) -> bool:
    return node.note is None and not node.refused


def _nodes(text: Source) -> list[Node]:
    """Give the links, parents before their children."""
    links: dict[str, Node] = {}
    for element in text.root.findall("link"):
        name = element.get("name")
        if not name:
            raise text.refuse("link", "has no name")
        if name in links:
            raise text.refuse(f"link {name!r}", "is there twice")
        links[name] = Node(name=name, inertia=_read_inertia(text, element, f"link {name!r}"))
    seen: set[str] = set()
    for element in text.root.findall("joint"):
        _hang(text, element, links, seen)
    return _sorted(text, links)


def _sorted(text: Source, links: dict[str, Node]) -> list[Node]:
    roots = [node for node in links.values() if node.parent is None]
    if len(roots) != 1:
        names = ", ".join(node.name for node in roots)
        raise text.refuse("link", f"want one link that hangs on no other, got {names or 'none'}")
    children: dict[int, list[Node]] = {}
    for node in links.values():
        children.setdefault(id(node.parent), []).append(node)
    ordered, rest = [], roots
    while rest:
        node = rest.pop()
        ordered.append(node)
        rest.extend(reversed(children.get(id(node), [])))
    if len(ordered) < len(links):
        lost = sorted(set(links) - {node.name for node in ordered})
        raise text.refuse(f"link {lost[0]!r}", "hangs on itself: its joints form a ring")
    return ordered


def _hang(text: Source, element: ET.Element, links: dict[str, Node], seen: set[str]) -> None:
    """Hang the child of a joint on its parent."""
    name, kind = element.get("name"), element.get("type")
    where = f"joint {name!r}"
    if not name:
        raise text.refuse("joint", "has no name")
    if name in seen:
        raise text.refuse(where, "is there twice")
    seen.add(name)
    ends = []
    for key in ("parent", "child"):
        part = element.find(key)
        link = None if part is None else part.get("link")
        if link not in links:
            raise text.refuse(where, f"{key}: want the name of a link, got {link!r}")
        ends.append(links[link])
    parent, child = ends
    if child.parent is not None:
        raise text.refuse(where, f"child: link {child.name!r} already hangs on another joint")
    child.joint, child.parent = name, parent
    child.T_parent_node = _read_origin(text, element, where)
    if kind == "fixed":
        return
    if kind not in _KINDS:
        known = ", ".join([*_KINDS, "fixed"])
        child.refused = f"type: want one of {known}, got {kind!r}"
        return
    child.axis = _read_axis(text, element, where)
    child.note = _read_note(text, element, name, kind)
    mimic = element.find("mimic")
    if mimic is not None:
        if not mimic.get("joint"):
            raise text.refuse(f"{where} mimic", "joint is missing")
        child.mimics = (
            mimic.get("joint", ""),
            text.number(mimic.attrib, "multiplier", f"{where} mimic", 1.0),
            text.number(mimic.attrib, "offset", f"{where} mimic", 0.0),
        )


def _read_note(text: Source, element: ET.Element, name: str, kind: str) -> JointNote:
    where = f"joint {name!r} limit"
    limit = element.find("limit")
    if limit is None:
        if kind != "continuous":
            raise text.refuse(where, f"is missing; a {kind} joint must have one")
        return JointNote(name=name, kind=JointKind.REVOLUTE)
    of = limit.attrib
    low, high = -inf, inf
    if kind != "continuous":
        low, high = text.number(of, "lower", where, 0.0), text.number(of, "upper", where, 0.0)
        low, high = -inf if low <= -ENDLESS else low, inf if high >= ENDLESS else high
    return JointNote(
        name=name,
        kind=_KINDS[kind],
        q_min=low,
        q_max=high,
        qd_max=text.positive(of, "velocity", where),
        qdd_max=text.positive(of, "acceleration", where),
        qddd_max=text.positive(of, "jerk", where),
        torque_max=text.positive(of, "effort", where),
    )


def _read_axis(text: Source, element: ET.Element, where: str) -> FloatArray:
    part = element.find("axis")
    if part is None:
        return np.array([1.0, 0.0, 0.0])
    axis = text.numbers(part.attrib, "xyz", (3,), f"{where} axis")
    length = float(np.linalg.norm(axis))
    if not length > 0.0:
        raise text.refuse(f"{where} axis", "xyz: want a direction, got 0 0 0")
    # a direction of length 1 stays digit for digit what it is
    unit: FloatArray = axis if abs(length - 1.0) < 1e-15 else axis / length
    return unit


def _read_origin(text: Source, element: ET.Element, where: str) -> FloatArray:
    part = element.find("origin")
    T = np.eye(4)
    if part is None:
        return T
    where = f"{where} origin"
    if "xyz" in part.attrib:
        T[:3, 3] = text.numbers(part.attrib, "xyz", (3,), where)
    if "quat_xyzw" in part.attrib:
        xyzw = text.numbers(part.attrib, "quat_xyzw", (4,), where)
        if not np.linalg.norm(xyzw) > 0.0:
            raise text.refuse(where, "quat_xyzw: want a rotation, got 0 0 0 0")
        T[:3, :3] = quaternion.to_matrix(quaternion.normalize(quaternion.from_xyzw(xyzw)))
    elif "rpy" in part.attrib:
        rpy = text.numbers(part.attrib, "rpy", (3,), where)
        T[:3, :3] = quaternion.to_matrix(quaternion.from_euler(rpy, "xyz"))
    return T


def _read_inertia(text: Source, element: ET.Element, where: str) -> Inertia | None:
    part = element.find("inertial")
    if part is None:
        return None
    where = f"{where} inertial"
    mass, tensor = part.find("mass"), part.find("inertia")
    if mass is None or tensor is None:
        raise text.refuse(where, "mass and inertia: want both, got one")
    xx, yy, zz = (text.number(tensor.attrib, key, where, 0.0) for key in ("ixx", "iyy", "izz"))
    xy, xz, yz = (text.number(tensor.attrib, key, where, 0.0) for key in ("ixy", "ixz", "iyz"))
    try:
        found = Inertia(
            text.number(mass.attrib, "value", where),
            np.zeros(3),
            np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]),
        )
    except ValueError as error:
        raise text.refuse(where, str(error)) from error
    return body.moved(found, _read_origin(text, part, where))


def _write_origin(element: ET.Element, T: FloatArray) -> None:
    rpy = quaternion.to_euler(quaternion.from_matrix(T[:3, :3]), "xyz")
    ET.SubElement(element, "origin", xyz=text_of(T[:3, 3]), rpy=text_of(rpy))


def _write_joint(
    robot: ET.Element,
    name: str,
    kind: str,
    ends: tuple[str, str],
    T: FloatArray,
    *,
    axis: bool = False,
) -> ET.Element:
    joint = ET.SubElement(robot, "joint", name=name, type=kind)
    _write_origin(joint, T)
    ET.SubElement(joint, "parent", link=ends[0])
    ET.SubElement(joint, "child", link=ends[1])
    if axis:
        ET.SubElement(joint, "axis", xyz="0 0 1")
    return joint


def _write_link(robot: ET.Element, name: str, inertia: Inertia | None, T: FloatArray) -> None:
    """Write a link at T in base with an inertia that is known in base."""
    link = ET.SubElement(robot, "link", name=name)
    if inertia is None:
        return
    local = body.moved(inertia, space.rigid_inverse(T))
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "origin", xyz=text_of(local.com), rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=text_of(local.mass))
    moments = {f"i{'xyz'[i]}{'xyz'[j]}": local.tensor[i, j] for i in range(3) for j in range(i, 3)}
    ET.SubElement(inertial, "inertia", {key: text_of(value) for key, value in moments.items()})


def _type_of(limits: JointLimits, i: int) -> str:
    endless = limits.q_min[i] == -inf and limits.q_max[i] == inf
    if limits.kinds[i] is JointKind.REVOLUTE and endless:
        return "continuous"
    return limits.kinds[i].value


def _write_limit(joint: ET.Element, limits: JointLimits, i: int) -> None:
    # effort must be there in the format; zero stands for not known
    effort = 0.0 if limits.torque_max is None else limits.torque_max[i]
    said = {"effort": effort, "velocity": limits.qd_max[i], "acceleration": limits.qdd_max[i]}
    if limits.qddd_max is not None:
        said["jerk"] = limits.qddd_max[i]
    if joint.get("type") != "continuous":
        said["lower"] = max(limits.q_min[i], -ENDLESS)
        said["upper"] = min(limits.q_max[i], ENDLESS)
    ET.SubElement(joint, "limit", {key: text_of(value) for key, value in said.items()})


def _write_side(
    robot: ET.Element, side: SideJoint, names: dict[str, tuple[str, FloatArray]]
) -> None:
    above, T_above = names[side.parent]
    link, T = names[side.name]
    _write_link(robot, link, side.inertia, T)
    endless = side.kind is JointKind.REVOLUTE and side.q_min == -inf and side.q_max == inf
    kind = "continuous" if endless else side.kind.value
    T_joint = space.rigid_inverse(T_above) @ T
    joint = _write_joint(robot, side.name, kind, (above, link), T_joint, axis=True)
    if not endless:
        low, high = max(side.q_min, -ENDLESS), min(side.q_max, ENDLESS)
        ET.SubElement(
            joint, "limit", lower=text_of(low), upper=text_of(high), effort="0", velocity="0"
        )
    if side.mimics:
        ET.SubElement(
            joint,
            "mimic",
            joint=side.mimics,
            multiplier=text_of(side.multiplier),
            offset=text_of(side.offset),
        )
