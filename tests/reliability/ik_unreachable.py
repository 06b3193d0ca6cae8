"""R7: what cannot be reached is said so, with the right reason and numbers; singular configurations have bounded rates.

python -m tests.reliability.ik_unreachable --cases 1000000 [--shard 100000] [--seed S] [--resume DIR]

Every shard makes an elbow arm (axis 1 upright, axes 2 and 3 level and parallel, links a and b, the wrist's centre d
beside the plane of the arm), a plane arm of two links and limits for a SCARA arm. Truth is elementary geometry:

wrist  With the orientation kept, the centre reaches, in the half-plane of its distance r from axis 1 and height s over
       the shoulder, what has r >= |d| and (a - b)^2 + d^2 <= r^2 + s^2 <= (a + b)^2 + d^2: too far, the inner hole, the
       shoulder's cylinder, and how far away the nearest point of that set is.
plane  The ring |a - b| <= r <= a + b.
scara  Both configurations by the law of cosines, wound into the limits: within, or which joint is how far beyond.

A third of the margins are taken between 1e-7 and 1e-2 of the arm. Every pose goes through a batch; one in a hundred is
asked alone, one in two thousand of the numerical search, which must not converge. Singular ones are
planted at wrist, elbow and shoulder, alone and together.
"""

from __future__ import annotations

import sys

import numpy as np

from mafsil.arrays import Floats
from mafsil.geometry import pose
from mafsil.ik import bounded_rates, inverse_kinematics, solve_ik
from mafsil.ik.chain import chain_of
from mafsil.ik.result import CODES, IKStatus
from mafsil.messages import say
from mafsil.robot import Robot, load
from tests.reliability import figures
from tests.reliability.arm_families import jacobian

ALONE, SEARCHED = 100, 2000
EXACT = 1e-7
TURN = 2 * np.pi
OUT, BEYOND, NOT_OF = (CODES[v] for v in (IKStatus.OUT_OF_REACH, IKStatus.BEYOND_LIMITS, IKStatus.NOT_OF_THIS_ARM))


