"""R6, singular surfaces: shoulder, elbow and wrist, at them, two and three of them at once, and 1e-12 to 1e-3 beside.

Configurations are planted on the surfaces by finding where the triple product that vanishes there changes its sign
along one joint. Every solution must reach the pose; the planted configuration must be in the list, or be the member
of a named family at its own values of the free joints. Where the elbow is straight the pose is also moved outwards:
what is found there must reach it too, or the answer is an honest no.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from itertools import combinations

import numpy as np

from mafsil.geometry import pose
from mafsil.ik import SolutionFamily, SolutionSet, closed_form, inverse_kinematics
from mafsil.ik.chain import Chain, chain_of
from mafsil.robot import Robot, load
from tests.reliability.arm_families import forward, jacobian
from tests.reliability.ik_bounds import DELTA, RESIDUAL, TURN, apart, bound

GRID = 49
ARMS = ("puma560", "stanford_arm", "cobra600", "planar3r", "offset_wrist", "ur5e")
SINGLY = ("offset_wrist", "stanford_arm")
"""Arms whose surfaces are met one at a time, and no round angles.

Of the first they are no factors. Of the second the hub is level with joint 2 far beyond the limits of the slide only;
where the wrist is straight there as well, continua cross, and not every crossing is named.
"""

MERGED = 1e-6
"""Distance up to which the public call takes solutions for one."""

Surface = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""(count,) a number that vanishes on the surface, of axes (count, n, 3) and points (count, n + 1, 3), the hub last."""


@dataclass(frozen=True)
class Specimen:
    """An arm, the hub that some joints carry, surfaces with the joint along which each is sought, share of round."""

    robot: Robot
    hub: np.ndarray
    carriers: int
    surfaces: dict[str, tuple[int, Surface]]
    round: float

    @property
    def chain(self) -> Chain:
        """Its screws."""
        chain = chain_of(self.robot.mechanism)
        assert chain is not None
        return chain


