"""Elbow up or down, shoulder left or right, wrist flipped: where they are, seen from outside, on every arm.

Nothing of the closed forms is used: places and directions of joint axes come from the Jacobian.
"""

from __future__ import annotations

from collections import Counter
from itertools import product

import numpy as np
import pytest

import mafsil as mf
from mafsil.ik import inverse_kinematics
from tests.sizes import few, size

# Joints, counted from one: of the shoulder, the elbow, and the two of the wrist whose axes meet or whose first counts.
ELBOWS = {
    **dict.fromkeys(("elbow6r", "generalized_puma", "offset_puma", "puma560", "rv7flm"), (2, 3, 4, 5)),
    **dict.fromkeys(("ur3e", "ur5", "ur5e", "ur10e"), (2, 3, 4, 4)),
    **dict.fromkeys(("panda", "fr3", "iiwa7"), (2, 4, 5, 6)),
    "arm6r": (3, 4, 5, 5),
}
OFFSETS = ("generalized_puma", "offset_puma", "puma560", "ur3e", "ur5", "ur5e", "ur10e")
TURNED = {"upright": np.eye(3), "mirrored": np.diag([1.0, -1.0, 1.0]), "hung": np.diag([1.0, -1.0, -1.0])}
CLEAR = 0.02
"""Heights and ways beside a line, in metres, from which on they are judged."""


def axes_at(robot, q):
    """(n, 3) directions and (n, 3) points of the joint axes."""
    J = robot.jacobian_space(q)
    return J[:3].T, np.cross(J[:3].T, J[3:].T)


def meeting(w1, p1, w2, p2):
    """The point of two lines that is nearest to both."""
    t = np.linalg.lstsq(np.stack([w1, -w2], axis=1), p2 - p1, rcond=None)[0]
    return (p1 + t[0] * w1 + p2 + t[1] * w2) / 2


def places(robot, q, joints):
    """Shoulder, elbow and wrist, in one plane where the axes of shoulder and elbow are parallel."""
    w, p = axes_at(robot, q)
    a, b, c, d = (k - 1 for k in joints)
    S = meeting(w[0], p[0], w[1], p[1]) if a == 1 and robot.n == 7 else p[a]
    E = p[b] + w[b] * (w[b] @ (S - p[b]))
    W = p[c] if c == d else meeting(w[c], p[c], w[d], p[d])
    if np.abs(np.cross(w[a], w[b])).max() < 1e-9:
        W = W + w[a] * (w[a] @ (S - W))
    return S, E, W, w, p


def upright(w):
    return w if w[2] >= -1e-9 else -w


def counted(robot, joints, rng, offset=False, poses=25):
    """How often a name is right, wrong, or not judged."""
    low, high = np.clip(robot.limits.lower, -3.0, 3.0), np.clip(robot.limits.upper, -3.0, 3.0)
    seen = Counter()
    for q in rng.uniform(low, high, (poses, robot.n)):
        answer = inverse_kinematics(robot, robot.forward_kinematics(q))
        for solution, branch in zip(answer.q, answer.branches, strict=True):
            S, E, W, w, p = places(robot, solution, joints)
            up, line = upright(w[0]), W - S
            off = E - S - line * ((E - S) @ line) / (line @ line)
            ahead, leans = w[1], False
            if joints[0] == 2 and robot.n == 6:
                # In a plane through the first axis: what is ahead is on the side of the wrist's centre.
                centre = meeting(w[4], p[4], w[5], p[5]) - p[0]
                ahead = np.cross(w[1], up)
                ahead = ahead * np.sign(ahead @ centre)
                leans = ahead @ line < CLEAR
                if offset and abs(ahead @ centre) > CLEAR:
                    # The upper arm is beside the first axis as far as the wrist's centre is, to the viewer's right:
                    seen[
                        "shoulder", ((w[1] @ centre) * (w[1] @ np.cross(ahead, up)) > 0) == (branch.shoulder == "right")
                    ] += 1
            if abs(off @ up) > CLEAR:
                # Where the line to the wrist leans back over the shoulder, the names keep what they were before it did.
                assert branch.elbow in ("up", "down")
                seen["leaning" if leans else "elbow", (off @ up > 0) == (branch.elbow == "up")] += 1
            if branch.wrist:
                a, b, c = w[-3:]
                seen["wrist", (b @ np.cross(a, c) > 0) == (branch.wrist == "noflip")] += 1
    return seen


