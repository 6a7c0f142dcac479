"""A tree of frames and joints, as robot description files write it, cut down to one arm."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from splinearm.arrays import FloatArray
from splinearm.joints import JointKind

from . import body, space
from .description import Description, JointNote, SideJoint, Source, limits_of
from .home import Home, arm_at, frame_on
from .link import Inertia


@dataclass(slots=True, kw_only=True)
class Node:
    """A frame: a link of a URDF, a body or a site of an MJCF; later also a joint between them."""

    name: str
    parent: "Node | None" = None
    T_parent_node: FloatArray = field(default_factory=lambda: np.eye(4))
    """Its pose in the parent where its joint is at zero."""
    note: JointNote | None = None
    """The joint that moves it; None: it is fixed to its parent."""
    joint: str = ""
    """Name of that joint."""
    refused: str = ""
    """Why its joint cannot be a joint of an arm."""
    axis: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    """Direction of the joint in this frame."""
    anchor: FloatArray = field(default_factory=lambda: np.zeros(3))
    """A point of the joint in this frame."""
    inertia: Inertia | None = None
    """What is fixed to it, in its frame."""
    mimics: tuple[str, float, float] | None = None
    """Joint, multiplier and offset, if its joint follows another."""

    def line(self) -> "list[Node]":
        """Give the nodes from the root to this one."""
        nodes: list[Node] = []
        node: Node | None = self
        while node is not None:
            nodes.append(node)
            node = node.parent
        return nodes[::-1]


def describe(
    source: Source, name: str, nodes: Sequence[Node], base: Node, tip: Node, *, world: bool
) -> Description:
    """Give the arm between two nodes of a tree.

    Args:
        source: The file, for errors.
        name: Name of the arm.
        nodes: All nodes, parents before their children.
        base: The node that is the base.
        tip: The node that is the tool.
        world: Whether what the base stands on is the world; else the base stands at its origin.

    Raises:
        ConfigError: If no arm of independent joints leads from base to tip.
    """
    line = tip.line()
    if base not in line:
        raise source.refuse(tip.name, f"does not hang on {base.name!r}")
    chain = [node for node in line[line.index(base) + 1 :] if node.note is not None or node.refused]
    _check_chain(source, chain, base, tip)
    poses = _poses(nodes)
    T_base = space.rigid_inverse(poses[id(base)])
    owner = _owners(nodes, chain, base)
    held: list[list[Inertia | None]] = [[] for _ in chain]
    for node in nodes:
        place = owner.get(id(node))
        if node.inertia is not None and place is not None:
            held[place].append(body.moved(node.inertia, T_base @ poses[id(node)]))
    home = Home(
        np.array([_joint_pose(node, T_base @ poses[id(node)]) for node in chain]),
        T_base @ poses[id(tip)],
        tuple(body.joined(bodies) for bodies in held),
    )
    arm = arm_at(
        name,
        home,
        limits_of(source, [node.note for node in chain if node.note is not None]),
        T_world_base=poses[id(base)] if world else None,
    )
    sides = _side_joints(nodes, chain, base, poses, T_base)
    return Description(arm=arm, base=base.name, tip=tip.name, side_joints=sides)


def choose_tip(source: Source, what: str, nodes: Sequence[Node], asked: str | None) -> Node:
    """Give the node of that name, or else the one that can only be meant.

    That is the only leaf of the tree that moves; or, where others are moved by joints of their own
    as fingers are, the only one that is fixed to what it hangs on, or else the hand of all of them.

    Raises:
        ConfigError: If there is none of that name, or several leaves and no name.
    """
    holding = {id(node.parent) for node in nodes}
    leaves = [node for node in nodes if id(node) not in holding]
    names = ", ".join(node.name for node in leaves)
    if asked is not None:
        for node in nodes:
            if node.name == asked:
                return node
        raise source.refuse(f"{what} {asked!r}", f"is not there; the tips are {names}")
    moving = [node for node in leaves if any(above.note is not None for above in node.line())]
    fixed = [node for node in moving if node.note is None and not node.refused]
    hands = {id(node.parent): node.parent for node in leaves if node.parent is not None}
    hand = [node for node in hands.values() if any(above.note for above in node.line())]
    for candidates in (leaves, moving, fixed, hand if len(hands) == 1 and not fixed else []):
        if len(candidates) == 1:
            return candidates[0]
    raise source.refuse("", f"has several tips; name the {what} that is the tool: {names}")


def _check_chain(source: Source, chain: Sequence[Node], base: Node, tip: Node) -> None:
    if not chain:
        raise source.refuse(tip.name, f"no moving joint leads to it from {base.name!r}")
    for node in chain:
        where = f"joint {node.joint!r}"
        if node.refused:
            raise source.refuse(where, node.refused)
        if node.mimics is not None:
            raise source.refuse(
                where,
                f"mimics joint {node.mimics[0]!r}; on the way to {tip.name!r} every joint must "
                "move by itself: choose another tip, or take the mimic out",
            )


def _poses(nodes: Sequence[Node]) -> dict[int, FloatArray]:
    """Give the pose of every node in the root where all joints are at zero."""
    poses: dict[int, FloatArray] = {}
    for node in nodes:
        above = np.eye(4) if node.parent is None else poses[id(node.parent)]
        poses[id(node)] = above @ node.T_parent_node
    return poses


def _owners(nodes: Sequence[Node], chain: Sequence[Node], base: Node) -> dict[int, int]:
    """Give for each node that an arm's link carries the number of that link."""
    first = {id(node): i for i, node in enumerate(chain)}
    owner: dict[int, int] = {}
    for node in nodes:
        if id(node) in first:
            owner[id(node)] = first[id(node)]
        elif node.parent is not None and node is not base and id(node.parent) in owner:
            owner[id(node)] = owner[id(node.parent)]
    return owner


