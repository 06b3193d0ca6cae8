"""Answers of closed chains, platforms, cables, syntheses and grasps, each with what it lacks, recomputed."""

from __future__ import annotations

from functools import cache

import numpy as np

from mafsil import grasp, mobility, one_joint, parallel
from mafsil.geometry import pose
from mafsil.grasp import Contact
from tests.mobility.mechanisms import five_bar, four_bar
from tests.reliability.good.arms import Claims


@cache
def platform(length: float) -> parallel.StewartPlatform:
    base = np.radians([-15, 15, 105, 135, 225, 255])
    top = np.radians([-45, 45, 75, 165, 195, 285])
    return parallel.StewartPlatform.on_circles(2.0 * length, length, base, top)


def near_home(rng: np.random.Generator, length: float, *batch: int, wide: float = 0.2) -> np.ndarray:
    home = pose.from_translation([0.1 * length, -0.2 * length, 1.6 * length])
    return home @ pose.exp(wide * rng.normal(size=(*batch, 6)) * np.repeat([1.0, length], 3))


def _legs_of(robot: parallel.StewartPlatform, T: np.ndarray) -> np.ndarray:
    """Lengths by the distance of the ends: nothing of the package but the pose's numbers."""
    ends = robot.platform @ np.swapaxes(T[..., :3, :3], -1, -2) + T[..., None, :3, 3]
    return np.linalg.norm(ends - robot.base, axis=-1)


def platform_forward(rng: np.random.Generator, length: float) -> Claims:
    robot = platform(length)
    wanted = _legs_of(robot, near_home(rng, length, wide=rng.choice([0.1, 1.0]))) * rng.uniform(0.7, 1.3, 6)
    every = robot.forward_kinematics(wanted)
    lacks = [np.abs(_legs_of(robot, T) - wanted).max() / (1e-9 * length) for T in every.T]
    yield bool(every), float(max(lacks, default=np.inf))
    modes = parallel.stewart_assembly_modes(robot.base[None], robot.platform[None], wanted[None])
    there = modes.T[0][modes.there[0]]
    lacks = [np.abs(_legs_of(robot, T) - wanted).max() / (1e-8 * length) for T in there]
    yield bool(modes), float(max(lacks, default=np.inf))


def platform_legs(rng: np.random.Generator, length: float) -> Claims:
    robot = platform(length)
    home = near_home(rng, length, wide=0.0)
    legs = parallel.stewart_legs(robot, home)
    T = near_home(rng, length, 4, wide=rng.choice([0.1, 0.6]))
    inverse = parallel.leg_inverse(legs, T)
    driven = list(legs.driven)
    lacks = np.abs(inverse.q[:, driven] - (_legs_of(robot, T) - _legs_of(robot, home))).max()
    yield bool(inverse), float(lacks / (1e-8 * length))
    change = 0.2 * length * rng.normal(size=(4, 6))
    forward = parallel.leg_forward(legs, change)
    lacks = np.abs(_legs_of(robot, forward.T) - _legs_of(robot, home) - change).max()
    yield bool(forward), float(lacks / (1e-8 * length))
    q, V = inverse.q[0], rng.normal(size=6) * np.repeat([1.0, length], 3)
    if not inverse.found[0]:
        return
    rates = parallel.legs.inverse_rates(legs, q, V)
    step = 1e-6
    moved = [_legs_of(robot, pose.exp(sign * step * V) @ T[0]) for sign in (1, -1)]
    lacks = np.abs(rates.rates[driven] - (moved[0] - moved[1]) / (2 * step)).max()
    yield bool(rates), float(lacks / (1e-6 * length))
    F = rng.normal(size=6) * np.repeat([length, 1.0], 3)
    forces = parallel.leg_forces(legs, q, F)
    power = forces.efforts @ rates.rates[driven] - F @ V
    yield bool(forces), float(abs(power) / (1e-6 * length * (1 + np.abs(forces.efforts).max())))
    yield bool(forces), float(np.abs((forces.leg_wrenches.sum(axis=0) - F) / np.repeat([length, 1.0], 3)).max() / 1e-8)


