"""R6: every planted configuration is found, nothing is wrong, nothing twice, in every family with a closed form.

python -m tests.reliability.ik_complete --cases 1000000 [--seed S] [--family puma ...] [--resume DIR]

Cases are poses. Of a hundred almost 94 are of arms of the library by the public call on batches; two more have joints
at 0, +-pi/2 or pi with probability one half; three are of random arms of every family (ten poses each, a quarter of the
arms with round axes and offsets, three poses of ten round) by the kernel that all arms of a structure share; one is at
the singular surfaces of six arms, see `ik_singular`; two of a thousand are of arms with offset wrists at round joint
values, see `ik_offset_wrists`. How far a planted configuration may be from the one found says
`ik_bounds`. Where the solution found is a member of a continuum it need not be the planted one.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from mafsil.ik import closed_form, inverse_kinematics
from mafsil.ik.chain import Chain, chain_of
from mafsil.ik.structure.closed_form import structure_kernel
from mafsil.ik.structure.recognise import recognise
from mafsil.ik.tolerances import DEFECT, SNAP
from mafsil.model.library import robots
from mafsil.robot import Robot, load
from tests.reliability import figures, ik_offset_wrists, ik_singular
from tests.reliability.arm_families import FAMILIES, forward, jacobian
from tests.reliability.ik_bounds import DELTA, RESIDUAL, apart, bound

POSES_EACH = 10
ROUND = 0.3
BLOCK = 10_000
"""Poses of one call: what is checked of them is held in memory."""

SHARES = {"regular": 0.938, "round": 0.02, "families": 0.03, "singular": 0.01, "offset_wrists": 0.002}


def sample(rng: np.random.Generator, count: int, n: int, share: float) -> np.ndarray:
    """(count, n) configurations, a share of them round."""
    q = rng.uniform(-np.pi, np.pi, (count, n))
    rounded = (rng.random((count, 1)) < share) & (rng.random((count, n)) < 0.5)
    return np.where(rounded, rng.integers(-1, 3, (count, n)) * (np.pi / 2), q)


def library() -> dict[str, Robot]:
    """Arms of the library with an exact closed form of their own, by name."""
    found: dict[str, Robot] = {}
    for name in robots():
        robot = load(name)
        if 0 < robot.n <= 6 and chain_of(robot.mechanism) is not None:
            form = closed_form(robot)
            if form is not None and form.pattern.defect <= DEFECT and not form.pattern.locked:
                found[name] = robot
    return found


def of_library(robot: Robot, rng: np.random.Generator, count: int, share: float) -> dict[str, int]:
    """Planted poses of one arm by the public call."""
    chain = chain_of(robot.mechanism)
    assert chain is not None
    q = sample(rng, count, robot.n, share)
    T = forward(chain, q)
    answer = inverse_kinematics(robot, T)
    free = (answer.free > 0).any(axis=1)
    return _judged(chain, q, T, answer.q, answer.valid, free, repeats=True, name=robot.name)


def of_family(name: str, rng: np.random.Generator, count: int) -> dict[str, int]:
    """Planted poses of random arms of one family."""
    total: dict[str, int] = {"arms": 0, "not_recognised": 0}
    for _ in range(max(1, count // POSES_EACH)):
        rounded = rng.random() < 0.25
        chain = FAMILIES[name](rng, rounded)
        q = sample(rng, POSES_EACH, len(chain), ROUND)
        if rounded and np.linalg.svd(jacobian(chain, q), compute_uv=False)[:, min(6, len(chain)) - 1].max() < 1e-3:
            continue
        pattern = recognise(chain, len(chain))
        total["arms"] += 1
        if pattern is None or pattern.defect > SNAP:
            total["not_recognised"] += 1
            total["bad_not_recognised"] = total.get("bad_not_recognised", 0) + (not rounded)
            continue
        T = forward(chain, q)
        if pattern.defect > DEFECT:
            # By chance almost an arm of a simpler family, which is preferred: the public call refines its rows.
            robot = Robot.from_screws(chain.screws, chain.home)
            lost = sum(not _answers(robot, chain, one, X) for one, X in zip(q, T, strict=True))
            for key, value in {"snapped": 1, "cases": len(q), "bad_lost": lost}.items():
                total[key] = total.get(key, 0) + value
            continue
        table = structure_kernel(pattern)(T, pattern.numbers)
        found, residual, free = table[..., :-3], table[..., -3], table[..., -1]
        valid = residual <= RESIDUAL
        flags = ((np.nan_to_num(free) > 0) & (residual <= 1e-6)).any(axis=1)
        for key, value in _judged(chain, q, T, found, valid, flags, repeats=False, name=name).items():
            total[key] = total.get(key, 0) + value
    return total


def _judged(
    chain: Chain,
    q: np.ndarray,
    T: np.ndarray,
    found: np.ndarray,
    valid: np.ndarray,
    free: np.ndarray,
    *,
    repeats: bool,
    name: str = "",
) -> dict[str, int]:
    """Counts of what is right and wrong."""
    n = len(chain)
    clean = np.where(valid[..., None], found, 0.0)
    reached = forward(chain, clean)
    wrong = valid & ~(np.abs(reached - T[:, None]).max(axis=(-2, -1)) <= RESIDUAL + DELTA * max(1.0, chain.size))
    distance = np.where(valid, apart(clean, q[:, None], chain.prismatic), np.inf)
    nearest = distance.argmin(axis=1)
    distance = distance.min(axis=1)
    residual = np.abs(reached - T[:, None]).max(axis=(-2, -1))[np.arange(len(q)), nearest]
    allowed = bound(jacobian(chain, q), n, residual)
    lost = ~(distance <= np.maximum(allowed, 1e-9)) & ~free
    asked = np.flatnonzero(lost) if not repeats else np.zeros(0, dtype=np.intp)
    if len(asked):
        # Where roots merge, the table alone is not the answer: the public call refines it and asks elimination.
        robot = Robot.from_screws(chain.screws, chain.home)
        for i in asked:
            lost[i] = not _answers(robot, chain, q[i], T[i])
    twice = np.zeros(len(q), dtype=bool)
    for k in range(1, found.shape[1]):
        for j in range(k):
            same = valid[:, k] & valid[:, j] & (apart(clean[:, k], clean[:, j], chain.prismatic) < 1e-9)
            if not repeats and (any(chain.prismatic) or len(chain) < 6):
                same[:] = False
            if not repeats and same.any():
                # Where roots merge, or the degree is lower, the table holds them twice; the public answer merges them.
                rows = np.flatnonzero(same)
                values = np.linalg.svd(jacobian(chain, clean[rows, k]), compute_uv=False)[:, min(6, n) - 1]
                same[rows] = values > 1e-5
            twice |= same
    if not repeats and twice.any():
        robot = Robot.from_screws(chain.screws, chain.home)
        for i in np.flatnonzero(twice):
            twice[i] = _repeats(inverse_kinematics(robot, T[i]).q, chain)
            twice[i] |= _repeats((many := inverse_kinematics(robot, T[i : i + 1])).q[0][many.valid[0]], chain)
    for i in np.flatnonzero(lost | wrong.any(axis=1) | twice)[:1]:
        print(f"# {name} q={q[i]!r} distance {distance[i]:.2e} bound {allowed[i]:.2e}", file=sys.stderr)
    return {
        "cases": len(q),
        "solutions": int(valid.sum()),
        "continua": int(free.sum()),
        "asked_again": len(asked),
        "bad_wrong": int(wrong.sum()),
        "bad_lost": int(lost.sum()),
        "bad_twice": int(twice.sum()),
        "bad_nan": int((~np.isfinite(found) & valid[..., None]).any(axis=(1, 2)).sum()),
    }


def _repeats(q: np.ndarray, chain: Chain) -> bool:
    """Whether a list holds a solution twice."""
    away = apart(q[:, None], q[None], chain.prismatic) + 9 * np.eye(len(q))
    return bool((away < 1e-9).any())


def _answers(robot: Robot, chain: Chain, q: np.ndarray, T: np.ndarray) -> bool:
    """Whether the public call finds a planted configuration, or a continuum through it."""
    answer = inverse_kinematics(robot, T)
    near = apart(answer.q, q, chain.prismatic)
    reached = np.abs(forward(chain, answer.q) - T).max(axis=(-2, -1))
    allowed = bound(jacobian(chain, q[None]), len(chain), reached.max(initial=0.0))[0]
    # At a singular configuration itself the merged root is known to the square root of the residual that is asked for.
    return bool(answer.families) or bool((near <= max(allowed, 1e-9)).any())


def work(chosen: list[str], seed: int, cases: int, only: str = "") -> dict[str, int]:
    """A shard: the chosen families and arms get the same number of poses, or all of them their shares, or one part."""
    robots = library()
    if chosen:
        asked = [("families" if name in FAMILIES else "mixed", name, cases / len(chosen)) for name in chosen]
    else:
        sources = {
            "regular": robots,
            "round": robots,
            "families": FAMILIES,
            "singular": ik_singular.specimens(),
            "offset_wrists": ik_offset_wrists.SHAPES,
        }
        shares = {only: 1.0} if only else SHARES
        asked = [
            (part, name, share * cases / len(sources[part])) for part, share in shares.items() for name in sources[part]
        ]
    total: dict[str, int] = {}
    for k, (part, name, share) in enumerate(asked):
        for key, value in _part(part, name, robots, np.random.default_rng([seed, k]), int(np.ceil(share))).items():
            total[key] = total.get(key, 0) + value
    return total


def _part(part: str, name: str, robots: dict[str, Robot], rng: np.random.Generator, count: int) -> dict[str, int]:
    """Counts of one arm or family in one part of a shard."""
    if part == "families":
        found = of_family(name, rng, max(POSES_EACH, count))
    elif part == "singular":
        found = ik_singular.work(rng, name, count)
    elif part == "offset_wrists":
        found = ik_offset_wrists.work(rng, name, count)
    else:
        share, found = {"regular": 0.0, "round": 1.0, "mixed": ROUND}[part], dict[str, int]()
        for begin in range(0, count, BLOCK):
            block = of_library(robots[name], rng, min(BLOCK, count - begin), share)
            found = {key: found.get(key, 0) + value for key, value in block.items()}
    return {**found, f"cases_{part}": found.get("cases", 0)}


def main() -> int:
    """Run all shards and write the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", dest="count", type=int, default=100_000)
    parser.add_argument("--shard", type=int, default=1_000_000, help="cases per shard")
    parser.add_argument("--seed", type=int, default=0, help="first shard")
    parser.add_argument("--family", nargs="*", default=[], help="families or robots; all if none")
    parser.add_argument("--part", choices=SHARES, default="", help="one part only; all in their shares if none")
    parser.add_argument("--resume", type=Path, default=None, help="directory of the shard files, which are kept")
    options = parser.parse_args()
    return int(
        not figures.run("R6", options, lambda seed, count: work(options.family, seed, count, options.part))["passed"]
    )


if __name__ == "__main__":
    sys.exit(main())