def _joint_pose(node: Node, T_base_node: FloatArray) -> FloatArray:
    """Give a frame in base with its z axis on a node's joint: the node's own where it fits."""
    return T_base_node @ frame_on(node.axis, node.anchor)


def _side_joints(
    nodes: Sequence[Node],
    chain: Sequence[Node],
    base: Node,
    poses: dict[int, FloatArray],
    T_base: FloatArray,
) -> tuple[SideJoint, ...]:
    """Give the moving joints on the arm that are not its own."""
    own = {id(node) for node in chain}
    below = {id(base)}
    carrier: dict[int, str] = {id(base): ""}
    masses: dict[str, list[Inertia | None]] = {}
    found: list[Node] = []
    for node in nodes:
        if node.parent is None or id(node.parent) not in below:
            continue
        below.add(id(node))
        carrier[id(node)] = node.note.name if node.note is not None else carrier[id(node.parent)]
        if node.note is not None and id(node) not in own:
            found.append(node)
            masses[node.note.name] = []
        if node.inertia is not None and carrier[id(node)] in masses:
            moved = body.moved(node.inertia, T_base @ poses[id(node)])
            masses[carrier[id(node)]].append(moved)
    return tuple(
        _side_joint(node, carrier, _joint_pose(node, T_base @ poses[id(node)]), masses)
        for node in found
    )


def _side_joint(
    node: Node,
    carrier: dict[int, str],
    T_base_joint: FloatArray,
    masses: dict[str, list[Inertia | None]],
) -> SideJoint:
    if node.note is None or node.parent is None:
        raise ValueError(f"node {node.name!r}: want one that a joint moves")
    mimics, multiplier, offset = node.mimics or ("", 1.0, 0.0)
    return SideJoint(
        name=node.note.name,
        kind=JointKind(node.note.kind),
        parent=carrier[id(node.parent)],
        T_base_joint=T_base_joint,
        q_min=node.note.q_min,
        q_max=node.note.q_max,
        mimics=mimics,
        multiplier=multiplier,
        offset=offset,
        inertia=body.joined(masses[node.note.name]),
    )
