"""Frame graphs: poses known between some frames, in any direction, and from them the pose between any two.

The camera scene: a base {b} with an arm and gripper {c}, a ceiling camera {d} and an object {e} in a room {a}.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import real_array
from mafsil.errors import InputError
from mafsil.geometry import pose as functions
from mafsil.geometry.tolerances import LOOP_ANGLE, LOOP_DISTANCE
from mafsil.geometry.values import Pose
from mafsil.geometry.values.value import Frames

Link: TypeAlias = "Pose | Frames"
"""A known pose T_ab with its letters, or only the letters (a, b) of an unknown one."""


@dataclass(frozen=True)
class FrameGraph:
    """Known poses between named frames.

    Attributes:
        edges: poses with letters; each may be read in both directions.

    Raises:
        InputError: a pose has no letters or is a batch, or a pose contradicts those before it.
    """

    edges: tuple[Pose, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "edges", tuple(self.edges))
        known: dict[str, tuple[str, Pose]] = {}
        for T in self.edges:
            a, b = _letters(T)
            if T.batch:
                raise InputError("geometry.one_value", name=f"T_{a}{b}", batch=T.batch)
            for name in (a, b):
                known.setdefault(name, (name, Pose.identity((name, name))))
            (start, T_sa), (other, T_ob) = known[a], known[b]
            if start == other:
                self._require_consistent(T_sa.inverse() @ T_ob, T)
                continue
            T_so = T_sa @ T @ T_ob.inverse()
            for name, (root, T_on) in known.items():
                if root == other:
                    known[name] = (start, T_so @ T_on)

    def with_pose(self, T: Pose) -> FrameGraph:
        """The graph with one more known pose.

        Raises:
            InputError: the pose has no letters, is a batch, or contradicts what the graph says already.
        """
        return FrameGraph((*self.edges, T))

    @cached_property
    def frames(self) -> tuple[str, ...]:
        """Names of all frames, in the order of their first mention."""
        return tuple(dict.fromkeys(name for T in self.edges for name in _letters(T)))

    def pose(self, a: str, b: str) -> Pose:
        """T_ab along a shortest chain of known poses.

        Raises:
            InputError: a frame is unknown, or no chain connects the two.
        """
        for name in (a, b):
            if name not in self.frames:
                known = ", ".join(self.frames)
                raise InputError("geometry.frame_unknown", name="FrameGraph", frame=name, known=known)
        found = self._reach(a)
        if b not in found:
            raise InputError("geometry.frame_unreached", name="FrameGraph", start=a, end=b, parts=self._parts())
        return found[b]

    def loop_residual(self, loop: Sequence[str]) -> tuple[float, float]:
        """Angle [rad] and distance [m] by which a closed loop of neighbouring frames misses the identity.

        Args:
            loop: names, such as ("a", "b", "c"), closed by the way back to the first. Each step must be a known edge.
        """
        steps = zip(loop, (*loop[1:], loop[0]), strict=True)
        V = functions.log(reduce(lambda T, step: T @ self._edge(*step), steps, Pose.identity()).array)
        return float(np.linalg.norm(V[:3])), float(np.linalg.norm(V[3:]))

    def _edge(self, a: str, b: str) -> Pose:
        for T in self.edges:
            if _letters(T) == (a, b):
                return Pose(T.array)
            if _letters(T) == (b, a):
                return Pose(T.inverse().array)
        raise InputError("geometry.frame_unreached", name="FrameGraph", start=a, end=b, parts=self._parts())

    def _reach(self, start: str) -> dict[str, Pose]:
        """T_start,b of every frame b that a chain reaches.

        1. Begin with the frame itself.
        2. Take the frame that waits longest, so that every frame is reached by a shortest chain.
        3. Each edge that touches it, read forwards or backwards, may lead to a new frame, which then waits too.
        """
        # 1.
        found = {start: Pose.identity((start, start))}
        waiting = deque([start])
        while waiting:
            here = waiting.popleft()  # 2.
            for T in self.edges:  # 3.
                for step in (T, T.inverse()):
                    a, b = _letters(step)
                    if a == here and b not in found:
                        found[b] = found[here] @ step
                        waiting.append(b)
        return found

    def _parts(self) -> str:
        rest, parts = list(self.frames), list[str]()
        while rest:
            part = self._reach(rest[0])
            parts.append("{" + ", ".join(part) + "}")
            rest = [name for name in rest if name not in part]
        return " ".join(parts)

    def _require_consistent(self, known: Pose, T: Pose) -> None:
        a, b = _letters(T)
        V = functions.error(known.array, T.array)
        angle, distance = float(np.linalg.norm(V[:3])), float(np.linalg.norm(V[3:]))
        longest = max([1.0, *(float(np.linalg.norm(edge.origin)) for edge in self.edges)])
        if angle > LOOP_ANGLE or distance > LOOP_DISTANCE * longest:
            raise InputError(
                "geometry.frame_contradiction",
                name="FrameGraph",
                edge=f"T_{a}{b}",
                angle=angle,
                distance=distance,
                angle_limit=LOOP_ANGLE,
                distance_limit=LOOP_DISTANCE * longest,
            )


def solve_loop(left: Sequence[Link], right: Sequence[Link]) -> Pose:
    """The one unknown pose X of an equation of two chains, such as T_ab T_bc X = T_ad T_de.

    Args:
        left, right: the factors of both sides in order, poses with letters; of the unknown only its letters (c, e).

    Returns:
        X with its letters; it is not projected, both sides being exact poses.

    Raises:
        InputError: not exactly one factor is unknown, or letters do not cancel.
    """
    sides = [list(left), list(right)]
    unknown = [link for side in sides for link in side if not isinstance(link, Pose)]
    if len(unknown) != 1:
        raise InputError("geometry.loop_unknowns", name="solve_loop", count=len(unknown), edges=unknown)
    side, other = sides if any(not isinstance(link, Pose) for link in sides[0]) else sides[::-1]
    at = next(k for k, link in enumerate(side) if not isinstance(link, Pose))
    c, e = unknown[0]
    before = [Pose.identity((c, c)) if at == 0 else _product(side[:at]), _product(other)]
    X = before[1] if at == 0 else before[0].inverse() @ before[1]
    if at + 1 < len(side):
        X = X @ _product(side[at + 1 :]).inverse()
    return Pose.identity((c, c)) @ X @ Pose.identity((e, e))


def _product(links: Sequence[Link]) -> Pose:
    return reduce(lambda a, b: a @ b, [link for link in links if isinstance(link, Pose)])


def _letters(T: Pose) -> Frames:
    if T.frames is None:
        raise InputError("geometry.unlabelled", name="FrameGraph")
    return T.frames


@dataclass(frozen=True)
class CameraScene:
    """What is measured and known; the camera sees base and object, the joints tell the gripper.

    Attributes:
        T_ad: pose of the camera in the room, known from its mounting.
        T_db: pose of the base seen from the camera.
        T_de: pose of the object seen from the camera.
        T_bc: pose of the gripper in the base, from forward kinematics.
    """

    T_ad: Pose
    T_db: Pose
    T_de: Pose
    T_bc: Pose

    @classmethod
    def of(cls, T_ad: ArrayLike, T_db: ArrayLike, T_de: ArrayLike, T_bc: ArrayLike) -> CameraScene:
        """From four (4, 4) matrices."""
        given = ((T_ad, ("a", "d")), (T_db, ("d", "b")), (T_de, ("d", "e")), (T_bc, ("b", "c")))
        return cls(*(Pose(real_array("T_" + "".join(frames), T), frames) for T, frames in given))

    @property
    def T_ab(self) -> Pose:
        """Base in the room: T_ad T_db."""
        return self.T_ad @ self.T_db

    def grasp_pose(self) -> Pose:
        """T_ce, the object seen from the gripper: the motion that the gripper has to make to coincide with it.

        T_ab T_bc T_ce = T_ad T_de
        """
        return solve_loop([self.T_ab, self.T_bc, ("c", "e")], [self.T_ad, self.T_de])

    def graph(self) -> FrameGraph:
        """All four poses as a graph."""
        return FrameGraph((self.T_ad, self.T_db, self.T_de, self.T_bc))