def cables(rng: np.random.Generator, length: float) -> Claims:
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    robot = parallel.CableRobot(
        2 * length * corners, 0.2 * length * corners[::-1] @ np.diag([-1, -1, 1]), np.full(8, 1.0), np.full(8, 50.0)
    )
    T = pose.exp(0.3 * rng.normal(size=(3, 6)) * np.repeat([1.0, length], 3))
    load = rng.normal(size=(3, 6)) * np.repeat([length, 1.0], 3) * 10.0 ** rng.uniform(-1, 2)
    found = parallel.cable_tensions(robot, T, load)
    ends = robot.platform @ np.swapaxes(T[..., :3, :3], -1, -2) + T[:, None, :3, 3]
    ways = robot.base - ends
    pulls = ways / np.linalg.norm(ways, axis=-1, keepdims=True) * found.tensions[..., None]
    made = np.concatenate([np.cross(ends, pulls).sum(axis=1), pulls.sum(axis=1)], axis=-1)
    gap = np.abs((made + load) / np.repeat([length, 1.0], 3)).max(axis=-1)
    slack = np.maximum(1.0 - found.tensions, found.tensions - 50.0).max(axis=-1)
    for k in range(3):
        yield bool(found), float(max(gap[k], slack[k]) / (1e-8 * (50.0 + np.abs(load[k]).max() / length)))
    wanted = np.linalg.norm(ways, axis=-1) + rng.choice([0.0, 0.01]) * length * rng.normal(size=(3, 8))
    poses = parallel.cable_poses(robot, wanted, np.broadcast_to(np.eye(4), (3, 4, 4)))
    ends = robot.platform @ np.swapaxes(poses.x[..., :3, :3], -1, -2) + poses.x[:, None, :3, 3]
    lacks = np.abs(np.linalg.norm(robot.base - ends, axis=-1) - wanted).max()
    yield bool(poses), float(lacks / (1e-6 * length))