def work(seed: int, cases: int) -> dict[str, int]:
    """A shard: a quarter each of wrists, plane arms, limits, and singular configurations."""
    rng = np.random.default_rng([7, seed])
    total: dict[str, int] = {"cases": 0}
    for part in (wrist, plane, scara, singular):
        for key, value in part(rng, max(4, cases // 4)).items():
            total[key] = total.get(key, 0) + value
    return total


def elbow_arm(rng: np.random.Generator, *, offset: bool) -> tuple[Robot, Floats]:
    """An elbow arm and its numbers a, b, d, h."""
    a, b = rng.uniform(0.2, 1.0, 2)
    d, h = offset * rng.choice([1.0, -1.0]) * rng.uniform(0.02, 0.2), 0.3
    w = np.array([[0, 0, 1], [0, -1, 0], [0, -1, 0], [1, 0, 0], [0, -1, 0], [1.0, 0, 0]])
    c = np.array([a + b, d, h])
    r = np.array([[0, 0, 0], [0, 0, h], [a, 0, h], c, c, c])
    home = pose.exp(np.array([0.3, 0.4, 0.1, 0, 0, 0]))
    home[:3, 3] = c + np.array([0.1, 0.02, 0.03])
    return Robot.from_screws(np.concatenate([w, np.cross(r, w)], axis=1), home), np.array([a, b, d, h])


def wrist(rng: np.random.Generator, count: int) -> dict[str, int]:
    """Poses whose wrist's centre is too far, in the hole, or in the shoulder's cylinder."""
    robot, (a, b, d, h) = elbow_arm(rng, offset=bool(rng.integers(0, 3)))
    inner, outer = np.hypot(a - b, d), np.hypot(a + b, d)
    margin, kind = _margins(rng, count), rng.integers(0, 3, count)
    slope = rng.uniform(-np.pi / 2, np.pi / 2, count)
    size = np.where(kind == 0, outer * (1 + margin), inner * np.maximum(1 - margin, rng.random(count) * 0.9))
    r, s = size * np.cos(slope), size * np.sin(slope)
    r = np.where(kind == 2, abs(d) * np.maximum(1 - margin, 0.0), r)
    s = np.where(kind == 2, rng.uniform(-1, 1, count) * (a + b), s)
    near, why = wrist_truth(r, s, a, b, d)
    kept = near > 1e-8
    r, s, near, why = r[kept], s[kept], near[kept], why[kept]
    turn = rng.uniform(-np.pi, np.pi, len(r))
    centre = np.stack([r * np.cos(turn), r * np.sin(turn), s + h], axis=1)
    T = pose.exp(np.concatenate([rng.normal(size=(len(r), 3)) * 1.5, np.zeros((len(r), 3))], axis=1))
    home = chain_of(robot.mechanism).home
    T[:, :3, 3] = centre - T[:, :3, :3] @ (home[:3, :3].T @ (np.array([a + b, d, h]) - home[:3, 3]))
    return _refused(robot, T, near, why, "pose")


def wrist_truth(r: Floats, s: Floats, a: float, b: float, d: float) -> tuple[Floats, Floats]:
    """How far the nearest place is, zero if reached, and the true reasons: a sum of 1 far, 2 near, 4 shoulder."""
    inner, outer, size = np.hypot(a - b, d), np.hypot(a + b, d), np.hypot(r, s)
    why = 1 * (size > outer) + 2 * (size < inner) + 4 * (r < abs(d))
    best = np.full(len(r), np.inf)
    safe = np.maximum(size, 1e-300)
    for ring in (inner, outer):
        on = r / safe * ring >= abs(d)
        best = np.where(on, np.minimum(best, np.abs(size - ring)), best)
        corner = np.sqrt(max(ring**2 - d**2, 0.0))
        for sign in (-1, 1):
            best = np.minimum(best, np.hypot(r - abs(d), s - sign * corner))
    beside = (np.abs(s) >= abs(a - b)) & (np.abs(s) <= a + b)
    best = np.where(beside, np.minimum(best, np.abs(r - abs(d))), best)
    return np.where(why == 0, 0.0, best), why


def plane(rng: np.random.Generator, count: int) -> dict[str, int]:
    """Places outside the ring of a plane arm of two links."""
    a, b = rng.uniform(0.2, 1.0, 2)
    home = np.eye(4)
    home[0, 3] = a + b
    robot = Robot.from_screws(np.array([[0, 0, 1, 0, 0, 0], [0, 0, 1, 0, -a, 0.0]]), home)
    far, margin = rng.random(count) < 0.5, _margins(rng, count)
    r = np.where(far, (a + b) * (1 + margin), abs(a - b) * np.maximum(1 - margin, rng.random(count) * 0.9))
    turn = rng.uniform(-np.pi, np.pi, count)
    T = np.broadcast_to(np.eye(4), (count, 4, 4)).copy()
    T[:, 0, 3], T[:, 1, 3] = r * np.cos(turn), r * np.sin(turn)
    near = np.where(far, r - (a + b), abs(a - b) - r)
    kept = near > 1e-8
    return _refused(robot, T[kept], near[kept], np.where(far, 1, 2)[kept], "position")


def _margins(rng: np.random.Generator, count: int) -> Floats:
    """Relative distances from the border, a third of them small."""
    return np.where(rng.random(count) < 1 / 3, 10 ** rng.uniform(-7, -2, count), rng.exponential(0.5, count) + 1e-3)


def _refused(robot: Robot, T: Floats, near: Floats, why: Floats, task: str) -> dict[str, int]:
    batch = inverse_kinematics(robot, T, task=task)
    reasons = {1: say("ik.failed_far"), 2: say("ik.failed_near"), 4: say("ik.failed_shoulder")}
    count = {
        "cases": len(T),
        "bad_verdict": int((batch.status_codes != OUT).sum()),
        "bad_found": int(batch.valid.sum()),
    }
    count |= {"asked_alone": 0, "searched": 0, "bad_reason": 0, "bad_distance": 0, "bad_nearest": 0, "bad_converged": 0}
    for i in range(0, len(T), ALONE):
        one = inverse_kinematics(robot, T[i], task=task)
        size, words = max(1.0, float(near[i])), one.explain()
        # The orientation is kept and the place brought as near as can be.
        moved = np.linalg.norm(one.T_nearest[:3, 3] - T[i, :3, 3])
        turned = 0.0 if task == "position" else np.abs(one.T_nearest[:3, :3] - T[i, :3, :3]).max()
        bad = {
            "bad_verdict": one.status is not IKStatus.OUT_OF_REACH or not one.complete,
            "bad_reason": not any(why[i] & bit and text in words for bit, text in reasons.items()),
            "bad_distance": not abs(one.details["error"] - near[i]) <= EXACT * size,
            "bad_nearest": not (abs(moved - near[i]) <= EXACT * size and turned <= EXACT),
        }
        if any(bad.values()):
            print(
                f"# {task} {robot.mechanism.name} T={T[i].tolist()!r} {near[i]} {why[i]} {bad} {words}", file=sys.stderr
            )
        for key, value in bad.items():
            count[key] += bool(value)
        count["asked_alone"] += 1
        if i % SEARCHED == 0:
            count["bad_converged"] += bool(solve_ik(robot, T[i], task=task, restarts=7, limits=False).solved)
            count["searched"] += 1
    return count


def scara(rng: np.random.Generator, count: int) -> dict[str, int]:
    """Places that a SCARA arm reaches, some of them beyond its limits, and tilted ones that it cannot."""
    robot = load("cobra600")
    chain = chain_of(robot.mechanism)
    a, b, top = 0.325, 0.275, chain.home[2, 3]
    lower, upper = robot.limits.lower, robot.limits.upper
    q = rng.uniform([-np.pi, -np.pi, -0.3, -np.pi], [np.pi, np.pi, 0.5, np.pi], (count, 4))
    T = np.broadcast_to(np.eye(4), (count, 4, 4)).copy()
    yaw = q[:, 0] + q[:, 1] - q[:, 3]
    x, y = (a * f(q[:, 0]) + b * f(q[:, 0] + q[:, 1]) for f in (np.cos, np.sin))
    T[:, :3, :3] = pose.exp(np.stack([0 * yaw, 0 * yaw, yaw, 0 * yaw, 0 * yaw, 0 * yaw], axis=1))[:, :3, :3]
    T[:, :3, :3] = T[:, :3, :3] @ chain.home[:3, :3]
    T[:, 0, 3], T[:, 1, 3], T[:, 2, 3] = x, y, top - q[:, 2]
    batch = inverse_kinematics(robot, T)
    bend = np.abs((q[:, 1] + np.pi) % TURN - np.pi)
    both = np.stack([q, q], axis=1)
    for k, sign in enumerate((1, -1)):
        both[:, k, 1] = sign * bend
        both[:, k, 0] = np.arctan2(y, x) - np.arctan2(b * np.sin(sign * bend), a + b * np.cos(bend))
        both[:, k, 3] = both[:, k, 0] + both[:, k, 1] - yaw
    both[..., [0, 1]] = (both[..., [0, 1]] + np.pi) % TURN - np.pi
    excess = np.maximum(lower - both, both - upper)
    excess[..., 3] = -np.inf
    worst = excess.max(axis=2)
    least = worst.min(axis=1)
    clear = np.abs(least) > 1e-9
    beyond = least > 0
    wrong = clear & ((batch.status_codes == BEYOND) != beyond)
    result = {"cases": count, "bad_verdict": int(wrong.sum()), "bad_joint": 0, "bad_value": 0, "bad_tilted": 0}
    result["beyond_limits"] = int(beyond.sum())
    for i in range(0, count, ALONE):
        one = inverse_kinematics(robot, T[i])
        if beyond[i] and clear[i]:
            j = robot.joint_names.index(one.details["joint"])
            # Two configurations may be as far beyond, even in the same joint.
            alike = np.flatnonzero(np.abs(worst[i] - least[i]) < 1e-7)
            named = np.abs(excess[i, alike, j] - least[i]) < 1e-7
            result["bad_joint"] += not named.any()
            value = np.abs(one.details["value"] - both[i, alike, j])[named].min(initial=np.inf)
            result["bad_value"] += not (abs(one.details["excess"] - least[i]) < 1e-7 and value < 1e-7)
        tilt = np.concatenate([rng.normal(size=2) * 10 ** rng.uniform(-5, 0), np.zeros(4)])
        no = inverse_kinematics(robot, T[i] @ pose.exp(tilt))
        result["bad_tilted"] += no.status is not IKStatus.NOT_OF_THIS_ARM
    return result


def singular(rng: np.random.Generator, count: int) -> dict[str, int]:
    """Singular configurations of wrist, elbow and shoulder: rank, rates, and an answer without NaN."""
    robot, (a, b, _, _) = elbow_arm(rng, offset=False)
    chain = chain_of(robot.mechanism)
    q = rng.uniform(-np.pi, np.pi, (count, 6))
    at_wrist, at_elbow, at_shoulder = rng.random((3, count)) < 0.6
    q[:, 4] = np.where(at_wrist, rng.integers(0, 2, count) * np.pi, q[:, 4])
    q[:, 2] = np.where(at_elbow, rng.integers(0, 2, count) * np.pi, q[:, 2])
    over = np.arctan2(a + b * np.cos(q[:, 2]), b * np.sin(q[:, 2])) + rng.integers(0, 2, count) * np.pi
    # With the forearm upright and axis 5 parallel to axes 2 and 3, one more direction is lost.
    q[:, 3] = np.where(rng.random(count) < 0.3, rng.integers(0, 2, count) * np.pi, q[:, 3])
    q[:, 1] = np.where(at_shoulder, over, q[:, 1])
    V = rng.normal(size=(count, 6))
    rates = bounded_rates(robot, q, V)
    values = np.linalg.svd(jacobian(chain, q), compute_uv=False)
    relative = values / values[:, :1]
    clear = ((relative < 1e-12) | (relative > 1e-5)).all(axis=1)
    rank = (relative > 1e-8).sum(axis=1)
    most = np.linalg.norm(V, axis=1) * (1 / 0.05) * (1 + 1e-9)
    result = {"cases": count, "bad_rank": int((clear & (rank != rates.rank)).sum())}
    result |= {f"rank_{k}": int((clear & (rank == k)).sum()) for k in range(3, 7)}
    result["bad_rates"] = int((~(np.linalg.norm(rates.qd, axis=1) <= most)).sum())
    some = slice(0, count, ALONE)
    T = robot.forward_kinematics(q[some])
    answer = inverse_kinematics(robot, T)
    reached = np.abs(robot.forward_kinematics(np.nan_to_num(answer.q)) - T[:, None]).max(axis=(2, 3))
    result["bad_wrong"] = int((answer.valid & ~(reached <= 1e-8)).sum())
    result["bad_nan"] = int((answer.valid[..., None] & ~np.isfinite(answer.q)).sum())
    result["bad_unsolved"] = int((~answer.valid.any(axis=1)).sum())
    planted = np.zeros((count, 6))
    planted[:, 3], planted[:, 5] = 1.0, -np.cos(q[:, 4])
    still = (robot.jacobian_body(q) @ planted[..., None])[..., 0]
    result["bad_null"] = int((at_wrist & ~(np.abs(still).max(axis=1) < 1e-9)).sum())
    return result


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "cases", 100_000, 100_000)
    sys.exit(not figures.run("R7", options, work)["passed"])