def turned(robot, M, rng=None):
    """The arm mirrored or turned by M, with joint axes that turn as before; moved where a generator is given."""
    S = robot.jacobian_space(np.zeros(robot.n)).T
    w, p = S[:, :3], np.cross(S[:, :3], S[:, 3:])
    shift = np.zeros(3) if rng is None else rng.normal(size=3)
    w, p = np.linalg.det(M) * w @ M.T, p @ M.T + shift
    home = robot.forward_kinematics(np.zeros(robot.n)).copy()
    home[:3, 3] = M @ home[:3, 3] + shift
    home[:3, :3] = M @ home[:3, :3] @ np.diag([1.0, np.linalg.det(M), 1.0])
    return mf.Robot.from_screws(np.concatenate([w, np.cross(p, w)], axis=1), home)


def right(seen):
    wrong = {key: count for key, count in seen.items() if not key[1] and key[0] != "leaning"}
    assert not wrong, seen
    assert seen["elbow", True] > 20
    return seen


@pytest.mark.parametrize(("name", "place"), few(product(ELBOWS, [*TURNED, "moved"]), 20))
def test_the_names_of_library_arms_follow_geometry(name, place):
    rng = np.random.default_rng(5)
    robot = mf.load(name)
    if place == "moved":
        robot = turned(robot, tilt(rng), rng)
    elif place != "upright":
        robot = turned(robot, TURNED[place])
    seen = right(counted(robot, ELBOWS[name], rng, offset=name in OFFSETS))
    assert (seen["shoulder", True] > 20) == (name in OFFSETS)


def tilt(rng):
    """A rotation that leaves what is up up."""
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    R = R * np.linalg.det(R)
    return R if R[2, 2] > 0.2 else np.diag([1.0, -1.0, -1.0]) @ R if R[2, 2] < -0.2 else tilt(rng)


@pytest.mark.parametrize("seed", range(size(3, 8)))
def test_the_names_of_arms_that_nobody_listed_follow_geometry(seed):
    """Arms of a first axis across an elbow's plane, with any offsets, senses and wrist; and such with seven joints."""
    rng = np.random.default_rng(seed)
    signs, R = rng.choice([-1.0, 1.0], 7), np.linalg.qr(rng.normal(size=(3, 3)))[0]
    x, y, z = np.eye(3)
    a, b, lift, aside, reach = rng.uniform(0.3, 0.8), rng.uniform(0.3, 0.8), *rng.uniform(-0.3, 0.3, 3)
    wrist = np.array([a + b, aside, lift])
    if seed % 2:
        axes, points = [z, y, y, x, y, x], [0 * x, reach * x + lift * z, [a + reach, 0, lift], *[wrist + reach * x] * 3]
        joints = (2, 3, 4, 5)
    else:
        S, E = lift * z, lift * z + a * x
        axes, points = [z, y, x, y, x, y, x], [S, S, S, E + 0.1 * aside * z, wrist * [1, 0, 1], wrist * [1, 0, 1]]
        points.append(points[-1] + rng.choice([0.0, 0.08]) * z)
        joints = (2, 4, 5, 6)
    w = np.array(axes) * signs[: len(axes), None]
    home = np.eye(4)
    home[:3, 3] = [a + b + 0.1, aside, lift]
    arm = mf.Robot.from_screws(np.concatenate([w, np.cross(np.array(points, dtype=float), w)], axis=1), home)
    right(counted(arm, joints, rng))
    right(counted(turned(arm, R * np.linalg.det(R), rng), joints, rng))
