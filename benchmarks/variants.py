"""A thousand variants of an arm under computed torque, beside MuJoCo doing the same, in the same run.

python benchmarks/variants.py [--robot panda] [--seconds 5] [--runs 1000] [--json FILE]

Each variant has its own payload, masses, gains and start; 1 ms steps, semi-implicit Euler, efforts clipped, a quintic
reference. Ours: `mafsil.simulation.monte_carlo`, with drawing, references, loop, recordings and their statistics. The
rival: MuJoCo's mj_step1 and mj_step2 with the masses of each variant written into its model, the law by mj_mulM and the
bias of a second model without payload (the law does not know the variant), no contacts; nothing is recorded. A few of
his runs are timed and extended; the final states of one variant are compared, so that the same motion is timed.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from time import perf_counter
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import mujoco  # noqa: E402
import numpy as np  # noqa: E402

from benchmarks.stopwatch import machine  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.control import computed_torque  # noqa: E402
from mafsil.robot import Robot, load  # noqa: E402
from mafsil.simulation import Normal, Plant, Scenario, Variants, Variation, monte_carlo  # noqa: E402
from mafsil.trajectory import Motion, quintic  # noqa: E402
from tests.oracles.mujoco_model import model_of  # noqa: E402

STEP, FREQUENCY = 1e-3, 20.0
TARGETS = {1: 8.0, 100: 80.0, 1000: 80.0}
"""Ratios that the project asks for: a single run, a hundred at once, a thousand."""
HIS_RUNS = 3
VARIATION = Variation(
    payload=(0.0, 3.0), payload_offset=(-0.05, 0.05), inertia=(0.9, 1.1), gains=(0.8, 1.2), start=Normal(0.0, 0.01)
)


class Rival:
    """MuJoCo with the true arm of one variant, and the model of the law."""

    def __init__(self, robot: Robot, variants: Variants, k: int):
        assert variants.inertia is not None
        assert variants.payload is not None
        assert variants.payload_offset is not None
        plant = Plant(robot).with_scaled_inertia(variants.inertia[k])
        plant = plant.with_payload(variants.payload[k], com=variants.payload_offset[k], inertia=np.zeros((3, 3)))
        self.plant, self.believed = (_model(arm) for arm in (plant.robot, robot))
        self.limit = robot.limits.effort

    def run(self, start: Floats, gain: float, reference: Motion) -> Floats:
        """(n,) where it ends."""
        (model, data), (law, state) = ((m, mujoco.MjData(m)) for m in (self.plant, self.believed))
        data.qpos[:] = start
        kp, kd, product = gain * FREQUENCY**2, gain * 2 * FREQUENCY, np.empty(model.nv)
        for u, v, a in zip(*reference, strict=True):
            mujoco.mj_step1(model, data)
            state.qpos[:], state.qvel[:] = data.qpos, data.qvel
            mujoco.mj_fwdPosition(law, state)
            mujoco.mj_fwdVelocity(law, state)
            mujoco.mj_mulM(law, state, product, a + kp * (u - data.qpos) + kd * (v - data.qvel))
            data.qfrc_applied[:] = (product + state.qfrc_bias).clip(-self.limit, self.limit)
            mujoco.mj_step2(model, data)
        return data.qpos.copy()


def _model(robot: Robot) -> Any:
    model: Any = model_of(robot.mechanism)
    model.opt.timestep = STEP
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    return model


def main() -> None:
    """Print the ratios."""
    arguments = _arguments()
    robot, steps = load(arguments.robot), round(arguments.seconds / STEP)
    limits = robot.limits
    middle = (limits.lower + limits.upper) / 2
    trajectory = quintic(middle, middle + 0.2 * (limits.upper - middle), arguments.seconds)
    law = computed_torque(robot, natural_frequency=FREQUENCY)
    scenario = Scenario(robot=robot, trajectory=trajectory, law=law, plant=Plant(robot, friction=False), step=STEP)
    monte_carlo(scenario, VARIATION, 1)
    few = monte_carlo(scenario, VARIATION, HIS_RUNS)
    reference = trajectory.at(STEP * np.arange(steps))
    his, gap = np.inf, 0.0
    for k in range(HIS_RUNS):
        variants = few.variants
        assert variants.start is not None
        assert variants.gains is not None
        rival = Rival(robot, variants, k)
        begun = perf_counter()
        there = rival.run(middle + variants.start[k], float(variants.gains[k]), reference)
        his = min(his, (perf_counter() - begun) / steps)
        gap = max(gap, float(np.abs(there - few.again(k).q[-1]).max()))
    ours: dict[int, float] = {}
    for runs in (1, 100, arguments.runs):
        best = np.inf
        for _ in range(20 if runs <= 100 else 5):
            begun = perf_counter()
            monte_carlo(scenario, VARIATION, runs)
            best = min(best, (perf_counter() - begun) / steps / runs)
        ours[runs] = best
    details = machine("numpy", "mujoco-core")
    print(", ".join(f"{key} {value}" for key, value in details.items()))
    print(f"{arguments.seconds:g} s at {1 / STEP:g} Hz; final states differ by {gap:.1e}")
    print(f"mujoco {1e6 * his:.2f} us a step: {his * steps * arguments.runs:.0f} s for {arguments.runs} runs")
    for runs, mean in ours.items():
        target = TARGETS.get(runs)
        note = "" if target is None else f" (target {target:g})"
        print(f"mafsil, {runs} runs: {1e6 * mean:.3f} us a step, {mean * steps * runs:.2f} s, "
              f"{his / mean:.1f} times as fast{note}")  # fmt: skip
    if arguments.json:
        figures = {"mujoco": his, "mafsil": ours, "gap": gap}
        Path(arguments.json).write_text(json.dumps({"machine": details, "seconds a step": figures}, indent=2))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--json")
    return parser.parse_args()


if __name__ == "__main__":
    main()
