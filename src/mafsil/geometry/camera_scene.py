"""The camera scene: a base {b} with an arm and gripper {c}, a ceiling camera {d} and an object {e} in a room {a}."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from mafsil.arrays import real_array
from mafsil.geometry.frames import FrameGraph, solve_loop
from mafsil.geometry.values import Pose


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
