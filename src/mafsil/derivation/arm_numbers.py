"""An arm in numbers, its lengths free: poses and Jacobians at states that may each have lengths of their own."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

from mafsil.arrays import Floats
from mafsil.derivation.arm import SymbolicArm
from mafsil.derivation.matrices import evaluate
from mafsil.model import Mechanism
from mafsil.robot import Robot

Letters: TypeAlias = dict[str, Any]


class CompiledArm:
    """The robot as it is.

    Args:
        mechanism: the robot.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.robot = Robot(mechanism)

    def space(self, q: Floats) -> tuple[Floats, Floats, list[Floats]]:
        """J_s (states, 6, n), tip poses (states, 4, 4) and origins (states, 3) of links and tip at q (states, n)."""
        poses, tip = np.asarray(self.robot.link_poses(q)), np.asarray(self.robot.forward_kinematics(q))
        points = [*np.moveaxis(poses[:, :, :3, 3], 1, 0), tip[:, :3, 3]]
        return np.array(self.robot.jacobian_space(q)), tip, points


class LetteredArm:
    """The robot with other lengths: every state has its own.

    Args:
        arm: in letters.
        letters: (states,) or single numbers of all letters.
    """

    def __init__(self, arm: SymbolicArm, letters: Letters) -> None:
        self.arm, self.letters = arm, letters

    def space(self, q: Floats) -> tuple[Floats, Floats, list[Floats]]:
        """As `CompiledArm.space`; the origins are those of the table's frames."""
        values, count = {**self.arm.values(q), **self.letters}, len(q)
        T = evaluate(self.arm.base.entries, values, count)
        J, points = np.zeros((count, 6, self.arm.mechanism.n)), [T[:, :3, 3]]
        for row, place in zip(self.arm.rows, self.arm.coordinates, strict=True):
            T = T @ evaluate(row.transform().entries, values, count)
            z, p = T[:, :3, 2], T[:, :3, 3]
            points.append(p)
            turns = row.row.kind == "R"
            J[:, :3, place], J[:, 3:, place] = (z, np.cross(p, z)) if turns else (0.0, z)
        tip = T @ evaluate(self.arm.tool.entries, values, count)
        return J, tip, [*points, tip[:, :3, 3]]


class Truth:
    """Jacobians at states q (states, n), their rows chosen to match a given matrix.

    Args:
        arm: where they come from.
        q: (states, n) states.
        rows: 6, or 3 or 2 of the tip's velocity.
    """

    def __init__(self, arm: CompiledArm | LetteredArm, q: Floats, rows: int) -> None:
        self.arm, self.q, self.rows = arm, q, rows

    def jacobian(self, kind: str, q: Floats | None = None) -> Floats:
        """(states, rows, n): `space`, `body`, `tip` (velocity of the tip point in {s}, angular rows first if six)."""
        J, tip, _ = self.arm.space(self.q if q is None else q)
        J = J.copy()
        if kind != "space":
            J[:, 3:] += np.cross(J[:, :3], tip[:, :3, 3, None], axisa=1, axisb=1, axisc=1)
        if kind == "body":
            R = tip[:, :3, :3].transpose(0, 2, 1)
            J = np.concatenate([R @ J[:, :3], R @ J[:, 3:]], axis=1)
        return J if self.rows == 6 else J[:, 3 : 3 + self.rows]

    def points(self) -> list[Floats]:
        """Positions (states, 3) of the origins of all links and of the tip."""
        return self.arm.space(self.q)[2]