def _four_bar_gap(points: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """By how much a four-bar's rotations about its drawn points do not close: the product of plane motions."""
    T = np.broadcast_to(np.eye(3), (*theta.shape[:-1], 3, 3))
    for k, p in enumerate(points):
        c, s = np.cos(theta[..., k]), np.sin(theta[..., k])
        x, y = p[0] - c * p[0] + s * p[1], p[1] - s * p[0] - c * p[1]
        zero, one = np.zeros_like(c), np.ones_like(c)
        T = T @ np.stack([np.stack([c, -s, x], -1), np.stack([s, c, y], -1), np.stack([zero, zero, one], -1)], -2)
    return np.abs(T - np.eye(3))


def linkages(rng: np.random.Generator, length: float) -> Claims:
    points = length * np.array([[0.0, 0.0], [0.3, 1.0], [2.5, 1.5], [3.0, 0.0]]) + 0.2 * length * rng.normal(
        size=(4, 2)
    )
    bars = four_bar(points)
    size = np.repeat([[1.0, 1.0, length]], 2, axis=0)

    def lacks(theta: np.ndarray) -> float:
        return float((_four_bar_gap(points, theta)[..., :2, :] / size).max(initial=0.0) / 1e-8)

    near = mobility.linkages.close_loops_near(bars, rng.normal(size=(3, 4)) * rng.choice([0.1, 2.0]))
    yield bool(near), lacks(near.theta)
    modes = mobility.assembly_modes(bars, {"A": float(rng.uniform(-3, 3))}, starts=32)
    yield bool(modes), lacks(modes.theta) if len(modes.theta) else np.inf
    curve = mobility.trace_motion(bars, steps=100)
    yield bool(curve), lacks(curve.theta)
    H = np.asarray(mobility.linkages.loop_matrix(five_bar(rng.normal(size=2), np.array([2, 0]) + rng.normal(size=2))))
    driven = tuple(int(k) for k in rng.choice(H.shape[1], 2, replace=False))
    rates = parallel.driven_rates(H, driven)
    chosen = rng.normal(size=2)
    all_rates = np.zeros(H.shape[1])
    all_rates[list(rates.driven)] = chosen
    all_rates[list(rates.passive)] = rates.passive_map @ chosen
    yield bool(rates), float(np.abs(H @ all_rates).max() / (1e-8 * (1 + np.abs(all_rates).max()) * np.abs(H).max()))


def cognates(rng: np.random.Generator, length: float) -> Claims:
    bar = mobility.FourBar(*(length * rng.uniform((0.5, 1.5, 1.5, 1.5), (1.0, 2.5, 2.5, 2.5))))
    along, across = (length * rng.uniform(0.3, 2, 2)).tolist()
    found = mobility.synthesis.cognates(bar, along, across, samples=32)
    points = [
        one.coupler_poses(one.theta, int(one.modes[0]))[:, :2] for one in found if len(set(one.modes.tolist())) == 1
    ]
    yield bool(found), float(max(np.abs(each - points[0]).max() for each in points) / (1e-7 * length))
    theta = np.sort(rng.uniform(0, 2, 3))
    sphere = mobility.synthesis.synthesise_spherical_function(theta, np.sort(rng.uniform(0.5, 2, 3)), ground=1.1)
    for one in sphere:
        turned = one.linkage.output_angle(one.theta, one.modes[0].tolist())
        gap = np.angle(np.exp(1j * (np.diff(turned) - np.diff(sphere.task[:, 1]))))
        yield bool(one), float(np.abs(gap).max() / 1e-7)


def syntheses(rng: np.random.Generator, length: float) -> Claims:
    angles = np.sort(rng.uniform(0, 2, 3))
    function = mobility.synthesise_function(angles, np.sort(rng.uniform(0.5, 2.5, 3)), ground=length)
    poses = np.column_stack([length * rng.normal(size=(3, 2)), np.linspace(0, 1.5, 3) + 0.2 * rng.normal(size=3)])
    motion = mobility.synthesise_motion(poses, samples=16)
    for found in (function, motion):
        if not found:
            yield False, 0.0
            continue
        best = found.best
        yield True, float(best.residual / 1e-8)
        if found is motion:
            met = np.array([best.coupler_poses(t, m) for t, m in zip(best.theta, best.modes, strict=True)])
            turn = np.angle(np.exp(1j * (met[:, 2] - poses[:, 2])))
            yield True, float(max(np.abs(met[:, :2] - poses[:, :2]).max() / length, np.abs(turn).max()) / 1e-6)


def _contacts(rng: np.random.Generator, length: float, count: int, dimension: int) -> list[Contact]:
    p = rng.normal(size=(count, dimension))
    p /= np.linalg.norm(p, axis=1, keepdims=True)
    inward = -p + 0.3 * rng.normal(size=p.shape)
    return [Contact(length * a, b, mu=float(rng.choice([0.0, 0.3, 1.0]))) for a, b in zip(p, inward, strict=True)]


def holding(rng: np.random.Generator, length: float) -> Claims:
    contacts = _contacts(rng, length, 4, 3)
    load = rng.normal(size=6) * np.repeat([length, 1.0], 3) * 10.0 ** rng.uniform(-3, 3)
    found = grasp.resist(contacts, load)
    points = np.array([c.point for c in contacts])
    made = np.concatenate([np.cross(points, found.forces).sum(axis=0), found.forces.sum(axis=0)])
    units = np.repeat([length, 1.0], 3) * (np.abs(load[3:]).max() + np.abs(found.forces).max())
    yield bool(found), float(np.abs((made + load) / units).max() / 1e-7)
    for contact, force in zip(contacts, found.forces, strict=True):
        inward = contact.direction / np.linalg.norm(contact.direction)
        push = force @ inward
        beyond = np.linalg.norm(force - push * inward) - contact.mu * push
        yield bool(found), float(max(beyond, -push) / (1e-7 * (np.abs(found.forces).max() + 1e-300)))


def fixtures(rng: np.random.Generator, length: float) -> Claims:
    contacts = _contacts(rng, length, 5, 2)
    points = np.array([c.point for c in contacts])
    inward = np.array([c.direction / np.linalg.norm(c.direction) for c in contacts])
    A = np.vstack([points[:, 0] * inward[:, 1] - points[:, 1] * inward[:, 0], inward.T])
    load = rng.normal(size=3) * np.array([length, 1.0, 1.0])
    gap = 1e-3 * length
    rest = grasp.rest_position(A, load, gap)
    lacks = np.abs((A @ rest.pushes + load) / np.array([length, 1.0, 1.0])).max() if rest else 0.0
    inside = (-gap - A.T @ rest.displacement).max() / gap if rest else 0.0
    yield bool(rest), float(max(lacks / 1e-8, -rest.pushes.min() / 1e-8 if rest else 0.0, inside / 1e-8))
    moved = grasp.motion_within_clearance(A, gap)
    if moved and moved.corners is not None:
        yield True, float((-gap - moved.corners @ A).max() / gap / 1e-8)
    closed = grasp.closure(A)
    yield bool(moved) == bool(closed), 0.0
    if closed:
        x = np.asarray(closed.combination)
        yield True, float(np.abs(A @ x / np.array([length, 1.0, 1.0])).max() / x.max() / 1e-8)
        yield True, 0.0 if x.min() > 0 else np.inf


def fingers(rng: np.random.Generator, length: float) -> Claims:
    two = _contacts(rng, length, 2, 2)
    found = grasp.two_fingers(*two)
    if found:
        between = two[1].point - two[0].point
        for contact, way in zip(two, (between, -between), strict=True):
            cosine = contact.direction @ way / np.linalg.norm(contact.direction) / np.linalg.norm(way)
            yield True, float(np.arccos(np.clip(cosine, -1, 1)) / (np.arctan(contact.mu) + 1e-9))
    yield bool(found), 0.0
    three = _contacts(rng, length, 3, 3)
    verdict = grasp.three_fingers(three)
    judged = grasp.contact_closures(
        np.array([c.point for c in three]) / length, np.array([c.direction for c in three]), [c.mu for c in three]
    )
    yield bool(verdict), 0.0 if bool(judged) else np.inf


def joint_gains(rng: np.random.Generator, length: float) -> Claims:
    inertia, friction = length * 10.0 ** rng.uniform(-3, 3), 10.0 ** rng.uniform(-3, 3)
    pair = -(10.0 ** rng.uniform(-2, 3)) * np.exp(1j * rng.uniform(0, 1.5))
    found = one_joint.gains_from_roots(inertia, friction, [pair, np.conj(pair)])
    kd, kp = np.asarray(found.kd), np.asarray(found.kp)
    made = np.roots([inertia, friction + float(kd), float(kp)])
    lacks = np.abs(np.sort_complex(made) - np.sort_complex([pair, np.conj(pair)])).max() / abs(pair)
    yield bool(found), float(lacks / 1e-6)


ROWS = {
    "ForwardKinematics, PlatformModes of platforms": platform_forward,
    "LegConfigurations, LegRates, LegForces": platform_legs,
    "CableTensions, CablePoses": cables,
    "LoopClosure, AssemblyModes, Trace of linkages, DrivenRates": linkages,
    "Cognates": cognates,
    "ChainSynthesis": cognates,
    "ChainCandidate": cognates,
    "Synthesis": syntheses,
    "ContactForces": holding,
    "RestPosition, ClearanceMotion, Closure of grasps": fixtures,
    "TwoFingers, ThreeFingers": fingers,
    "DesignedGains": joint_gains,
}
