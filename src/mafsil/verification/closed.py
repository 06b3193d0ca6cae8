"""Checks of a robot with loops: the closed chain against d'Alembert along the motions that the loops leave.

With G of the positions of the links, N a basis of its null space, and M, h of the textbook's sums over the links:

    qdd = N y - G^+ c,   N' (M qdd + h - S tau) = 0,   tau = (N' S)^+ N' (M qdd + h),   tau . qd_a = d(K + P)/dt

S sets efforts of the driven joints among those of all. `ClosedChain` eliminates the forces of the loops instead.

Loops a second time, in NumPy, from the positions of the links as the textbook has them: followers move with leaders.

Where a joint that closes a loop puts its child {c}, seen from its frame {p} on the parent, must be a pose T that the
joint allows. What it misses is a list of numbers g(T), linear in T but for the angle of a screw, more of them than
needed. Nothing is shared with `mafsil.mechanics.loop_constraints`: its rows are other numbers with the same null space.

    g(q) = 0,   G = dg/dq by the complex step,   G qd = 0,   G qdd + c = 0,   c = d(G qd)/dt at constant qd

Reference: Lynch & Park, Modern Robotics, sec. 7.1; Udwadia and Kalaba, Analytical Dynamics, 1996.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mafsil.arrays import Floats, Integers
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.mechanics.arm_size import ArmSize
from mafsil.mechanics.quantity import States, random_states
from mafsil.mechanics.textbook import Numbers, Textbook, adjoint, along, gradient, inverse, skew
from mafsil.model import Joint, JointKind
from mafsil.parallel import ClosedChain
from mafsil.parallel.tolerances import RANK
from mafsil.robot import Robot
from mafsil.verification.verification import Check, LeftOut

HINGED = (JointKind.REVOLUTE, JointKind.CYLINDRICAL, JointKind.PLANAR, JointKind.HELICAL)
"""Joints that keep an axis of the child along one of the parent."""
PINNED = (JointKind.FIXED, JointKind.REVOLUTE, JointKind.UNIVERSAL, JointKind.SPHERICAL)
"""Joints that keep a point of the child on one of the parent."""
DRAWS = 8
"""Random configurations per wanted state: near many of them no loop closes."""
ACTUATED = 1e-6
"""Share of the efforts that driven joints may fail to make before a motion counts as one that they cannot make."""


@dataclass(frozen=True, eq=False)
class ClosedStates:
    """Closed states of a chain, and what the second method knows of them.

    Attributes:
        states: q, qd, qdd (b, n) that keep the loops closed; tau (b, n) of the driven joints alone.
        tolerance: (b,) gap up to which `ClosedChain.close_loops` calls them closed.
        G: (b, r, n), c: (b, r) of the loops.
        N: (b, n, f) orthonormal motions that they leave, coordinates in their units.
        margin: (b,) smallest singular value that counts over the largest: what near singular states cost.
    """

    states: States
    tolerance: Floats
    G: Floats
    c: Floats
    N: Floats
    margin: Floats


def closed_states(chain: ClosedChain, loops: LoopBook, size: ArmSize, count: int, seed: int) -> ClosedStates | None:
    """States near random ones, with rates and accelerations along the motions that the loops leave; None where none.

    States of another rank than most are left out: there the motions that are left change by steps.

    Args:
        chain: the loops.
        loops: their second method.
        size: of the robot.
        count: of states.
        seed: of the random numbers.
    """
    drawn = random_states(chain.robot.mechanism, size, DRAWS * count, seed)
    found = chain.close_loops(drawn.q, tries=1)
    good = np.flatnonzero(found.found)
    if not len(good):
        found = chain.close_loops(drawn.q[:count])
        good = np.flatnonzero(found.found)
    if not len(good):
        return None
    q = np.asarray(found.q)[good]
    G = loops.rows(q)
    _, s, Vt = np.linalg.svd(G * size.unit)
    ranks = (s > RANK * s[:, :1]).sum(axis=1)
    rank = int(np.bincount(ranks).argmax())
    kept = np.flatnonzero(ranks == rank)[:count]
    N = np.swapaxes(Vt[kept, rank:], 1, 2)
    margin = s[kept, rank - 1] / np.maximum(s[kept, 0], LEAST_DIVISOR) if rank else np.ones(len(kept))
    rows, q, G = good[kept], q[kept], G[kept]
    qd = _along(N, drawn.qd[rows] / size.unit) * size.unit
    c = loops.curvature(q, qd)
    bent = -np.einsum("bnr,br->bn", np.linalg.pinv(G * size.unit, rcond=RANK), c)
    qdd = (bent + _along(N, drawn.qdd[rows] / size.unit)) * size.unit
    tau = np.zeros_like(q)
    tau[:, chain.actuated] = drawn.tau[rows][:, chain.actuated]
    tolerance = np.broadcast_to(found.tolerance, found.error.shape)[rows]
    rest = {name: getattr(drawn, name)[rows] for name in ("tip_wrench", "base_twist", "base_acceleration")}
    return ClosedStates(replace(drawn, q=q, qd=qd, qdd=qdd, tau=tau, **rest), tolerance, G, c, N, margin)


class ClosedJudge:
    """Compares the closed chain of a robot with the second method.

    Attributes:
        chain: what is compared.
        book, loops: of the second method.
        size: of the robot.
        closed: the states.
        limit: relative error allowed.
    """

    def __init__(self, chain: ClosedChain, loops: LoopBook, size: ArmSize, closed: ClosedStates, limit: float) -> None:
        self.chain, self.loops, self.size, self.closed, self.limit = chain, loops, size, closed, limit
        self.book: Textbook = loops.book
        self.s = closed.states
        self.M: Floats = np.asarray(self.book.mass_matrix(self.s.q))
        self.h: Floats = np.asarray(self.book.newton_euler(self.s.q, self.s.qd, 0 * self.s.qdd).tau)

    def checks(self) -> tuple[list[Check], LeftOut]:
        """All of them, and what was not compared."""
        found, left_out = self._kinematics(), list[tuple[str, str]]()
        for part in (self._jacobians, self._accelerations, self._efforts):
            checks, missing = part()
            found, left_out = found + checks, left_out + missing
        if any(joint.friction is not None for joint in self.chain.robot.mechanism.loops):
            left_out.append(("friction", "verification.loop_friction"))
        left_out.append(("closed_inverse_kinematics", "verification.searched"))
        return found, left_out

    def _kinematics(self) -> list[Check]:
        """Gaps, rows, rates and accelerations: every one in the null space that the positions have."""
        q, qd, qdd, unit = self.s.q, self.s.qd, self.s.qdd, self.size.unit
        terms, G = self.chain.terms(q, qd), self.closed.G * unit
        largest = np.abs(G).max(axis=(1, 2))
        # Where digits of the description contradict each other, loops close as far as these let them.
        bound = np.maximum(self.closed.tolerance, self.limit * self.loops.size)
        open_by = np.maximum(_most(self.loops.gap(q)) * self.loops.size, self.chain.error(q))
        fast = np.abs(qd / unit).max(axis=1) + LEAST_DIVISOR
        scale = largest * (fast + fast**2 + np.abs(qdd / unit).max(axis=1))
        left, slow = self._left(terms.J * unit), terms.J @ qdd[..., None]
        rates = self.chain.rates(q, qd, hold=self.chain.actuated)
        follow = self.chain.accelerations(q, qd, qdd[:, self.chain.actuated])
        own = np.abs(terms.J * unit).max(axis=(1, 2)) * (fast + fast**2 + np.abs(qdd / unit).max(axis=1))
        curved = np.einsum("brn,bn->br", self.closed.G, follow) + self.closed.c
        return [
            self._check("close_loops", open_by / bound * self.limit, "loop_positions"),
            self._check("terms (rows)", left * self.closed.margin, "loop_rows"),
            self._check("terms (bias)", np.abs(slow[..., 0] + terms.gamma).max(axis=1) / own, "loop_curvature"),
            self._check("rates", _most(np.einsum("brn,bn->br", self.closed.G, rates)) / (largest * fast), "loop_rows"),
            self._check("accelerations", _most(curved) / scale * self.closed.margin, "loop_curvature"),
        ]

    def _left(self, J: Floats) -> Floats:
        """(b,) what rows leave of the motions, and motions of the rows' null space of G; infinite at another rank."""
        s, Vt = np.linalg.svd(J)[1:]
        rank = J.shape[2] - self.closed.N.shape[2]
        same = (s > RANK * s[:, :1]).sum(axis=1) == rank
        along = np.abs(J @ self.closed.N).max(axis=(1, 2), initial=0.0) / np.maximum(s[:, 0], LEAST_DIVISOR)
        G = self.closed.G * self.size.unit
        back = np.abs(G @ np.swapaxes(Vt[:, rank:], 1, 2)).max(axis=(1, 2), initial=0.0) / np.abs(G).max(axis=(1, 2))
        return np.where(same, np.maximum(along, back), np.inf)

    def _jacobians(self) -> tuple[list[Check], LeftOut]:
        """Twists of the tip along the motions that the loops leave, against the chain's Jacobian times driven rates."""
        q, driven = self.s.q, self.chain.actuated
        try:
            found = {"jacobian_space": self.chain.jacobian_space(q), "jacobian_body": self.chain.jacobian_body(q)}
        except InputError:
            return [], [("ClosedChain.jacobian_space, jacobian_body, joint_torque", "verification.not_deciding")]
        motions = self.closed.N * self.size.unit[:, None]
        checks: list[Check] = []
        for name, J in found.items():
            twists = np.asarray(getattr(self.book, name)(q)) @ motions
            gap = np.abs(twists - J @ motions[:, driven]) / self.size.twist[:, None]
            largest = np.maximum(np.abs(J * self.size.unit[driven]).max(axis=(1, 2)), 1.0)
            checks.append(self._check(name, gap.max(axis=(1, 2)) / largest * self.closed.margin, "loop_motions"))
        assert self.s.tip_wrench is not None
        F = self.s.tip_wrench
        power = np.einsum("bi,bij->bj", F, np.asarray(self.book.jacobian_body(q)) @ motions)
        ours = np.einsum("ba,baf->bf", self.chain.joint_torque(q, F), motions[:, driven])
        largest = np.maximum(np.abs(power).max(axis=1), self.size.moment)
        checks.append(self._check("joint_torque", _most(ours - power) / largest * self.closed.margin, "virtual_power"))
        return checks, []

    def _accelerations(self) -> tuple[list[Check], LeftOut]:
        """Accelerations under efforts of the driven joints."""
        s, unit, N = self.s, self.size.unit, self.closed.N
        answer = self.chain.forward_dynamics(s.q, s.qd, s.tau[:, self.chain.actuated])
        motions: Floats = N * unit[:, None]
        inner: Floats = np.swapaxes(motions, 1, 2) @ self.M @ motions
        values = np.linalg.eigvalsh(inner)
        ratio = values[:, 0] / np.maximum(values[:, -1], LEAST_DIVISOR) if values.shape[1] else np.ones(len(s.q))
        if not answer or float(ratio.min()) < RANK:
            return [], [("ClosedChain.forward_dynamics", "verification.no_inverse")]
        bent = -np.einsum("bnr,br->bn", np.linalg.pinv(self.closed.G * unit, rcond=RANK), self.closed.c) * unit
        load: Floats = s.tau - self.h - np.einsum("bij,bj->bi", self.M, bent)
        pull: Floats = np.einsum("bnf,bn->bf", motions, load)
        y = np.asarray(np.linalg.solve(inner, pull[..., None]), dtype=np.float64)
        qdd: Floats = bent + (motions @ y)[..., 0]
        largest = np.maximum(np.abs(qdd / unit).max(axis=1), 1.0)
        gap = np.abs((np.asarray(answer.qdd) - qdd) / unit).max(axis=1) / largest
        return [self._check("forward_dynamics", gap * ratio * self.closed.margin, "loop_motions")], []

    def _efforts(self) -> tuple[list[Check], LeftOut]:
        """Efforts of a motion, that with the forces of the loops they balance every joint, and their power."""
        s, driven, unit = self.s, self.chain.actuated, self.size.unit
        found = self.chain.inverse_dynamics(s.q, s.qd, s.qdd)
        needed = np.einsum("bij,bj->bi", self.M, s.qdd) + self.h
        largest = np.maximum(np.abs(needed * unit).max(axis=1), self.size.moment)
        able = np.asarray(found.missing) <= ACTUATED * np.maximum(np.asarray(found.needed), LEAST_DIVISOR)
        if not len(driven) or not able.all():
            return [], [("ClosedChain.inverse_dynamics", "verification.not_moved")]
        tau = np.asarray(found.tau)
        # The shortest efforts: without any part that only strains the loops.
        P = np.linalg.qr(self.closed.N * unit[:, None])[0]
        PS = np.swapaxes(P[:, driven], 1, 2)
        strain = np.eye(len(driven)) - np.linalg.pinv(PS, rcond=RANK) @ PS
        missed = np.einsum("bnf,bn->bf", self.closed.N, (needed - _spread(tau, driven, len(unit))) * unit)
        strained = np.einsum("bij,bj->bi", strain, tau)
        balance = needed - _spread(tau, driven, len(unit))
        balance -= np.einsum("bmn,bm->bn", self.chain.terms(s.q).J, np.asarray(found.force))
        growth = np.einsum("bi,bij,bj->b", s.qd, self.M, s.qdd)
        growth += np.einsum("bi,bij,bj->b", s.qd, along(self.book.mass_matrix, s.q, s.qd), s.qd) / 2
        growth += along(self.book.potential_energy, s.q, s.qd)
        power = np.abs(np.einsum("ba,ba->b", tau, s.qd[:, driven]) - growth)
        fast = np.maximum(np.abs(s.qd / unit).max(axis=1), 1.0)
        cost = largest / self.closed.margin
        return [
            self._check("inverse_dynamics", _most(missed) / cost, "loop_motions"),
            self._check("inverse_dynamics (shortest)", _most(strained * unit[driven]) / cost, "loop_strain"),
            self._check("inverse_dynamics (forces)", _most(balance * unit) / cost, "loop_balance"),
            self._check("inverse_dynamics . qd", power / (cost * fast), "power"),
        ], []

    def _check(self, routine: str, ratio: Floats, method: str) -> Check:
        worst = np.where(np.isfinite(ratio), np.abs(ratio), np.inf)
        name = f"ClosedChain.{routine}"
        return Check(name, f"verification.{method}", float(worst.max()), self.limit, int(worst.argmax()))


