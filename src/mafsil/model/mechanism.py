"""A robot as immutable data: links, the tree of joints, the loops that close it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import count
from typing import TYPE_CHECKING, Protocol, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import PoseMatrix, Vector3, frozen
from mafsil.errors import ModelError
from mafsil.fields import check_fields, vector
from mafsil.lazy_module import lazily
from mafsil.model.joint import Joint, JointKind
from mafsil.model.limits import JointLimits
from mafsil.model.link import Link
from mafsil.model.placement import frozen_pose
from mafsil.model.spanning_tree import sorted_tree
from mafsil.model.tip import TipChoice, choose_tip, is_named_as_tip
from mafsil.model.tooling import payload, tool_pose, with_body

if TYPE_CHECKING:
    import mafsil.model.tooling as locking
else:
    locking = lazily("mafsil.model.tooling")

STANDARD_GRAVITY = (0.0, 0.0, -9.81)


class Remark(Protocol):
    """One thing that a reader has to say about a file, in either language; the readers' Diagnostic is one."""

    @property
    def code(self) -> str:
        """Stable code, such as `J0405`."""
        ...

    def sentence(self, language: str | None = None) -> str:
        """What it is and what to do."""
        ...

    def line_of_text(self, language: str | None = None) -> str:
        """Place, code and sentence on one line."""
        ...


@dataclass(frozen=True, slots=True)
class Provenance:
    """Where a description comes from.

    Attributes:
        source: file, publication or table.
        licence: of the source, if it has one.
        notes: what was guessed, known errors, conventions converted at the border.
        remarks: every warning of the file's reader: what was guessed, normalised, ignored or dropped; the notes say
            the first of them in English.
        choice: of the tip, where the description left it open and others could be meant.
        postures: that it names, each with the values of joints by name [rad | m].
    """

    source: str = ""
    licence: str = ""
    notes: tuple[str, ...] = ()
    remarks: tuple[Remark, ...] = field(default=(), repr=False, compare=False)
    choice: TipChoice | None = field(default=None, repr=False, compare=False)
    postures: tuple[tuple[str, Mapping[str, float]], ...] = field(default=(), repr=False, compare=False)


