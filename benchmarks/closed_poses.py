"""How quick is inverse kinematics of mechanisms with loops, beside SciPy's least squares from the same starts?

python benchmarks/closed_poses.py [--poses 20] [--peer 3] [--json FILE]

`closed_inverse_kinematics` gets poses that a random closed configuration really has; it must find that configuration.
The peer is `scipy.optimize.least_squares` (lm, with our derivatives) from each of the same starts. Planning beside it:
`mf.plan` of the platform round a ball, whole call; no peer plans with closed loops from Python.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import warnings
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
os.environ.setdefault("MAFSIL_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402
from scipy.optimize import least_squares  # noqa: E402

import mafsil as mf  # noqa: E402
from benchmarks.comparison import Comparisons  # noqa: E402
from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil.arrays import Floats, PoseMatrix  # noqa: E402
from mafsil.collision import Checker, Obstacle, Sphere  # noqa: E402
from mafsil.parallel import ClosedChain, closed_inverse_kinematics, closed_poses  # noqa: E402

ROBOTS = ROOT / "examples" / "robots"


def by_scipy(chain: ClosedChain, T: PoseMatrix, starts: Floats) -> Floats:
    """(k, n) configurations that least squares ends at with loops and pose met, of each start."""

    def residual(q: Floats) -> Floats:
        return closed_poses._equations(chain, T, q[None], "pose")[0][0]

    def slope(q: Floats) -> Floats:
        return closed_poses._equations(chain, T, q[None], "pose")[1][0]

    found = [least_squares(residual, start, jac=slope, method="lm", xtol=1e-14, ftol=1e-14) for start in starts]
    return np.array([each.x for each in found if np.abs(each.fun).max() < 1e-9]).reshape(-1, chain.n)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--poses", type=int, default=20)
    parser.add_argument("--peer", type=int, default=3)
    parser.add_argument("--json")
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    print(machine("numpy", "scipy"))
    found, rng = Comparisons(), np.random.default_rng(0)
    for name, tip in (("palletiser", "forearm"), ("stewart", "platform")):
        chain = ClosedChain(mf.load(ROBOTS / f"{name}.xml", tip=tip))
        planted = chain.close_loops(0.12 * rng.normal(size=(given.poses, chain.n)))
        poses = chain.robot.forward_kinematics(planted.q)
        answers = [closed_inverse_kinematics(chain, T) for T in poses]
        hit = [np.abs(a.q - q).max(axis=1).min(initial=np.inf) < 1e-6 for a, q in zip(answers, planted.q, strict=True)]
        starts = [closed_poses.search_starts(chain, T, closed_poses.middle(chain), "pose", 48, 0) for T in poses]
        peers = [by_scipy(chain, T, s) for T, s in zip(poses[: given.peer], starts, strict=False)]
        theirs_hit = [
            len(p) > 0 and np.abs(p - q).max(axis=1).min() < 1e-6 for p, q in zip(peers, planted.q, strict=False)
        ]
        times = race(
            {
                "ours": partial(closed_inverse_kinematics, chain, poses[0]),
                "scipy": partial(by_scipy, chain, poses[0], starts[0]),
            },
            repeats=5,
        )
        ours, theirs = (times[key].least * 1e6 for key in ("ours", "scipy"))
        found.add("closed_inverse_kinematics(chain, T)", name, ours, "scipy least_squares, same starts", theirs)
        print(f"{name:11} n={chain.n:2} {len(starts[0]):3} starts {ours / 1e3:8.2f} ms, ", end="")
        print(f"SciPy {theirs / 1e3:9.2f} ms ({theirs / ours:5.1f}x); planted found {sum(hit)} of {len(hit)}, ", end="")
        print(f"SciPy {sum(theirs_hit)} of {len(theirs_hit)}")
    platform = mf.load(ROBOTS / "stewart.xml", tip="platform")
    chain, T = ClosedChain(platform), platform.forward_kinematics(np.zeros(platform.n))
    ends: list[Floats] = []
    for x in (-0.12, 0.12):
        moved = T.copy()
        moved[:3, 3] += [x, 0, 0.02]
        ends.append(closed_inverse_kinematics(chain, moved).q[0])
    checker = Checker(platform, [Obstacle(Sphere(0.06), (0.0, 0.0, 0.699), "ball")], self_collision=False)
    taken = race({"plan": lambda: mf.plan(checker, None, *ends, seed=2)}, repeats=5)["plan"].least
    print(f"mf.plan of the platform round a ball: {taken * 1e3:.1f} ms")
    if given.json:
        Path(given.json).write_text(json.dumps(found.plain(), indent=1), "utf-8")


if __name__ == "__main__":
    main()
