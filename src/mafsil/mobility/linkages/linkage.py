"""Linkages: bodies and joints of any number of freedoms, as drawn in one configuration that closes all loops.

All bodies carry the frame of the drawing, so that every body stands at the identity where it is drawn, and a joint is
a product of exponentials: T_child = T_parent exp([S1] theta_1) ... exp([Sf] theta_f).

Functions of a linkage: what is none is refused in our words, with what makes one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, wraps
from typing import ParamSpec, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, frozen, require_kind
from mafsil.errors import InputError, ModelError
from mafsil.floating_point import EPS
from mafsil.messages import say
from mafsil.mobility.linkages.linkage_joint import Coupling, Kind, LinkageJoint
from mafsil.mobility.tolerances import TYPED

ROUNDINGS = 64 * EPS
"""Share of their coordinates within which points are one: the mean of equal points is off by rounding."""


@dataclass(frozen=True, eq=False)
class PointPair:
    """Points of two bodies that keep their distance: a rod between balls, or one ball if that is zero; see `balls`.

    Attributes:
        bodies: names.
        points: (2, 3) on each, where it is drawn [m].
        length: their distance [m].
        joints: names of the balls that it stands for.
    """

    bodies: tuple[str, str]
    points: Floats
    length: float
    joints: tuple[str, ...]

    @property
    def rows(self) -> int:
        """Number of conditions."""
        return 1 if self.length > 0 else 3


@dataclass(frozen=True, eq=False, repr=False)
class Linkage:
    """Bodies joined by joints: chains, trees, closed loops, with the ground as one of the bodies.

    Build it with `Linkage.of`, which checks it.

    Attributes:
        name: for reports.
        bodies: names; the first is the ground.
        joints: in order of their coordinates theta (F,), F the sum of their freedoms.
        output: name of the body whose motion matters: the platform, the gripper.
        planar: all bodies move in one plane, and are counted in it.
        apart: displacements (4, 4) X by the name of the joint, T_child = T_parent exp([S] theta) X: from where the
            child is drawn to where it meets the joint. Empty when everything is drawn together.
        couplings: between joints of one freedom.
        pairs: points that keep their distance, of balls without angles: only of surfaces of configurations, as are
            joints with `corners`.
    """

    name: str
    bodies: tuple[str, ...]
    joints: tuple[LinkageJoint, ...]
    output: str
    planar: bool = False
    apart: Mapping[str, Floats] = field(default_factory=dict[str, Floats])
    couplings: tuple[Coupling, ...] = ()
    pairs: tuple[PointPair, ...] = ()

    @classmethod
    def of(
        cls,
        joints: Iterable[LinkageJoint],
        *,
        name: str = "",
        ground: str = "ground",
        output: str | None = None,
        planar: bool = False,
        bodies: Sequence[str] | None = None,
        couplings: Iterable[Coupling] = (),
    ) -> Linkage:
        """A linkage of joints, checked.

        Args:
            joints: where they are drawn; all loops are closed there.
            name: for reports.
            ground: the body that does not move.
            output: the body whose motion matters; the last new one if None.
            planar: refuse joints that leave the plane normal to z, and count in the plane.
            bodies: all names, so that misspelt ones are found; None takes those of the joints.
            couplings: gears and other fixed ratios between joints of one freedom.

        Raises:
            ModelError: no joints, doubled or unknown names, bodies that nothing joins to the ground, a joint that
                leaves the plane of a planar linkage. The sentence names the joint.
        """
        require_kind("joints", joints, "list of joints", "__iter__")
        given = tuple(joints)
        for each in cast("tuple[object, ...]", given):
            require_kind("joints", each, "LinkageJoint, as `joint(...)` makes one", "child_point", "freedoms")
        if not given:
            raise ModelError("mobility.no_joints", name=name or "-")
        _require_once([each.name for each in given])
        named = _bodies_of(given, bodies)
        if ground not in named:
            raise ModelError("mobility.no_ground", ground=ground, known=", ".join(named))
        order = (ground, *(body for body in named if body != ground))
        chosen = order[-1] if output is None else output
        if chosen not in named:
            raise ModelError("mobility.no_output", output=chosen, known=", ".join(named))
        if planar:
            for each in given:
                _require_in_plane(each)
        apart = {each.name: _shift(each) for each in given if each.child_point is not None}
        found = cls(name, order, given, chosen, planar, apart, tuple(couplings))
        for each in found.couplings:
            found.require_coupling(each)
        if loose := [body for body, reached in zip(order, found.reached, strict=True) if not reached]:
            raise ModelError("mobility.loose", bodies=", ".join(loose), ground=ground)
        return found

    def __repr__(self) -> str:
        return say(
            "mobility.linkage", name=self.name or "-", bodies=len(self.bodies), joints=len(self.joints),
            loops=self.loops, output=self.output,
        )  # fmt: skip

    def require_coupling(self, each: Coupling) -> None:
        """Refuse a coupling of joints that are not there, have several freedoms, of ratio zero, a cam that is no hinge.

        Raises:
            ModelError: the sentence names both joints.
        """
        pair = [self.joints[k] for k in self.index_of([each.follower, each.leader])]
        sliding = bool(each.table) and pair[1].kind is not Kind.REVOLUTE
        if pair[0] is pair[1] or any(one.freedoms != 1 for one in pair) or sliding or not (each.ratio or each.table):
            raise ModelError("mobility.coupling", follower=each.follower, leader=each.leader, ratio=each.ratio)

    @property
    def ground(self) -> str:
        """Name of the body that does not move."""
        return self.bodies[0]

    @cached_property
    def coordinates(self) -> int:
        """F, number of joint coordinates."""
        return sum(each.freedoms for each in self.joints)

    @property
    def loops(self) -> int:
        """Number of independent loops J - N + 1."""
        return len(self.joints) - len(self.bodies) + 1

    @property
    def conditions(self) -> int:
        """6 L + K + P: of the loops, the couplings, the points that keep their distances."""
        sides = 3 * len(self.by_points)
        return 6 * self.loops + len(self.couplings) + sum(pair.rows for pair in self.pairs) + sides

    def require_all_joints(self) -> None:
        """Refuse a linkage whose balls have become pairs of points: it has fewer bodies and joints than are counted.

        Raises:
            ModelError: the sentence names these balls.
        """
        if self.pairs or self.by_points:
            free = [self.joints[k].name for k, _, _ in self.by_points]
            names = dict.fromkeys([*(name for pair in self.pairs for name in pair.joints), *free])
            raise ModelError("mobility.balls_left_out", joints=", ".join(names))

    @cached_property
    def ends(self) -> NDArray[np.intp]:
        """(J, 2) indices of parent and child of each joint."""
        index = {body: k for k, body in enumerate(self.bodies)}
        return np.array([[index[each.parent], index[each.child]] for each in self.joints], dtype=np.intp)

    @cached_property
    def joint_of(self) -> NDArray[np.intp]:
        """(F,) index of the joint of each coordinate."""
        return np.repeat(np.arange(len(self.joints)), [each.freedoms for each in self.joints])

    @cached_property
    def by_points(self) -> tuple[tuple[int, Floats, slice], ...]:
        """Joints whose coordinates are places of three points: index, corners (3, 3) [m], columns."""
        first = np.cumsum([0, *(each.freedoms for each in self.joints)]).tolist()
        return tuple(
            (k, each.corners, slice(first[k], first[k + 1]))
            for k, each in enumerate(self.joints)
            if each.corners is not None
        )

    @cached_property
    def screws(self) -> Floats:
        """(6, F) screws of all coordinates in the frame of the drawing."""
        return frozen(np.hstack([each.screws for each in self.joints]))

    @cached_property
    def coordinate_names(self) -> tuple[str, ...]:
        """Names of the coordinates: of the joint, with a number if it has several freedoms."""
        return tuple(
            each.name if each.freedoms == 1 else f"{each.name}.{k + 1}"
            for each in self.joints
            for k in range(each.freedoms)
        )

    @cached_property
    def tree(self) -> tuple[tuple[int, bool], ...]:
        """(joint, forward) in the order in which a breadth first walk from the ground reaches the bodies."""
        found: list[tuple[int, bool]] = []
        reached, waiting = {0}, [0]
        while waiting:
            body = waiting.pop(0)
            for k, (a, b) in enumerate(self.ends.tolist()):
                for start, end, forward in ((a, b, True), (b, a, False)):
                    if start == body and end not in reached:
                        reached.add(end)
                        waiting.append(end)
                        found.append((k, forward))
        return tuple(found)

    @property
    def reached(self) -> tuple[bool, ...]:
        """For each body, whether joints connect it with the ground."""
        far = {0} | {int(self.ends[k, 1 if forward else 0]) for k, forward in self.tree}
        return tuple(k in far for k in range(len(self.bodies)))

    @property
    def closing(self) -> tuple[int, ...]:
        """Indices of the joints that close the loops."""
        inside = {k for k, _ in self.tree}
        return tuple(k for k in range(len(self.joints)) if k not in inside)

    @cached_property
    def paths(self) -> Floats:
        """(N, J) +1 or -1 where the walk from the ground to a body passes a joint forwards or backwards."""
        found = np.zeros((len(self.bodies), len(self.joints)))
        for k, forward in self.tree:
            start, end = self.ends[k] if forward else self.ends[k][::-1]
            found[end] = found[start]
            found[end, k] = 1.0 if forward else -1.0
        return found

    @cached_property
    def cycles(self) -> Floats:
        """(L, J) the independent loops: +1 or -1 where a loop passes a joint forwards or backwards."""
        closing = list(self.closing)
        found = self.paths[self.ends[closing, 0]] - self.paths[self.ends[closing, 1]] if closing else self.paths[:0]
        found = found.copy()
        found[np.arange(len(closing)), closing] = 1.0
        return found

    @cached_property
    def middle(self) -> Floats:
        """(3,) middle of the points of the joints that have a place [m]."""
        points = self._places
        return points.mean(axis=0) if len(points) else np.zeros(3)

    @cached_property
    def size(self) -> float:
        """Largest distance of a joint from the middle [m]; 1 if all lie in one point."""
        points = self._places
        spread = float(np.linalg.norm(points - self.middle, axis=1).max()) if len(points) else 0.0
        return spread if spread > ROUNDINGS * float(np.abs(points).max(initial=0.0)) else 1.0

    @property
    def _places(self) -> Floats:
        places = [each.point[None] for each in self.joints if each.kind is not Kind.PRISMATIC and each.corners is None]
        corners = [each.corners for each in self.joints if each.corners is not None]
        return np.concatenate([np.zeros((0, 3)), *places, *corners])

    def index_of(self, names: Iterable[str]) -> tuple[int, ...]:
        """Indices of joints by name; one name alone counts as a list of one.

        Raises:
            ModelError: there is no such joint; the sentence lists them.
            InputError: no list of names.
        """
        known = {each.name: k for k, each in enumerate(self.joints)}
        found: list[int] = []
        require_kind("joints", names, "list of names", "__iter__")
        for name in (names,) if isinstance(names, str) else names:
            if not isinstance(cast("object", name), str) or name not in known:
                raise ModelError("mobility.unknown_joint", joint=name, known=", ".join(known))
            found.append(known[name])
        return tuple(found)

    def columns_of(self, names: Iterable[str]) -> NDArray[np.intp]:
        """Indices of all coordinates of joints by name."""
        return np.flatnonzero(np.isin(self.joint_of, self.index_of(names)))

    def with_output(self, body: str) -> Linkage:
        """The same linkage with another body whose motion matters."""
        if body not in self.bodies:
            raise ModelError("mobility.no_output", output=body, known=", ".join(self.bodies))
        return replace(self, output=body)

    def with_actuators(self, *names: str) -> Linkage:
        """The same linkage, driven at these joints and no others."""
        driven = set(self.index_of(names))
        return replace(self, joints=tuple(replace(each, actuated=k in driven) for k, each in enumerate(self.joints)))


def _shift(each: LinkageJoint) -> Floats:
    """(4, 4) translation from the place on the child to the joint."""
    X = np.eye(4)
    X[:3, 3] = each.point - (each.point if each.child_point is None else each.child_point)
    return frozen(X)


def _bodies_of(joints: tuple[LinkageJoint, ...], known: Sequence[str] | None) -> dict[str, None]:
    """Names of the bodies, as keys in their order.

    Raises:
        ModelError: a joint on a body that is not among the known ones.
    """
    ends = [(each.name, end) for each in joints for end in (each.parent, each.child)]
    if known is None:
        return dict.fromkeys(end for _, end in ends)
    for joint, end in ends:
        if end not in known:
            raise ModelError("mobility.unknown_body", joint=joint, body=end, known=", ".join(map(str, known)))
    return dict.fromkeys(map(str, known))


def _require_once(names: list[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise ModelError("mobility.doubled", joint=name)
        seen.add(name)


def _require_in_plane(each: LinkageJoint) -> None:
    if not each.kind.planar:
        raise ModelError("mobility.not_planar_kind", joint=each.name, kind=each.kind.title)
    rotates = each.kind is not Kind.PRISMATIC and each.kind is not Kind.FIXED
    along = [each.second] if each.kind is Kind.PIN_IN_SLOT else [] if rotates else [each.axis]
    if each.kind is Kind.FIXED:
        return
    if rotates and float(np.abs(each.axis[:2]).max()) > TYPED:
        raise ModelError("mobility.axis_in_plane", joint=each.name, axis=each.axis.tolist())
    if any(abs(float(w[2])) > TYPED for w in along):
        raise ModelError("mobility.leaves_plane", joint=each.name, axis=along[0].tolist())


P = ParamSpec("P")
Result = TypeVar("Result")


def on_linkage(function: Callable[P, Result]) -> Callable[P, Result]:
    """The function, which refuses anything but a Linkage as its first argument.

    Args:
        function: whose first argument is called `linkage`.
    """

    @wraps(function)
    def call(*args: P.args, **named: P.kwargs) -> Result:
        given: object = args[0] if args else cast("dict[str, object]", named).get("linkage")
        if not isinstance(given, Linkage):
            raise InputError("mobility.needs_linkage", got=type(given).__name__)
        return function(*args, **named)

    return call
