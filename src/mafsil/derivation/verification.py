"""The numerical judge of derivations: the compiled robot at random states."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.derivation.arm import SymbolicArm
from mafsil.derivation.document import Factors, Line, Product, Side, is_matrix
from mafsil.derivation.factored import evaluate as evaluate_factored
from mafsil.derivation.factored import factor_out
from mafsil.derivation.matrices import Entries
from mafsil.derivation.polynomial import Polynomial
from mafsil.derivation.tolerances import LIMIT
from mafsil.errors import MafsilError
from mafsil.model import JointKind
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.placement import rotation_x, translation
from mafsil.robot import Robot

STATES = 20


class DerivationError(MafsilError, RuntimeError):
    """A line of a derivation does not agree with the compiled robot: an error of the derivation, never printed."""


class Judge:
    """Values of the compiled robot at random states, and the check of a line against them.

    Attributes:
        arm: the arm in letters.
        robot, q: the compiled robot and its states (states, n).
        values: numbers of its letters at the states.
        frames: (n + 1, states, 4, 4) poses in {s} of the frames {0} .. {n} of the modified table.
        shown_frames: the same of the table that is shown, which may be classic.
        tip: (states, 4, 4) pose of the tip.
        J_s: (states, 6, n) space Jacobian, columns of the chain's joints.
    """

    def __init__(self, arm: SymbolicArm, seed: int = 5) -> None:
        self.arm = arm
        robot = self.robot = Robot(arm.mechanism)
        q = self.q = _states(arm, np.random.default_rng(seed))
        self.values: dict[str, float | Floats] = arm.values(q)
        self.tip = np.asarray(robot.forward_kinematics(q))
        self.J_s = np.asarray(robot.jacobian_space(q))[:, :, list(arm.coordinates)]
        self.frames = _frames(arm, robot, q)
        self.shown_frames = _shown(arm, self.frames)

    def line(self, left: Product, *sides: Side, truth: Floats, limit: float = LIMIT) -> Line:
        """A line whose formulas have been compared with the truth.

        Args:
            left: what is computed.
            sides: what it equals; formulas and matrices among them are checked as they will be printed.
            truth: (states, rows, columns) or (states,) numbers of the compiled robot.
            limit: relative error allowed.

        Raises:
            DerivationError: a formula differs.
        """
        scale = max(1.0, float(np.abs(truth).max(initial=0.0)))
        error = 0.0
        for side in sides:
            shown = self._shown(side)
            if shown is not None:
                error = max(error, float(np.abs(shown - truth).max()))
        if error > limit * scale:
            name = " ".join(each.letter + each.index for each in left)
            raise DerivationError("derivation.differs", line=name, error=error, limit=limit * scale)
        return Line(left, sides, error)

    def _shown(self, side: Side) -> Floats | None:
        """Numbers of a side that has any."""
        if isinstance(side, Polynomial):
            return self.number(side)
        if isinstance(side, Factors):
            return np.prod([self.number(formula) for formula in side.formulas], axis=0)
        return self.matrix(side) if is_matrix(side) else None

    def number(self, formula: Polynomial) -> Floats:
        """(states,) values of a formula in the form in which it is printed."""
        return np.broadcast_to(evaluate_factored(factor_out(formula), self.values), (STATES,))

    def matrix(self, entries: Entries) -> Floats:
        """(states, rows, columns) values of a matrix."""
        flat = [self.number(x) for row in entries for x in row]
        return np.stack(flat, axis=-1).reshape(STATES, len(entries), len(entries[0]))


def _shown(arm: SymbolicArm, frames: Floats) -> Floats:
    """The frames at the far ends of the links, if the table is classic."""
    if arm.classic is None:
        return frames
    far = [translation(row.a, 0.0, 0.0) @ rotation_x(row.alpha) for row in arm.classic.table.rows]
    return np.concatenate([frames[:1], frames[1:] @ np.array(far)[:, None]])


def _states(arm: SymbolicArm, rng: np.random.Generator) -> Floats:
    """(states, n of the robot): any angle, slides up to twice the arm's size; joints beside the chain at zero."""
    q = np.zeros((STATES, arm.mechanism.n))
    for place, row in zip(arm.coordinates, arm.table.rows, strict=True):
        q[:, place] = rng.uniform(-np.pi, np.pi, STATES) if row.kind == "R" else rng.uniform(-1.0, 1.0, STATES)
    return q


def _frames(arm: SymbolicArm, robot: Robot, q: Floats) -> Floats:
    """Frames of the table, fixed to the robot's own links: T_s,link(q) T_link,i with T_link,i taken at q = 0."""
    links = [joint.child for joint in chain_to_tip(arm.mechanism) if joint.kind is not JointKind.FIXED]
    home = np.asarray(robot.link_poses(np.zeros(arm.mechanism.n)))
    moved = np.asarray(robot.link_poses(q))
    T_s = np.array(arm.table.base)
    frames = [np.broadcast_to(T_s, (STATES, 4, 4))]
    for row, link in zip(arm.table.rows, links, strict=True):
        T_s = T_s @ row.transform(arm.table.convention)
        place = arm.mechanism.link_names.index(link)
        frames.append(np.asarray(moved[:, place] @ np.linalg.inv(home[place]) @ T_s, dtype=np.float64))
    return np.stack(frames)
