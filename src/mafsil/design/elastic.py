"""Deflection and natural frequencies of an arm: links as beams of their sections, joints as springs, the rest rigid.

Each tube is a row of Euler-Bernoulli beams with torsion and stretch; a joint frees its end about or along the axis
against the gear's stiffness. Small motions about a configuration at rest, motors held: K x = f and K x = w^2 M x.
Loads spread over a beam enter by its own shape functions, so that deflections at its ends are exact; gravity's own
stiffness (buckling) is left out.

Reference: Przemieniecki, Theory of Matrix Structural Analysis, 1968, ch. 5 and 11.
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch, not_negative, single, whole
from mafsil.design.arm import SHORTEST, ArmDesign
from mafsil.design.parts import Tube
from mafsil.mechanics.inertial_parameters import inertial_of, moved_parameters, parameters_of
from mafsil.mechanics.rigid_body import RigidBody
from mafsil.mechanics.textbook import Textbook
from mafsil.model import Inertial, JointKind
from mafsil.model.placement import frame_along

BEAMS = 3
"""Beams of one tube: of a cantilever the lowest frequency is within 0.02 %, the second within 0.4 %."""


class FlexibleArm:
    """A design with a payload as springs and beams.

    Args:
        design: the arm; its chain of links is open and none branches.
        payload: mass at the tip [kg].
        centre: (3,) of the payload's mass, in the tip frame [m].
        beams: of each tube.

    Raises:
        InputError: a number out of its range.
    """

    def __init__(
        self, design: ArmDesign, *, payload: float = 0.0, centre: ArrayLike = (0.0, 0.0, 0.0), beams: int = BEAMS
    ) -> None:
        self.design, self.beams = design, whole("beams", beams, least=1, most=50)
        mechanism = design.robot.mechanism
        # In NumPy: a kernel of each design's own would take longer than all its beams.
        self._chain = Textbook(mechanism)
        mass = not_negative("payload", payload)
        at_tip = Inertial(mass, single("centre", centre, (3,)), np.zeros((3, 3)))
        self._tip = RigidBody(at_tip).spatial_inertia
        ends = [*(joint.T_pj for joint in mechanism.joints[1:]), mechanism.T_lt]
        self._tubes = [
            tube if tube is not None and np.linalg.norm(end[:3, 3]) > SHORTEST else None
            for tube, end in zip(design.tubes, ends, strict=True)
        ]
        self._ends = [np.asarray(end[:3, 3]) for end in ends]
        # The drive of the next joint sits at the far end of a link, whose tube it bends.
        carried = [
            drive.parameters(joint.T_pj[:3, :3], np.zeros(3), np.asarray(joint.axis))
            if drive is not None
            else np.zeros(10)
            for joint, drive in zip(mechanism.joints[1:], design.drives[1:], strict=True)
        ] + [np.zeros(10)]
        self._carried = [_spatial_inertia(parameters) for parameters in carried]
        self._rigid = [
            _rest(link.inertial, tube, end, moved_parameters(heavy, np.eye(3), end))
            for link, tube, end, heavy in zip(mechanism.links[1:], self._tubes, self._ends, carried, strict=True)
        ]
        self._springs = [k for k, stiffness in enumerate(design.stiffness) if stiffness < inf]
        self.freedoms = len(self._springs) + 6 * self.beams * sum(tube is not None for tube in self._tubes)

    def matrices(self, q: JointVector) -> tuple[Floats, Floats, Floats, Floats]:
        """Stiffness K (N, N), mass M (N, N), load of gravity (N,), and how the tip moves (6, N) in {s}, at q (n,)."""
        mechanism, N = self.design.robot.mechanism, self.freedoms
        poses = self._chain.poses(np.asarray(q)[None])[0]
        K, M, load, B = np.zeros((N, N)), np.zeros((N, N)), np.zeros(N), np.zeros((6, N))
        free, g = len(self._springs), np.asarray(mechanism.gravity)
        for k, joint in enumerate(mechanism.joints):
            T = poses[k + 1]
            if k in self._springs:
                own = self._springs.index(k)
                K[own, own] += self.design.stiffness[k]
                rotation = np.zeros(3) if joint.kind is JointKind.PRISMATIC else T[:3, :3] @ joint.axis
                advance = 1.0 if joint.kind is JointKind.PRISMATIC else joint.pitch
                B = B.copy()
                B[:, own] += np.concatenate([rotation, advance * (T[:3, :3] @ joint.axis)])
            _add_body(M, load, B, _turn(self._rigid[k], T[:3, :3]), g)
            tube, end = self._tubes[k], T[:3, :3] @ self._ends[k]
            step = end / self.beams
            stiff, heavy = (np.zeros(()),) * 2 if tube is None else beam_matrices(tube, step)
            if tube is None:
                B = _carry(end) @ B
            for _ in range(self.beams if tube is not None else 0):
                after = np.zeros((6, N))
                after[:, free : free + 6] = np.eye(6)
                free += 6
                both = np.concatenate([B, after])
                K += both.T @ stiff @ both
                M += both.T @ heavy @ both
                load += both.T @ heavy @ np.tile([*np.zeros(3), *g], 2)
                B = after
            _add_body(M, load, B, _turn(self._carried[k], T[:3, :3]), g)
        tip = poses[len(mechanism.joints)][:3, :3] @ mechanism.T_lt[:3, :3]
        _add_body(M, load, B, _turn(self._tip, tip), g)
        return K, M, load, B

    def deflection(self, q: ArrayLike, wrench: ArrayLike = (0.0,) * 6) -> Floats:
        """(*batch, 6) how the tip turns and moves under weight, payload and a wrench, in {s} [rad, m].

        Args:
            q: (*batch, n) configurations [rad | m].
            wrench: (6,) moment and force that act on the tip, in the axes of {s} at its origin [N m, N].
        """
        F = single("wrench", wrench, (6,))
        return self._each(q, 6, lambda K, M, load, B: B @ np.linalg.solve(K, load + B.T @ F))

    def compliance(self, q: ArrayLike) -> Floats:
        """(*batch, 36) rows of the matrix (6, 6) of the tip's motion per wrench, in {s} at its origin."""
        return self._each(q, 36, lambda K, M, load, B: (B @ np.linalg.solve(K, B.T)).ravel())

    def frequencies(self, q: ArrayLike, count: int = 3) -> Floats:
        """(*batch, count) lowest natural frequencies with the motors held [Hz]; infinite beyond those there are.

        Args:
            q: (*batch, n) configurations [rad | m].
            count: how many.
        """
        most = whole("count", count, least=1, most=100)

        def lowest(K: Floats, M: Floats, load: Floats, B: Floats) -> Floats:
            # Of massless parts the flexibility is finite, the inverse problem M x = K x / w^2 has no pole there.
            L = np.linalg.inv(np.linalg.cholesky(K))
            values = np.maximum(np.linalg.eigvalsh(L @ M @ L.T)[::-1][:most], 0.0)
            padded = np.append(values, np.zeros(max(0, most - len(values))))
            with np.errstate(divide="ignore"):
                return np.where(padded > 1e-18, 1.0 / np.sqrt(padded) / (2.0 * np.pi), inf)

        return self._each(q, most, lowest)

    def _each(self, q: ArrayLike, size: int, function: Callable[[Floats, Floats, Floats, Floats], Floats]) -> Floats:
        """A function of the matrices at every configuration; zeros (or no frequency) of an arm that is all rigid."""
        rows = as_batch("q", q, (self.design.robot.n,), finite=True)
        flat = rows.reshape(-1, rows.shape[-1])
        if not self.freedoms:
            found = np.full((len(flat), size), 0.0 if size in (6, 36) else inf)
        else:
            found = np.array([function(*self.matrices(u)) for u in flat]).reshape(len(flat), size)
        return found.reshape(*rows.shape[:-1], size)


