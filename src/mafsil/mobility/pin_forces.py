"""Accelerations of a linkage along a motion, forces in its joints, effort of its motor, transmission angles.

Screws, twists and wrenches are taken about the middle of the linkage, lengths over its size, so that nothing depends on
units. Unknown are the wrench of every joint, the effort of the motor and one force for each coupling:

    sum of the wrenches on each body = rate of its momentum - loads,    S_j . w_j = effort of coordinate j.

In a planar linkage these are as many equations as unknowns; redundant constraints leave wrenches open, of which the
shortest are taken. The effort of the motor is unique in any case.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.messages import say
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.linkages.linkage_file import LinkageLoads
from mafsil.mobility.linkages.loop_closure import LoopState, coupling_errors, loop_state, reduced_screws, units
from mafsil.mobility.spaces.motion_group import bracket, cross
from mafsil.mobility.tolerances import RANK
from mafsil.solvers import decompositions

IN_PLANE = (2, 3, 4)
"""Rows of a wrench that a planar linkage feels: the moment about z, both forces."""
NO_FORCE = 1e-9
"""Of a unit effort, over the size: a pin with less of it transmits nothing."""


@dataclass(frozen=True, eq=False)
class DrivenMotion:
    """A linkage in motion, driven by one coordinate, row by row; lengths over the size, about the middle.

    Attributes:
        linkage: as drawn.
        driven: column of the driven coordinate.
        state: poses, screws and matrix of the loops.
        screws: (k, 6, F) now.
        rates, accelerations: (k, F) of the coordinates over `units`.
        twists, twist_rates: (k, N, 6) of the bodies.
        slopes: (k, K, F) rates of the couplings.
    """

    linkage: Linkage
    driven: int
    state: LoopState
    screws: Floats
    rates: Floats
    accelerations: Floats
    twists: Floats
    twist_rates: Floats
    slopes: Floats


def driven_motion(linkage: Linkage, theta: Floats, driven: int, speed: Floats, acceleration: Floats) -> DrivenMotion:
    """Rates and accelerations of all joints while one coordinate moves.

    A_p u_p' = - A_d u_d',  A_p u_p'' = - A_d u_d'' - gamma,  gamma = sum of ad(V_before) S u' along each loop.

    Args:
        linkage: as drawn.
        theta: (k, F) closed configurations [rad | m].
        driven: column of the driven coordinate.
        speed, acceleration: (k,) of it [rad | m] per second and its square.
    """
    state, scale = loop_state(linkage, theta), units(linkage)
    A, S, F = state.matrix, reduced_screws(linkage, state.screws), linkage.coordinates
    passive = np.delete(np.arange(F), driven)
    back = decompositions.pinv(A[..., passive], RANK)
    u = np.zeros(theta.shape)
    u[:, driven] = speed / scale[driven]
    u[:, passive] = -np.einsum("kpr,kr->kp", back, A[..., driven] * u[:, driven, None])
    moves = S * u[:, None, :]
    passed = linkage.paths[:, linkage.joint_of]
    twists = np.einsum("nf,kif->kni", passed, moves)
    same = linkage.joint_of[:, None] == linkage.joint_of
    earlier = same & (np.arange(F)[None, :] < np.arange(F)[:, None])
    before = twists[:, linkage.ends[linkage.joint_of, 0]] + np.einsum("fg,kig->kfi", earlier, moves)
    bent = bracket(before, np.swapaxes(moves, 1, 2))
    gamma = np.einsum("lf,kfi->kli", linkage.cycles[:, linkage.joint_of], bent).reshape(len(theta), -1)
    slopes = np.zeros((len(theta), 0, F))
    if linkage.couplings:
        _, slopes, bends = coupling_errors(linkage, theta)
        gamma = np.concatenate([gamma, np.einsum("kcf,kf->kc", bends, u**2)], axis=1)
    a = np.zeros(theta.shape)
    a[:, driven] = acceleration / scale[driven]
    a[:, passive] = -np.einsum("kpr,kr->kp", back, gamma + A[..., driven] * a[:, driven, None])
    twist_rates = np.einsum("nf,kfi->kni", passed, bent + np.swapaxes(S * a[:, None, :], 1, 2))
    return DrivenMotion(linkage, driven, state, S, u, a, twists, twist_rates, slopes)


@dataclass(frozen=True, eq=False)
class PinForces:
    """Forces in the joints of a driven linkage, row by row.

    Attributes:
        joints: names, in the order of the columns.
        forces: (k, J, 3) of the parent on the child, in the axes of the drawing [N].
        moments: (k, J, 3) the same about the place of the joint [N m].
        torque: (k,) effort of the motor [N m | N].
        unique: whether equilibrium decides the forces; else they are the shortest of many.
        given: whether there are masses or loads at all.
        weightless: masses in a plane without a gravity in it.
    """

    joints: tuple[str, ...]
    forces: Floats
    moments: Floats
    torque: Floats
    unique: bool
    given: bool
    weightless: bool

    def sentences(self, language: str | None = None) -> list[str]:
        """What the motor needs, which pin bears most, and what is not certain about it."""
        if not self.given:
            return [say("mobility.turn_no_loads", language=language)]
        sizes = np.linalg.norm(self.forces, axis=-1)
        _, column = np.unravel_index(int(np.nanargmax(sizes)), sizes.shape)
        lines = [
            say(
                "mobility.turn_forces", language=language, low=float(np.nanmin(self.torque)), joint=self.joints[column],
                high=float(np.nanmax(self.torque)), force=float(np.nanmax(sizes)),
            )
        ]  # fmt: skip
        lines += [] if self.unique else [say("mobility.turn_not_unique", language=language)]
        return lines + ([say("mobility.turn_weightless", language=language)] if self.weightless else [])


@dataclass(frozen=True, eq=False)
class _Equilibrium:
    """Wrenches of the joints, effort of the motor and forces of the couplings from wrenches on the bodies, solved.

    Attributes:
        motion: of the linkage.
        kept: components of a wrench that count.
        back: (k, c J + 1 + K, c (N - 1) + F) pseudoinverses of the equations.
        unique: whether no row leaves anything open.
    """

    motion: DrivenMotion
    kept: tuple[int, ...]
    back: Floats
    unique: bool

    @classmethod
    def of(cls, motion: DrivenMotion) -> _Equilibrium:
        linkage, rows = motion.linkage, len(motion.rates)
        kept = IN_PLANE if linkage.planar else tuple(range(6))
        J, N, F, c, K = len(linkage.joints), len(linkage.bodies), linkage.coordinates, len(kept), len(linkage.couplings)
        M = np.zeros((rows, c * (N - 1) + F, c * J + 1 + K))
        for j, (parent, child) in enumerate(linkage.ends.tolist()):
            for body, sign in ((parent, -1.0), (child, 1.0)):
                if body:
                    M[:, c * (body - 1) : c * body, c * j : c * (j + 1)] = sign * np.eye(c)
        power = np.swapaxes(motion.screws, 1, 2)[..., list(kept)]
        for f, j in enumerate(linkage.joint_of.tolist()):
            M[:, c * (N - 1) + f, c * j : c * (j + 1)] = power[:, f]
        M[:, c * (N - 1) + motion.driven, c * J] = -1.0
        M[:, c * (N - 1) :, c * J + 1 :] = -np.swapaxes(motion.slopes, 1, 2)
        unique = bool((decompositions.ranks(M, RANK) == M.shape[2]).all())
        return cls(motion, kept, decompositions.pinv(M, RANK), unique)

    def solve(self, wrenches: Floats, efforts: Floats) -> tuple[Floats, Floats]:
        """Wrenches of the joints (k, J, 6) and effort of the motor (k,).

        Args:
            wrenches: (k, N, 6) that the joints of each body must exert on it.
            efforts: (k, F) given ones of the coordinates.
        """
        rows, J = len(wrenches), len(self.motion.linkage.joints)
        right = np.concatenate([wrenches[:, 1:, list(self.kept)].reshape(rows, -1), efforts], axis=1)
        x = np.einsum("kxr,kr->kx", self.back, right)
        found = np.zeros((rows, J, 6))
        found[..., list(self.kept)] = x[:, : J * len(self.kept)].reshape(rows, J, -1)
        return found, x[:, J * len(self.kept)]


def pin_forces(motion: DrivenMotion, loads: LinkageLoads) -> tuple[PinForces, Floats, tuple[str, ...]]:
    """Forces in the joints, transmission angles (k, m) of the followers [rad], and their names.

    Args:
        motion: of the linkage.
        loads: masses, forces and gravity.
    """
    linkage, balance = motion.linkage, _Equilibrium.of(motion)
    wrenches, torque = balance.solve(_required_wrenches(motion, loads), np.zeros(motion.rates.shape))
    places = joint_places(linkage, motion.state)
    force = wrenches[..., 3:] / linkage.size
    moment = wrenches[..., :3] - cross(places, force) * linkage.size
    effort = torque / units(linkage)[motion.driven]
    normal = np.array([0.0, 0.0, 1.0])
    weightless = linkage.planar and any(each.mass for each in loads.masses) and not cross(normal, loads.gravity).any()
    found = PinForces(
        tuple(each.name for each in linkage.joints), force, moment, effort, balance.unique, bool(loads), weightless
    )
    followers, angles = _transmission(balance, places)
    return found, angles, followers


def joint_places(linkage: Linkage, state: LoopState) -> Floats:
    """(k, J, 3) where the joints are, on their parents, from the middle over the size."""
    T = state.poses[:, linkage.ends[:, 0]]
    drawn = np.array([each.point for each in linkage.joints])
    x = np.einsum("kjab,jb->kja", T[..., :3, :3], drawn) + T[..., :3, 3]
    return (x - linkage.middle) / linkage.size


def _required_wrenches(motion: DrivenMotion, loads: LinkageLoads) -> Floats:
    """(k, N, 6) what the joints must exert on each body: rate of its momentum less loads and weight."""
    linkage = motion.linkage
    size, T = linkage.size, motion.state.poses
    found = np.zeros(motion.twists.shape)

    def add(body: int, r: Floats, force: Floats, moment: Floats) -> None:
        found[:, body, :3] += moment + cross(r, force) * size
        found[:, body, 3:] += force * size

    def place_of(body: int, point: Floats) -> Floats:
        return (T[:, body, :3, :3] @ point + T[:, body, :3, 3] - linkage.middle) / size

    for each in loads.masses:
        b = linkage.bodies.index(each.body)
        r, R = place_of(b, each.center), T[:, b, :3, :3]
        w, alpha = motion.twists[:, b, :3], motion.twist_rates[:, b, :3]
        v = motion.twists[:, b, 3:] + cross(w, r)
        a = size * (motion.twist_rates[:, b, 3:] + cross(alpha, r) + cross(w, v))
        I = R @ each.inertia @ np.swapaxes(R, 1, 2)
        spin = np.einsum("kij,kj->ki", I, alpha) + cross(w, np.einsum("kij,kj->ki", I, w))
        add(b, r, each.mass * (a - loads.gravity), spin)
    for each in loads.loads:
        b = linkage.bodies.index(each.body)
        turn = T[:, b, :3, :3] if each.follows else np.broadcast_to(np.eye(3), (len(T), 3, 3))
        add(b, place_of(b, each.at), -turn @ each.force, -turn @ each.moment)
    return found


def _transmission(balance: _Equilibrium, places: Floats) -> tuple[tuple[str, ...], Floats]:
    """Names of the followers and their transmission angles (k, m) [rad].

    A follower is a joint of one freedom on the ground that something else drives. A unit effort resists it, and nothing
    else: the sine of the angle is the power that joints bring to its body over what they would bring if each pushed
    along the velocity of its point of application.
    """
    motion = balance.motion
    linkage, names, angles = motion.linkage, list[str](), list[Floats]()
    for j, each in enumerate(linkage.joints):
        column = int(np.searchsorted(linkage.joint_of, j))
        grounded = linkage.ground in (each.parent, each.child)
        if not grounded or each.freedoms != 1 or column == motion.driven or _is_driven_by_gear(linkage, each.name):
            continue
        resisting = np.zeros(motion.rates.shape)
        resisting[:, column] = 1.0
        wrenches, _ = balance.solve(np.zeros(motion.twists.shape), resisting)
        body = int(linkage.ends[j, 1] or linkage.ends[j, 0])
        power, most = np.zeros(len(places)), np.zeros(len(places))
        for i in np.flatnonzero((linkage.ends == body).any(axis=1)).tolist():
            if i != j:
                one, all_ = _power_at(wrenches[:, i], places[:, i], motion.screws[:, :, column])
                power, most = power + (one if linkage.ends[i, 1] == body else -one), most + all_
        with np.errstate(invalid="ignore", divide="ignore"):
            sine = np.where(most > NO_FORCE, np.abs(power) / most, np.nan)
        if np.isfinite(sine).any():
            names.append(each.name)
            angles.append(np.arcsin(np.clip(sine, 0.0, 1.0)))
    return tuple(names), np.stack(angles, axis=-1) if angles else np.zeros((len(places), 0))


def _is_driven_by_gear(linkage: Linkage, joint: str) -> bool:
    return any(joint in (each.follower, each.leader) for each in linkage.couplings)


def _power_at(wrench: Floats, place: Floats, twist: Floats) -> tuple[Floats, Floats]:
    """Power of a wrench on a moving body, and |f| |v| at the point of its line of action nearest to a place."""
    m, f = wrench[:, :3], wrench[:, 3:]
    about = m - cross(place, f)
    square = (f**2).sum(axis=1)
    r = place + cross(f, about) / np.where(square > NO_FORCE**2, square, np.inf)[:, None]
    v = twist[:, 3:] + cross(twist[:, :3], r)
    power = (m * twist[:, :3]).sum(axis=1) + (f * twist[:, 3:]).sum(axis=1)
    twisting = np.abs((f * about).sum(axis=1)) > np.sqrt(square) * NO_FORCE
    size = np.sqrt(square) * np.linalg.norm(v, axis=1)
    return power, np.where(twisting, np.nan, size)
