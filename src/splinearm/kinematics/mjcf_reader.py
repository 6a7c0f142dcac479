"""Arms from MJCF, the XML of MuJoCo, without MuJoCo: the part that kinematics and dynamics need.

Read are the compiler's ``angle``, ``autolimits`` and ``eulerseq``; bodies, frames and sites with
``pos`` and any of ``quat``, ``axisangle``, ``xyaxes``, ``zaxis``, ``euler``; hinge and slide
joints with ``pos``, ``axis``, ``range``, ``limited``, ``ref`` and ``actuatorfrcrange``; inertials;
defaults and their classes; joint equalities as mimics; and the numbers that ``mjcf`` writes.
Geoms, their masses too, actuators and all else are passed over; ``include`` and ``replicate`` are
refused: let MuJoCo save the whole model as one file first.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from os import PathLike
from xml.etree import ElementTree as ET

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind
from splinearm.units import DEG

from . import body, quaternion, space
from .description import ENDLESS, Description, JointNote, Source
from .home import frame_on
from .link import Inertia
from .tree import Node, choose_tip, describe

_KINDS = {"hinge": JointKind.REVOLUTE, "slide": JointKind.PRISMATIC}
_TURNED_BY = ("quat", "axisangle", "xyaxes", "zaxis", "euler")
_REFUSED = ("include", "replicate", "composite", "attach", "flexcomp")


def read_mjcf(
    source: str | PathLike[str], tip: str | None = None, *, base: str | None = None
) -> Description:
    """Read the arm of an MJCF file.

    Args:
        source: The file, or its text.
        tip: Name of the site or body that is the tool; None: the only site, or else the body that
            can only be meant (``tree``).
        base: Name of the body that is the base; None: the first body, or the world if that one
            has a joint.

    Raises:
        ConfigError: With file and element, if it cannot be read or holds no such arm.
    """
    text = Source.read(source, "mujoco")
    model = _Model(text)
    nodes = model.nodes
    end = _tip(text, model, tip)
    line = end.line()
    moved = len(line) < 2 or line[1].note is not None or bool(line[1].refused)
    start, world = (line[0], True) if moved else (line[1], True)
    if base is not None:
        found = [node for node in nodes if node.name == base]
        if not found:
            raise text.refuse(f"body {base!r}", "is not there")
        start = found[0]
        world = all(node.note is None for node in start.line())
    return describe(text, text.root.get("model", "arm"), nodes, start, end, world=world)


def _tip(text: Source, model: "_Model", tip: str | None) -> Node:
    if tip is None and len(model.sites) == 1:
        return model.sites[0]
    bodies = [node for node in model.nodes if node not in model.sites]
    if tip is None:
        return choose_tip(text, "site or body", bodies, tip)
    return choose_tip(text, "site or body", [*model.sites, *bodies], tip)


@dataclass(slots=True)
class _Model:
    """The tree of a file while it is read."""

    text: Source
    nodes: list[Node] = field(default_factory=list)
    sites: list[Node] = field(default_factory=list)
    compiler: dict[str, str] = field(default_factory=dict)
    classes: dict[str, dict[str, dict[str, str]]] = field(default_factory=dict)
    rates: dict[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        root = self.text.root
        for tag in _REFUSED:
            if root.find(f".//{tag}") is not None:
                reason = "is not read; let MuJoCo save the whole model as one file first"
                raise self.text.refuse(f"<{tag}>", reason)
        for compiler in root.findall("compiler"):
            self.compiler.update(compiler.attrib)
        if self.compiler.get("coordinate", "local") != "local":
            raise self.text.refuse("compiler", "coordinate: want local, the only one since 2.3")
        self.classes["main"] = {}
        for default in root.findall("default"):
            self._read_defaults(default, {}, default.get("class", "main"))
        for number in root.findall("custom/numeric"):
            name = number.get("name", "")
            if "/" in name:
                self.rates[name] = self.text.number(number.attrib, "data", f"numeric {name!r}")
        self.nodes.append(Node(name="world"))
        for world in root.findall("worldbody"):
            self._read_children(world, self.nodes[0], np.eye(4), "main")
        self._read_mimics()

    def _read_defaults(
        self, element: ET.Element, above: Mapping[str, dict[str, str]], name: str
    ) -> None:
        here = {tag: dict(values) for tag, values in above.items()}
        for part in element:
            if part.tag != "default":
                here.setdefault(part.tag, {}).update(part.attrib)
        self.classes[name] = here
        for part in element.findall("default"):
            self._read_defaults(part, here, part.get("class", ""))

    def _attributes(self, element: ET.Element, class_name: str) -> dict[str, str]:
        name = element.get("class", class_name)
        if name not in self.classes:
            where = f"{element.tag} {element.get('name', '')!r}"
            raise self.text.refuse(where, f"class: there is no default class {name!r}")
        return {**self.classes[name].get(element.tag, {}), **element.attrib}

    def _read_children(
        self, element: ET.Element, node: Node, T: FloatArray, class_name: str
    ) -> None:
        """Read what stands in a body, or in a frame at T in it."""
        for part in element:
            where = f"{part.tag} {part.get('name', '')!r}"
            inner = part.get("childclass", class_name)
            if part.tag == "body":
                self._read_body(part, node, T @ self._pose(part.attrib, where), inner)
            elif part.tag == "frame":
                self._read_children(part, node, T @ self._pose(part.attrib, where), inner)
            elif part.tag == "site":
                pose = T @ self._pose(self._attributes(part, class_name), where)
                name = part.get("name", f"site of {node.name}")
                site = Node(name=name, parent=node, T_parent_node=pose)
                self.nodes.append(site)
                self.sites.append(site)

    def _read_body(self, element: ET.Element, parent: Node, T: FloatArray, class_name: str) -> None:
        name = element.get("name", f"body {len(self.nodes)}")
        joints = [part for part in element if part.tag in ("joint", "freejoint")]
        node = Node(name=name, parent=parent, T_parent_node=T)
        self.nodes.append(node)
        for i, joint in enumerate(joints):
            if i > 0:
                # several joints move one body one after the other, as bodies without mass would
                node = Node(name=name, parent=node)
                self.nodes.append(node)
            self._read_joint(joint, node, class_name)
        inertial = element.find("inertial")
        if inertial is not None:
            node.inertia = self._inertia(inertial, f"body {name!r} inertial")
        self._read_children(element, node, np.eye(4), class_name)

    def _read_joint(self, element: ET.Element, node: Node, class_name: str) -> None:
        of = self._attributes(element, class_name)
        name = of.get("name", f"{node.name} joint")
        where, kind = f"joint {name!r}", of.get("type", "hinge")
        node.joint = name
        if element.tag == "freejoint" or kind not in _KINDS:
            got = "freejoint" if element.tag == "freejoint" else f"type {kind!r}"
            node.refused = f"want a hinge or a slide, got {got}"
            return
        axis = self.text.numbers({"axis": "0 0 1", **of}, "axis", (3,), where)
        length = float(np.linalg.norm(axis))
        if not length > 0.0:
            raise self.text.refuse(where, "axis: want a direction, got 0 0 0")
        node.axis = axis if abs(length - 1.0) < 1e-15 else axis / length
        node.anchor = self.text.numbers({"pos": "0 0 0", **of}, "pos", (3,), where)
        low, high = self._range(of, kind, where)
        node.note = JointNote(
            name=name,
            kind=_KINDS[kind],
            q_min=low,
            q_max=high,
            qd_max=self.rates.get(f"qd_max/{name}"),
            qdd_max=self.rates.get(f"qdd_max/{name}"),
            qddd_max=self.rates.get(f"qddd_max/{name}"),
            torque_max=self._torque(of, where),
        )
        self._turn_back(node, of, kind, where)

    def _turn_back(self, node: Node, of: Mapping[str, str], kind: str, where: str) -> None:
        """Put the body where it is at zero: as written it is where the joint is at ``ref``."""
        ref = self.text.number(of, "ref", where, 0.0) * (self._angle if kind == "hinge" else 1.0)
        if ref == 0.0:
            return
        if kind == "hinge":
            back = space.rotation(node.axis, -ref, node.anchor)
        else:
            back = space.translation(-ref * node.axis)
        node.T_parent_node = node.T_parent_node @ back

    def _range(self, of: Mapping[str, str], kind: str, where: str) -> tuple[float, float]:
        limited = of.get("limited", "auto")
        if limited == "auto":
            automatic = self.compiler.get("autolimits", "true") == "true"
            if not automatic and "range" in of:
                reason = "range: with autolimits off it must say whether it is limited"
                raise self.text.refuse(where, reason)
            limited = "true" if "range" in of else "false"
        if limited == "false":
            return -inf, inf
        low, high = self.text.numbers(of, "range", (2,), where) * (
            self._angle if kind == "hinge" else 1.0
        )
        return (-inf if low <= -ENDLESS else float(low)), (inf if high >= ENDLESS else float(high))

    def _torque(self, of: Mapping[str, str], where: str) -> float | None:
        if "actuatorfrcrange" not in of:
            return None
        low, high = self.text.numbers(of, "actuatorfrcrange", (2,), where)
        torque = float(min(-low, high))
        return torque if 0.0 < torque < ENDLESS else None

    @property
    def _angle(self) -> float:
        return 1.0 if self.compiler.get("angle", "degree") == "radian" else DEG

    def _pose(self, of: Mapping[str, str], where: str) -> FloatArray:
        T = np.eye(4)
        T[:3, 3] = self.text.numbers({"pos": "0 0 0", **of}, "pos", (3,), where)
        said = [key for key in _TURNED_BY if key in of]
        if len(said) > 1:
            raise self.text.refuse(where, f"says its orientation twice: {' and '.join(said)}")
        if said:
            T[:3, :3] = self._rotation(said[0], of, where)
        return T

    def _rotation(self, key: str, of: Mapping[str, str], where: str) -> FloatArray:
        sizes = {"quat": 4, "axisangle": 4, "xyaxes": 6, "zaxis": 3, "euler": 3}
        values = self.text.numbers(of, key, (sizes[key],), where)
        if key == "euler":
            # their lower case letters turn about moving axes, ours about fixed ones
            sequence = self.compiler.get("eulerseq", "xyz").swapcase()
            return _from_euler(self.text, values * self._angle, sequence)
        if not np.linalg.norm(values[:3] if key != "quat" else values) > 0.0:
            raise self.text.refuse(where, f"{key}: want a direction, got zeros")
        if key == "quat":
            return quaternion.to_matrix(quaternion.normalize(values))
        if key == "axisangle":
            quat = quaternion.from_axis_angle(values[:3], values[3] * self._angle)
            return quaternion.to_matrix(quat)
        if key == "zaxis":
            return _shortest_to(values / np.linalg.norm(values))
        x = values[:3] / np.linalg.norm(values[:3])
        y = values[3:] - (values[3:] @ x) * x
        if not np.linalg.norm(y) > 0.0:
            raise self.text.refuse(where, "xyaxes: want two directions, got one")
        y = y / np.linalg.norm(y)
        return np.column_stack((x, y, np.cross(x, y)))

    def _inertia(self, element: ET.Element, where: str) -> Inertia:
        of = element.attrib
        T = self._pose(of, where)
        if "fullinertia" in of:
            xx, yy, zz, xy, xz, yz = self.text.numbers(of, "fullinertia", (6,), where)
        else:
            diagonal = {"diaginertia": "0 0 0", **of}
            xx, yy, zz = self.text.numbers(diagonal, "diaginertia", (3,), where)
            xy = xz = yz = 0.0
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        try:
            found = Inertia(self.text.number(of, "mass", where), np.zeros(3), tensor)
        except ValueError as error:
            raise self.text.refuse(where, str(error)) from error
        return body.moved(found, T)

    def _read_mimics(self) -> None:
        by_name = {node.note.name: node for node in self.nodes if node.note is not None}
        for element in self.text.root.findall("equality/joint"):
            name, other = element.get("joint1", ""), element.get("joint2")
            if name not in by_name or other is None or element.get("active") == "false":
                continue
            where = f"equality of joint {name!r}"
            given = {"polycoef": "0 1 0 0 0", **element.attrib}
            terms = self.text.numbers(given, "polycoef", range(1, 6), where)
            terms = np.concatenate((terms, (0.0, 1.0, 0.0, 0.0, 0.0)[terms.size :]))
            if terms[2:].any():
                raise self.text.refuse(where, "polycoef: want an offset and a factor, got a curve")
            by_name[name].mimics = (other, float(terms[1]), float(terms[0]))


def _from_euler(text: Source, angles: FloatArray, sequence: str) -> FloatArray:
    try:
        return quaternion.to_matrix(quaternion.from_euler(angles, sequence))
    except ValueError as error:
        raise text.refuse("compiler", f"eulerseq: {error}") from error


def _shortest_to(axis: FloatArray) -> FloatArray:
    """Give the shortest turn that brings z to an axis."""
    across = np.array([-axis[1], axis[0], 0.0])
    sine = float(np.linalg.norm(across))
    if sine == 0.0:
        return frame_on(axis, np.zeros(3))[:3, :3]
    quat = quaternion.from_axis_angle(across, np.arctan2(sine, axis[2]))
    return quaternion.to_matrix(quat)