def closed_judge(robot: Robot, count: int, seed: int, limit: float) -> ClosedJudge | None:
    """The judge of a robot with loops at random closed states; None where none were found.

    Args:
        robot: with loops.
        count, seed: of the states.
        limit: relative error allowed.
    """
    chain, size = ClosedChain(robot), ArmSize.of(robot.mechanism)
    loops = LoopBook(Textbook(robot.mechanism), chain.size)
    closed = closed_states(chain, loops, size, count, seed)
    return None if closed is None else ClosedJudge(chain, loops, size, closed, limit)


def _along(N: Floats, x: Floats) -> Floats:
    """(b, n) the part of x along motions N (b, n, f)."""
    return np.einsum("bnf,bmf,bm->bn", N, N, x)


def _most(x: Floats) -> Floats:
    return np.abs(x).max(axis=1, initial=0.0)


def _spread(tau: Floats, driven: Integers, n: int) -> Floats:
    full = np.zeros((len(tau), n))
    full[:, driven] = tau
    return full


class LoopBook:
    """The conditions of the loops of one mechanism; q, qd (b, n).

    Attributes:
        book: kinematics and dynamics of its tree.
        size: lengths are taken over it [m].
    """

    def __init__(self, book: Textbook, size: float) -> None:
        self.book, self.size = book, size

    def gap(self, q: Numbers) -> Numbers:
        """(b, r) what the loops miss, lengths over the size."""
        T = self.book.poses(q)
        return np.concatenate([self._pose_residual(joint, self._seen(joint, T)) for joint in self._joints], axis=1)

    def rows(self, q: Floats) -> Floats:
        """(b, r, n) G, by the complex step."""
        return gradient(self.gap, q)

    def rates(self, q: Numbers, qd: Numbers) -> Numbers:
        """(b, r) G qd from the twists of the links, for one more derivative."""
        T, J = self.book.poses(q), self.book.link_jacobians(q)
        V = np.einsum("blin,bn->bli", J, qd)
        found: list[Numbers] = []
        for joint in self._joints:
            parent, child = self._ends(joint)
            seen = self._seen(joint, T)
            there = adjoint(inverse(np.asarray(joint.T_pj))).astype(V.dtype) @ V[:, parent, :, None]
            twist = V[:, child] - (adjoint(inverse(seen)) @ there)[..., 0]
            change = np.zeros_like(seen)
            change[:, :3, :3], change[:, :3, 3] = skew(twist[:, :3]), twist[:, 3:]
            found.append(self._linear(joint, seen @ change, twist[:, :3] @ joint.axis))
        return np.concatenate(found, axis=1)

    def curvature(self, q: Floats, qd: Floats) -> Floats:
        """(b, r) c: how the rates of the gaps change at constant rates of the joints."""
        return along(lambda x: self.rates(x, qd.astype(x.dtype)), q, qd)

    @property
    def _joints(self) -> tuple[Joint, ...]:
        return self.book.mechanism.loops

    def _ends(self, joint: Joint) -> tuple[int, int]:
        names = self.book.mechanism.link_names
        return names.index(joint.parent), names.index(joint.child)

    def _seen(self, joint: Joint, T: Numbers) -> Numbers:
        """(b, 4, 4) {c} in {p}."""
        parent, child = self._ends(joint)
        return inverse(T[:, parent] @ np.asarray(joint.T_pj)) @ T[:, child]

    def _pose_residual(self, joint: Joint, T: Numbers) -> Numbers:
        """(b, r) g of poses (b, 4, 4)."""
        still = np.broadcast_to(np.eye(4), T.shape)
        return self._linear(joint, T, _angle(joint.axis, T)) - self._linear(joint, still, np.zeros(len(T)))

    def _linear(self, joint: Joint, T: Numbers, angle: Numbers) -> Numbers:
        """(b, r) the part of g that is linear in the pose T (b, 4, 4) and the angle (b,), of a change of these too."""
        a, R, p = np.asarray(joint.axis), T[:, :3, :3], T[:, :3, 3] / self.size
        found: list[Numbers] = []
        if joint.kind in (JointKind.FIXED, JointKind.PRISMATIC):
            found.append(R.reshape(len(T), 9))
        elif joint.kind in HINGED:
            found.append(R @ a)
        elif joint.kind is JointKind.UNIVERSAL:
            found.append((R @ np.asarray(joint.second) @ a)[:, None])
        if joint.kind in PINNED:
            found.append(p)
        elif joint.kind is JointKind.PLANAR:
            found.append((p @ a)[:, None])
        else:
            found.append(p - (p @ a)[:, None] * a)
        if joint.kind is JointKind.HELICAL:
            found.append((p @ a - joint.pitch / self.size * angle)[:, None])
        return np.concatenate(found, axis=1)


def _angle(axis: Floats, T: Numbers) -> Numbers:
    """(b,) angle of poses about an axis, within half a turn; its imaginary part to first order, as the step is."""
    across = np.linalg.svd(axis[None])[2][1]
    turned = T[:, :3, :3] @ across
    x, y = turned @ across, turned @ np.cross(axis, across)
    first = np.arctan2(y.real, x.real)
    if not np.iscomplexobj(T):
        return first
    return first + 1j * (x.real * y.imag - y.real * x.imag) / (x.real**2 + y.real**2)
