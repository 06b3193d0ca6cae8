"""Frames of a model: links, joints, frames and nested models, each given relative to another one."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mafsil.arrays import PoseMatrix, frozen
from mafsil.model.faults import SDF_CIRCLE, SDF_FRAME
from mafsil.model.placement import inverse
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element

WORLD = "world"


@dataclass(frozen=True, slots=True)
class Given:
    """A pose as the file gives it: relative to a frame of that full name."""

    relative_to: str
    T: PoseMatrix
    element: Element


@dataclass(slots=True)
class Frames:
    """Poses of all frames of a model by their full names.

    Attributes:
        given: as they stand in the file.
        T_ws: (4, 4) pose of the outermost model's frame in the world.
        of_joints: names under which the frames of joints stand that are called like something else, as up to 1.6.
    """

    given: dict[str, Given] = field(default_factory=dict[str, Given])
    T_ws: PoseMatrix = field(default_factory=lambda: frozen(np.eye(4)))
    of_joints: dict[str, str] = field(default_factory=dict[str, str])
    _known: dict[str, PoseMatrix] = field(default_factory=dict[str, PoseMatrix])

    def pose(self, reading: Reading, name: str, element: Element) -> PoseMatrix:
        """The pose (4, 4) of a frame in the outermost model's frame; an unknown one or a circle is reported.

        Args:
            reading: of the file.
            name: full name of the frame; `world` is the space in which the model stands.
            element: what asks for it.
        """
        if name == WORLD and WORLD not in self.given:
            return inverse(self.T_ws)
        chain: list[str] = []
        at = name
        while at not in self._known and at in self.given:
            if at in chain:
                reading.report(SDF_CIRCLE, element, None, None, name=name)
                return frozen(np.eye(4))
            chain.append(at)
            at = self.given[at].relative_to
        if at and at != WORLD and at not in self._known:
            reading.report(SDF_FRAME, element, None, None, name=at)
            return frozen(np.eye(4))
        T = inverse(self.T_ws) if at == WORLD else self._known.get(at, np.eye(4))
        for step in reversed(chain):
            T = T @ self.given[step].T
            self._known[step] = frozen(T)
        return self._known[name]

    def placement_frame(self, reading: Reading, name: str, element: Element) -> PoseMatrix:
        """The pose (4, 4) of the frame by which a model is placed, in the model, whose own place is not known yet."""
        T = self.pose(reading, name, element)
        self._known.clear()
        return T

    def joint(self, name: str) -> str:
        """The name of a joint's frame."""
        return self.of_joints.get(name, name)

    def between(self, reading: Reading, a: str, b: str, element: Element) -> PoseMatrix:
        """The pose (4, 4) of frame b in frame a."""
        return inverse(self.pose(reading, a, element)) @ self.pose(reading, b, element)