def _placed(arm: Specimen, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Axes and points of all joints at configurations, the hub as last point."""
    chain, T = arm.chain, np.broadcast_to(np.eye(4), (len(q), 4, 4))
    axes, points, hub = [], [], np.zeros((len(q), 3))
    for i, screw in enumerate(chain.screws):
        axes.append(T[:, :3, :3] @ chain.axes[i])
        points.append(T[:, :3, :3] @ chain.points[i] + T[:, :3, 3])
        T = T @ pose.exp(screw * q[:, i, None])
        if i + 1 == arm.carriers:
            hub = T[:, :3, :3] @ arm.hub + T[:, :3, 3]
    return np.stack(axes, axis=1), np.stack([*points, hub], axis=1)


def _triple(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    return (np.cross(a, b) * c).sum(axis=-1)


def shoulder(w: np.ndarray, r: np.ndarray) -> np.ndarray:
    """The hub is in the plane of axes 1 and 2."""
    return _triple(w[:, 0], w[:, 1], r[:, -1] - r[:, 0])


def elbow(at: int, to: int, w: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Two links are in line, joint `at` between them, the second up to point `to`."""
    return _triple(w[:, at], r[:, at] - r[:, at - 1], r[:, to] - r[:, at])


def wrist(w: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Axes 4, 5 and 6 are in one plane."""
    return _triple(w[:, 4], w[:, 3], w[:, 5])


def stroke(w: np.ndarray, r: np.ndarray) -> np.ndarray:
    """The slide of joint 3 brings the hub level with joint 2."""
    return (w[:, 2] * (r[:, -1] - r[:, 1])).sum(axis=-1)


def determinant(w: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Of the Jacobian of an arm whose joints all turn."""
    return np.linalg.det(np.concatenate([w, np.cross(r[:, :-1], w)], axis=2))


def _offset_wrist() -> Robot:
    """A UR arm whose last two axes pass each other at 60 mm."""
    chain = chain_of(load("ur5e").mechanism)
    assert chain is not None
    points = chain.points.copy()
    points[5] += 0.06 * np.cross(chain.axes[4], chain.axes[5])
    screws = np.concatenate([chain.axes, np.cross(points, chain.axes)], axis=1)
    return Robot.from_screws(screws, chain.home)


@cache
def specimens() -> dict[str, Specimen]:
    """The arms, by name."""
    both = {"wrist": (4, wrist), "elbow": (2, partial(elbow, 2, -1)), "shoulder": (1, shoulder)}
    plane = {"wrist": (4, wrist), "elbow": (2, partial(elbow, 2, 3)), "shoulder": (1, shoulder)}
    slide = {**both, "elbow": (2, stroke)}
    inner = {f"joint{k + 1}": (k, determinant) for k in (4, 2, 1)}
    asked: tuple[tuple[str, Robot, int, dict[str, tuple[int, Surface]]], ...] = (
        ("puma560", load("puma560"), 3, both),
        ("stanford_arm", load("stanford_arm"), 3, slide),
        ("cobra600", load("cobra600"), 4, {"elbow": (1, partial(elbow, 1, 3))}),
        ("planar3r", load("planar3r"), 3, {"elbow": (1, partial(elbow, 1, 2))}),
        ("offset_wrist", _offset_wrist(), 6, inner),
        ("ur5e", load("ur5e"), 4, plane),
    )
    found: dict[str, Specimen] = {}
    for name, robot, carriers, surfaces in asked:
        form = closed_form(robot)
        assert form is not None
        found[name] = Specimen(robot, form.pattern.centre, carriers, surfaces, 0.0 if name in SINGLY else 0.2)
    return found


def plant(arm: Specimen, rng: np.random.Generator, count: int, chosen: tuple[str, ...]) -> np.ndarray:
    """(up to count, n) configurations at the chosen surfaces or a little beside them."""
    chain = arm.chain
    n = len(chain)
    q = rng.uniform(-np.pi, np.pi, (count, n))
    rounded = (rng.random((count, 1)) < arm.round) & (rng.random((count, n)) < 0.5)
    q = np.where(rounded, rng.integers(-1, 3, (count, n)) * (np.pi / 2), q)
    for name in chosen:
        q = _sought(arm, q, *arm.surfaces[name], rng)
    for name in chosen:
        beside = rng.choice([-1.0, 1.0], len(q)) * 10 ** rng.uniform(-12, -3, len(q))
        q[:, arm.surfaces[name][0]] += np.where(rng.random(len(q)) < 0.3, 0.0, beside)
    return q


def _sought(arm: Specimen, q: np.ndarray, joint: int, surface: Surface, rng: np.random.Generator) -> np.ndarray:
    """Configurations with the joint where the surface's number changes its sign; those without are left out."""

    def number(rows: np.ndarray, x: np.ndarray) -> np.ndarray:
        moved = rows.copy()
        moved[:, joint] = x
        return surface(*_placed(arm, moved))

    # Not a divisor of the turn, so that no value of the grid is the root itself.
    grid = np.linspace(-np.pi, np.pi, GRID) + 0.0123
    values = np.stack([number(q, np.full(len(q), x)) for x in grid], axis=1)
    changes = (values[:, :-1] * values[:, 1:] < 0) & (np.abs(values).max(axis=1, keepdims=True) > 1e-6)
    some = changes.any(axis=1)
    q, values = q[some], values[some]
    at = np.where(changes[some], rng.random((len(q), GRID - 1)), -1.0).argmax(axis=1)
    low, high, sign = grid[at], grid[at + 1], np.sign(values[np.arange(len(q)), at])
    for _ in range(60):
        middle = (low + high) / 2
        same = number(q, middle) * sign > 0
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    q = q.copy()
    q[:, joint] = (low + high) / 2
    return q


def judged(arm: Specimen, chain: Chain, q: np.ndarray, T: np.ndarray) -> dict[str, int]:
    """Counts for one planted configuration."""
    robot = arm.robot
    try:
        answer = inverse_kinematics(robot, T)
        families = answer.families
        bad = {"bad_wrong": _misses(chain, answer, T), "bad_lost": 0, "bad_complete": 0, "bad_exception": 0}
        has = _has(robot, chain, answer, families, q, T)
        hidden = not has and _hidden_bend(arm, answer, q)
        if not has and not hidden:
            bad["bad_lost"], bad["bad_complete"] = 1, int(answer.complete)
        bad["hidden_bend"] = int(hidden)
        return {
            **bad,
            "families": len(families),
            "not_proven": int(not answer.complete),
            "bad_twice": _twice(chain, answer),
        }
    except Exception as error:
        print(f"# {type(error).__name__}: {error}", file=sys.stderr)
        return {"bad_exception": 1}


def _misses(chain: Chain, answer: SolutionSet, T: np.ndarray) -> int:
    """How many solutions do not reach the pose."""
    if not len(answer):
        return 0
    missed = np.abs(forward(chain, answer.q) - T).max(axis=(1, 2))
    return int((~(missed <= RESIDUAL + DELTA * max(1.0, chain.size))).sum())


def _twice(chain: Chain, answer: SolutionSet) -> int:
    """How many solutions repeat an earlier one."""
    return sum(bool((apart(answer.q[:k], answer.q[k], chain.prismatic) < 1e-9).any()) for k in range(1, len(answer)))


def _has(
    robot: Robot, chain: Chain, answer: SolutionSet, families: tuple[SolutionFamily, ...], q: np.ndarray, T: np.ndarray
) -> bool:
    """Whether a configuration is in the list, or the member of a family at its own values of the free joints."""
    J, names = jacobian(chain, q[None]), robot.joint_names
    if len(answer) and _near(chain, J, answer.q, q, T):
        return True
    for family in families:
        for joints in {(family.joint,), family.joints}:
            member = family.follow({name: float(q[names.index(name)]) for name in joints})
            if np.isfinite(member).all() and _near(chain, J, member[None], q, T):
                return True
    return False


def _hidden_bend(arm: Specimen, answer: SolutionSet, q: np.ndarray) -> bool:
    """Whether a solution differs only in joints that a straight wrist sets free, bent by less than rounding tells.

    Beside a merged elbow or shoulder joint 5 is known to the square root of the rounding only, beside both to its
    fourth root: nobody can tell from a pose in working precision where so small a bend points.
    """
    if not len(answer) or len(q) < 6:
        return False
    bend = np.abs(wrist(*_placed(arm, q[None])))[0]
    merged = np.linalg.svd(np.delete(jacobian(arm.chain, q[None])[0], 3, axis=1), compute_uv=False)[-1] < 1e-3
    # Where axes 2, 3 and 4 are parallel, axis 6 joins them, and joints 2, 3, 4 and 6 move.
    kept = [0, 4] if np.abs(np.cross(arm.chain.axes[1], arm.chain.axes[3])).max() < 1e-9 else [0, 1, 2, 4]
    off = np.abs((answer.q - q + np.pi) % TURN - np.pi)[:, kept].max(axis=1)
    return bool(merged and 1e-12 < bend < 64 * np.sqrt(DELTA) and (off < DELTA**0.25).any())


def _near(chain: Chain, J: np.ndarray, some: np.ndarray, q: np.ndarray, T: np.ndarray) -> bool:
    """Whether one of some configurations is the planted one, as near as its residual says."""
    missed = np.abs(forward(chain, some) - T).max(axis=(1, 2))
    allowed = np.maximum(bound(np.repeat(J, len(some), axis=0), len(chain), missed, merged=True), MERGED)
    return bool((apart(some, q, chain.prismatic) <= allowed).any())


def _beyond(robot: Robot, chain: Chain, T: np.ndarray, way: np.ndarray) -> dict[str, int]:
    """Counts for a pose pushed outwards, which may be out of reach."""
    pushed = T.copy()
    pushed[:3, 3] += way
    try:
        answer = inverse_kinematics(robot, pushed)
        silent = not answer.explain()
        return {"pushed": 1, "pushed_out": int(not len(answer)), "bad_wrong": _misses(chain, answer, pushed) + silent}
    except Exception as error:
        print(f"# {type(error).__name__}: {error}", file=sys.stderr)
        return {"bad_exception": 1}


def work(rng: np.random.Generator, name: str, count: int) -> dict[str, int]:
    """About count configurations of one arm, equally many at every combination of its surfaces."""
    arm = specimens()[name]
    chain, total = arm.chain, {"cases": 0}
    every = list(arm.surfaces)
    chosen = [some for k in range(1, len(every) + 1) for some in combinations(every, k)]
    if name in SINGLY:
        chosen = [(one,) for one in every]
    for some in chosen:
        q = plant(arm, rng, -(-count // len(chosen)), some)
        T = forward(chain, q)
        for one, X in zip(q, T, strict=True):
            parts = [judged(arm, chain, one, X)]
            if "elbow" in some and rng.random() < 0.2:
                out = X[:3, 3] * 10 ** rng.uniform(-13, -3) * rng.choice([-1.0, 1.0])
                parts.append(_beyond(arm.robot, chain, X, out))
            bad = sum(value for part in parts for key, value in part.items() if key.startswith("bad_"))
            if bad:
                print(f"# {name} {some} q={one.tolist()!r} {parts}", file=sys.stderr)
            for part in ({"cases": 1, f"at_{'_'.join(some)}": 1}, *parts):
                for key, value in part.items():
                    total[key] = total.get(key, 0) + value
    return total
