"""What does a tick of model-predictive control cost, beside DAQP on the same programs, in the same run?

python benchmarks/predictive_control.py [--robot panda] [--horizon 10 20] [--json FILE]

Seven joints, intervals of 5 ms. Ours is the public call: from a state to the first efforts, dynamics included. The
rival is handed the Hessian in all efforts of all intervals and its gradient, built beforehand; building them is shown
apart. Errors from a hundredth of a radian to half of one: none to most of the efforts are at their limits. The efforts
of both are compared. Then a run of the law against the clock at 1 kHz from a start that is far off.
"""

from __future__ import annotations

import argparse
import json
import sys
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import daqp  # noqa: E402
import numpy as np  # noqa: E402

from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.control import model_predictive  # noqa: E402
from mafsil.control.laws import ModelPredictive  # noqa: E402
from mafsil.robot import Robot, load  # noqa: E402
from mafsil.simulation import Deadlines, Plant, Scenario, simulate  # noqa: E402
from mafsil.trajectory import Motion, quintic  # noqa: E402

INTERVAL, STIFFNESS = 5e-3, 80.0
SIZES = (0.01, 0.03, 0.1, 0.2, 0.5)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--horizon", type=int, nargs="+", default=[10, 20])
    parser.add_argument("--json")
    arguments = parser.parse_args()
    robot = load(arguments.robot)
    print(", ".join(f"{key} {value}" for key, value in machine("numpy", "daqp").items()))
    found = {horizon: _horizon(robot, horizon) for horizon in arguments.horizon}
    if arguments.json:
        Path(arguments.json).write_text(json.dumps({"machine": machine("numpy", "daqp"), "rows": found}, indent=2))


def _law(robot: Robot, horizon: int) -> ModelPredictive:
    w = STIFFNESS
    return model_predictive(
        robot, horizon=horizon, interval=INTERVAL, position=w**4, rate=2 * w**2, acceleration=1.0
    )  # fmt: skip


def _rival(H: Floats, g: Floats, bound: Floats) -> Floats:
    return daqp.solve(H, g, np.zeros((0, len(g))), bound.copy(), -bound, np.zeros(len(g), np.intc))[0]


def _horizon(robot: Robot, horizon: int) -> list[dict[str, float]]:
    law, rng, rows = _law(robot, horizon), np.random.default_rng(0), []
    n, middle = robot.n, (robot.limits.lower + robot.limits.upper) / 2
    for size in SIZES:
        q, qd = middle + 0.3 * rng.normal(size=n), 0.3 * rng.normal(size=n)
        reference = Motion(q + size * rng.uniform(-1, 1, n), np.zeros(n), np.zeros(n))

        def program(q=q, qd=qd, reference=reference):
            M, known = robot.mass_matrix(q), robot.inverse_dynamics(q, qd, reference.a)
            errors = np.stack([reference.u - q, reference.v - qd], axis=-1)
            W = np.linalg.inv(M)
            H = np.einsum("ja,jkl,jb->kalb", W, law.hessian, W).reshape(horizon * n, horizon * n)
            gradient = (law.slope @ errors[..., None])[..., 0] - law.hessian.sum(axis=-1) * (W @ known)[:, None]
            return H, (W.T @ gradient).T.reshape(-1)

        H, g = program()
        times = race(
            {
                "ours": lambda q=q, qd=qd, r=reference: law(0.0, q, qd, r),
                "daqp": partial(_rival, H, g, np.tile(law.limit, horizon)),
                "building": program,
            },
            repeats=15,
            seconds=0.003,
        )
        x = _rival(H, g, np.tile(law.limit, horizon))
        plan = law.plan(q, qd, reference)
        row = {name: timing.least for name, timing in times.items()}
        row |= {"held": int((np.abs(plan) == law.limit).sum()), "gap": float(np.abs(plan.reshape(-1) - x).max())}
        rows.append(row)
        held, (ours, his, built) = row["held"], (1e6 * row[name] for name in ("ours", "daqp", "building"))
        print(
            f"horizon {horizon}, {held} of {n * horizon} efforts at their limits: {ours:.1f} us, DAQP {his:.0f} us, "
            f"{his / ours:.1f} times as long, and {built:.0f} us to build it; efforts differ by {row['gap']:.0e}"
        )
    path = quintic(middle, middle + 0.1, 0.5)
    far = Scenario(robot=robot, trajectory=path, law=law, plant=Plant(robot, friction=False), q=middle + 0.3)
    run = simulate(far, clock="real")
    timed = Deadlines.of(run.metadata)
    print(f"horizon {horizon}, 0.3 rad off at the start: {run.explain('en')}")
    assert timed is not None
    return rows


if __name__ == "__main__":
    main()