@dataclass(frozen=True, eq=False)
class Mechanism:
    """Links and joints of an open or closed chain.

    Build it with `Mechanism.assemble`, which checks the parts and sorts them: `links[0]` is the base link, and
    `joints[k].child` is `links[k + 1].name`, every parent before its children (depth first, in order of declaration).

    Attributes:
        name: of the robot.
        links: (k + 1) links, the base first.
        joints: (k) joints of the spanning tree.
        loops: joints that close loops, of any number of freedoms: both links are already in the tree, and the child's
            frame stands in the joint. Empty for an open chain.
        tip: name of the link that carries the tip frame.
        T_lt: (4, 4) pose of the tip frame {t} in the tip link.
        T_sb: (4, 4) pose of the base link in the space frame {s}.
        gravity: (3,) acceleration of gravity in {s} [m/s^2].
        provenance: where the numbers come from.
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    loops: tuple[Joint, ...] = ()
    tip: str = ""
    T_lt: PoseMatrix = field(default_factory=lambda: frozen(np.eye(4)))
    T_sb: PoseMatrix = field(default_factory=lambda: frozen(np.eye(4)))
    gravity: Vector3 = field(default_factory=lambda: frozen(STANDARD_GRAVITY))
    provenance: Provenance = Provenance()
    __post_init__ = check_fields(T_lt=frozen_pose, T_sb=frozen_pose, gravity=vector(3))

    @classmethod
    def assemble(
        cls,
        name: str,
        links: Iterable[Link],
        joints: Iterable[Joint],
        *,
        loops: Iterable[Joint] = (),
        tip: str | None = None,
        T_lt: PoseMatrix | None = None,
        T_sb: PoseMatrix | None = None,
        gravity: Vector3 | tuple[float, float, float] = STANDARD_GRAVITY,
        provenance: Provenance = Provenance(),
        marks: Collection[str] = (),
    ) -> Mechanism:
        """Check the parts, sort them into a tree, choose the tip.

        Args:
            name: of the robot.
            links, joints: in any order.
            loops: joints that close loops.
            tip: name of the tip link; by default a frame of convention such as `tool0` on the arm's last link, else the
                last link before the hand forks (`mafsil.model.tip`); what else could be meant is noted.
            T_lt, T_sb, gravity: see the class; identity and (0, 0, -9.81) by default.
            provenance: where the numbers come from.
            marks: links that are frames somebody named: one at the end of a chain is the tip only by a name of
                convention.

        Raises:
            ModelError: a name is used twice or missing, the joints do not form one tree, one of them has several
                freedoms, a loop joins a link to itself, a mimic joint follows nothing or itself.
        """
        given_links, given_joints, closing = tuple(links), tuple(joints), tuple(loops)
        _require_unique("link", [link.name for link in given_links])
        _require_unique("joint", [joint.name for joint in (*given_joints, *closing)])
        for joint in given_joints:
            if joint.kind.freedoms > 1:
                raise ModelError("model.many_screws", joint=joint.name, kind=joint.kind.value)
        by_name = {link.name: link for link in given_links}
        for joint in (*given_joints, *closing):
            for end in (joint.parent, joint.child):
                if end not in by_name:
                    raise ModelError("model.unknown_link", joint=joint.name, link=end)
        for joint in closing:
            if joint.parent == joint.child:
                raise ModelError("model.loop_on_itself", joint=joint.name, link=joint.parent)
        base, ordered = sorted_tree(name, list(by_name), given_joints)
        _require_mimic_leaders(ordered)
        telling = _without_marks(_without_loop_ends(ordered, closing, by_name), marks)
        choice = None if tip is not None else choose_tip(base, telling)
        chosen = tip if choice is None else choice.tip
        if choice is not None and choice.others:
            provenance = replace(provenance, notes=(*provenance.notes, choice.sentence("en")), choice=choice)
        if chosen is None or chosen not in by_name:
            raise ModelError("model.unknown_tip", link=chosen, known=", ".join(by_name))
        return cls(
            name=name,
            links=(by_name[base], *(by_name[joint.child] for joint in ordered)),
            joints=ordered,
            loops=closing,
            tip=chosen,
            T_lt=np.eye(4) if T_lt is None else T_lt,
            T_sb=np.eye(4) if T_sb is None else T_sb,
            gravity=cast("Vector3", gravity),
            provenance=provenance,
        )

    def with_tip(self, tip: str, T_lt: ArrayLike | None = None) -> Mechanism:
        """The same mechanism with another tip frame: that of a link, or a pose T_lt (4, 4) in it."""
        if tip not in self.link_names:
            raise ModelError("model.unknown_tip", link=tip, known=", ".join(self.link_names))
        return replace(self, tip=tip, T_lt=np.eye(4) if T_lt is None else cast("PoseMatrix", T_lt))

    def with_frame(self, name: str, pose: ArrayLike | None = None, link: str | None = None) -> Mechanism:
        """The same mechanism with a named frame: a link without mass and shape, fixed where it is given.

        Args:
            name: of the new frame, which every `frame=` and `tip=` takes from then on.
            pose: (4, 4) of the frame in that of the link, or its origin (3,) [m] alone; the link's own frame if None.
            link: that carries it; the present tip frame if None, and `pose` is in that.

        Raises:
            InputError: wrong shapes, NaN or infinities.
            ModelError: an unknown link, a name that a link has already, a matrix that is no pose.
        """
        carrier, T_lm = (self.tip, self.T_lt) if link is None else (self.link(link).name, np.eye(4))
        taken = {joint.name for joint in (*self.joints, *self.loops)}
        holder = next(free for k in count() if (free := f"{name}_joint{'_' * k}") not in taken)
        joint = Joint(holder, JointKind.FIXED, carrier, name, frozen(T_lm @ tool_pose("pose", pose)))
        grown = Mechanism.assemble(
            self.name, (*self.links, Link(name)), (*self.joints, joint), loops=self.loops, tip=self.tip
        )
        return replace(self, links=grown.links, joints=grown.joints)

    def with_tool(
        self,
        tool: ArrayLike | None = None,
        *,
        mass: float = 0.0,
        com: ArrayLike = (0.0, 0.0, 0.0),
        inertia: ArrayLike | None = None,
        link: str | None = None,
    ) -> Mechanism:
        """The same mechanism with a tool mounted: a new tip frame, and the tool's mass on the link that carries it.

        Args:
            tool: pose (4, 4) of the new tip frame in the frame on which the tool is mounted, or its origin (3,) [m]
                alone; the mounting frame itself if None.
            mass: of the tool [kg].
            com: (3,) centre of mass [m] in the mounting frame.
            inertia: (3, 3) about the centre of mass, axes as the mounting frame [kg m^2]; zero (a point mass) if None.
            link: the tool is mounted on this link, in its frame; on the present tip frame if None.

        Raises:
            InputError: wrong shapes, NaN or infinities.
            ModelError: an unknown link, a matrix that is no pose, mass properties that no body has.
        """
        loaded = self.with_payload(mass, com=com, inertia=inertia, link=link)
        T_lm = self.T_lt if link is None else np.eye(4)
        return loaded.with_tip(self.tip if link is None else link, T_lm @ tool_pose("tool", tool))

    def with_payload(
        self,
        mass: float,
        *,
        com: ArrayLike = (0.0, 0.0, 0.0),
        inertia: ArrayLike | None = None,
        link: str | None = None,
    ) -> Mechanism:
        """The same mechanism with a body fixed to it; the tip frame stays.

        Args:
            mass: of the body [kg].
            com: (3,) centre of mass [m] in the tip frame, or in the frame of `link`.
            inertia: (3, 3) about the centre of mass, axes as that frame [kg m^2]; zero (a point mass) if None.
            link: that carries the body, in whose frame the numbers are; the tip frame if None.

        Raises:
            InputError: wrong shapes, NaN or infinities, a negative mass.
            ModelError: an unknown link, mass properties that no body has.
        """
        carrier = self.link(self.tip if link is None else link)
        body = payload(mass, com, inertia, self.T_lt if link is None else None)
        if not body.mass:
            return self
        loaded = with_body(carrier, body)
        return replace(self, links=tuple(loaded if item is carrier else item for item in self.links))

    def without_loops(self) -> Mechanism:
        """The open tree: the same links and joints, and none that closes a loop."""
        return replace(self, loops=())

    def with_locked_joints(self, coordinates: Mapping[str, float]) -> Mechanism:
        """The same mechanism with joints locked at coordinates.

        Joints coupled as mimics are locked together: a leader locks its followers, and a follower gives its leader's
        value.

        Args:
            coordinates: coordinate [rad | m] by name of the joint.

        Raises:
            InputError: `coordinates` is no mapping of names to finite numbers.
            ModelError: no such joint, or values that contradict each other within a mimic pair.
        """
        return replace(self, joints=locking.lock_joints(self.joints, coordinates))

    def with_gravity(self, gravity: Vector3) -> Mechanism:
        """The same mechanism under another gravity [m/s^2], in {s}."""
        return replace(self, gravity=gravity)

    @property
    def n(self) -> int:
        """Number of joint coordinates: moving joints of the tree that follow no other."""
        return len(self.coordinates)

    @cached_property
    def coordinates(self) -> tuple[Joint, ...]:
        """The joints that own a coordinate, in the order of q."""
        return tuple(joint for joint in self.joints if joint.moves and joint.mimic is None)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints that own a coordinate, in the order of q."""
        return tuple(joint.name for joint in self.coordinates)

    @property
    def endless(self) -> tuple[str, ...]:
        """Names of the driven joints whose range has no end that the description knows."""
        free = ~(np.isfinite(self.limits.lower) & np.isfinite(self.limits.upper))
        return tuple(each.name for each, yes in zip(self.coordinates, free, strict=True) if yes and each.actuated)

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of the links, the base first."""
        return tuple(link.name for link in self.links)

    @cached_property
    def angular(self) -> NDArray[np.bool_]:
        """(n,) which coordinates are angles: those of all joints but the prismatic ones."""
        kinds = np.array([joint.kind is not JointKind.PRISMATIC for joint in self.coordinates], dtype=np.bool_)
        kinds.setflags(write=False)
        return kinds

    @cached_property
    def frame_names(self) -> tuple[str, ...]:
        """Names of the links that are frames alone, without mass and shape: fixed to a link, carrying nothing else."""
        solid = {link.name for link in self.links if not link.is_bare}
        solid |= {end for loop in self.loops for end in (loop.parent, loop.child)}
        for joint in reversed(self.joints):
            if joint.moves or joint.child in solid:
                solid |= {joint.parent, joint.child}
        return tuple(joint.child for joint in self.joints if joint.child not in solid)

    @cached_property
    def parents(self) -> tuple[int, ...]:
        """Index into `links` of the parent of each joint: `links[parents[k]]` carries `joints[k]`."""
        index = {link.name: i for i, link in enumerate(self.links)}
        return tuple(index[joint.parent] for joint in self.joints)

    @cached_property
    def limits(self) -> JointLimits:
        """Bounds of the coordinates, arrays of shape (n,)."""
        each = [joint.limits for joint in self.coordinates]
        fields = ("lower", "upper", "velocity", "acceleration", "jerk", "effort")
        return JointLimits(*(frozen([getattr(limits, name) for limits in each]) for name in fields))

    @property
    def actuated(self) -> tuple[bool, ...]:
        """For each coordinate, whether a motor drives it."""
        return tuple(joint.actuated for joint in self.coordinates)

    def link(self, name: str) -> Link:
        """The link of that name.

        Raises:
            ModelError: there is none; the sentence lists the links.
        """
        for link in self.links:
            if link.name == name:
                return link
        raise ModelError("model.no_such_link", link=name, known=", ".join(self.link_names))


def _require_unique(what: str, names: list[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise ModelError(f"model.duplicate_{what}", name=name)
        seen.add(name)


def _without_loop_ends(
    joints: tuple[Joint, ...], loops: tuple[Joint, ...], links: dict[str, Link]
) -> tuple[Joint, ...]:
    """The joints but for those of bare frames, without mass and shape, in which a loop ends: no tip of an arm."""
    carrying = {joint.parent for joint in joints}
    ends = {end for loop in loops for end in (loop.parent, loop.child)} - carrying
    return tuple(joint for joint in joints if joint.moves or joint.child not in ends or not links[joint.child].is_bare)


def _without_marks(joints: tuple[Joint, ...], marks: Collection[str]) -> tuple[Joint, ...]:
    """The joints but for those to named frames that carry nothing else and bear no name of convention."""
    kept: list[Joint] = []
    carrying: set[str] = set()
    for joint in reversed(joints):
        if joint.child not in marks or joint.child in carrying or is_named_as_tip(joint.child):
            kept.append(joint)
            carrying.add(joint.parent)
    return tuple(reversed(kept))


def _require_mimic_leaders(joints: tuple[Joint, ...]) -> None:
    """A mimic joint follows a joint that owns its coordinate."""
    by_name = {joint.name: joint for joint in joints}
    for joint in joints:
        if joint.mimic is None:
            continue
        leader = by_name.get(joint.mimic.leader)
        if leader is None or not leader.moves or leader.mimic is not None or not joint.moves:
            raise ModelError("model.mimic_leader", joint=joint.name, leader=joint.mimic.leader)