def beam_matrices(tube: Tube, along: Floats) -> tuple[Floats, Floats]:
    """Stiffness and consistent mass (12, 12) of a beam, for (rotation, translation) of both ends in {s}.

    Args:
        tube: its section.
        along: (3,) from its first end to its second, in {s} [m].
    """
    L = float(np.linalg.norm(along))
    E, G, A, I = tube.material.young, tube.material.shear, tube.area, tube.second_moment
    mass = tube.material.density * A * L
    K, M = np.zeros((12, 12)), np.zeros((12, 12))
    stretch, twist = np.array([5, 11]), np.array([2, 8])
    for rows, stiff, heavy in ((stretch, E * A / L, mass), (twist, G * 2.0 * I / L, mass * 2.0 * I / A)):
        K[np.ix_(rows, rows)] = stiff * np.array([[1.0, -1.0], [-1.0, 1.0]])
        M[np.ix_(rows, rows)] = heavy / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    bend = E * I / L**3 * np.array(
        [[12, 6 * L, -12, 6 * L], [6 * L, 4 * L**2, -6 * L, 2 * L**2],
         [-12, -6 * L, 12, -6 * L], [6 * L, 2 * L**2, -6 * L, 4 * L**2]]
    )  # fmt: skip
    sway = mass / 420.0 * np.array(
        [[156, 22 * L, 54, -13 * L], [22 * L, 4 * L**2, 13 * L, -3 * L**2],
         [54, 13 * L, 156, -22 * L], [-13 * L, -3 * L**2, -22 * L, 4 * L**2]]
    )  # fmt: skip
    # Across x the slope is the rotation about y, across y minus that about x.
    for rows, sign in ((np.array([3, 1, 9, 7]), 1.0), (np.array([4, 0, 10, 6]), -1.0)):
        S = np.diag([1.0, sign, 1.0, sign])
        K[np.ix_(rows, rows)], M[np.ix_(rows, rows)] = S @ bend @ S, S @ sway @ S
    R = np.kron(np.eye(4), frame_along(along / L))
    return R @ K @ R.T, R @ M @ R.T


def _rest(inertial: Inertial | None, tube: Tube | None, end: Floats, carried: Floats) -> Floats:
    """(6, 6) spatial inertia of a link without its tube and without the drive (10,) that it carries, in its frame."""
    total = parameters_of(inertial) - carried
    if tube is not None:
        total = total - parameters_of(tube.inertial(end))
    largest = np.abs(parameters_of(inertial)).max()
    return _spatial_inertia(np.where(np.abs(total) > 1e-12 * largest, total, 0.0))


def _spatial_inertia(parameters: Floats) -> Floats:
    """(6, 6) of a body's inertial parameters (10,); zeros without a mass."""
    return RigidBody(inertial_of(parameters)).spatial_inertia if parameters[0] > 0.0 else np.zeros((6, 6))


def _turn(G: Floats, R: Floats) -> Floats:
    both = np.kron(np.eye(2), R)
    return both @ G @ both.T


def _carry(arm: Floats) -> Floats:
    """(6, 6) from the motion (rotation, translation) of a point to that of the point `arm` away on the same body."""
    x, y, z = arm
    T = np.eye(6)
    T[3:, :3] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return T


def _add_body(M: Floats, load: Floats, B: Floats, G: Floats, g: Floats) -> None:
    M += B.T @ G @ B
    load += B.T @ G @ np.array([0.0, 0.0, 0.0, *g])
