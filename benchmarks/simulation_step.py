"""What does a step of a closed loop cost beside MuJoCo with computed torque in NumPy, in the same run?

python benchmarks/simulation_step.py [--robot panda] [--steps 1000] [--batch 100 500] [--json FILE]

Seven joints, 1 ms steps, a quintic reference, semi-implicit Euler, efforts clipped. The rival: MuJoCo's mj_step1 and
mj_step2 with its own mass matrix (mj_mulM) and bias in the law, no contacts, the reference evaluated beforehand. Ours
is the whole `simulate`: planning the references, the loop, the recording of every step with accelerations and tip
errors; the rival records nothing. Large batches write so much that the memory decides. The final states of both are
compared, so that the same motion is timed.
"""

from __future__ import annotations

import argparse
import json
import sys
from functools import partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import mujoco  # noqa: E402
import numpy as np  # noqa: E402

from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.control import computed_torque  # noqa: E402
from mafsil.robot import Robot, load  # noqa: E402
from mafsil.simulation import Plant, Scenario, simulate  # noqa: E402
from mafsil.trajectory import Motion, quintic  # noqa: E402
from mafsil.trajectory.splines import PiecewisePolynomial  # noqa: E402
from tests.oracles.mujoco_model import model_of  # noqa: E402

STEP, FREQUENCY = 1e-3, 20.0
SINGLE_TARGET, BATCH_TARGET = 8.0, 80.0
"""Ratios of DESIGN.md section 7, for fused loops."""


class Rival:
    """MuJoCo, computed torque in Python."""

    def __init__(self, robot: Robot) -> None:
        self.model: Any = model_of(robot.mechanism)
        self.model.opt.timestep = STEP
        self.model.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
        self.data = mujoco.MjData(self.model)
        self.limit = robot.limits.effort

    def run(self, start: Floats, reference: Motion) -> tuple[Floats, Floats]:
        model, data = self.model, self.data
        mujoco.mj_resetData(model, data)
        data.qpos[:] = start
        kp, kd, product = FREQUENCY**2, 2 * FREQUENCY, np.empty(model.nv)
        for u, v, a in zip(*reference, strict=True):
            mujoco.mj_step1(model, data)
            mujoco.mj_mulM(model, data, product, a + kp * (u - data.qpos) + kd * (v - data.qvel))
            data.qfrc_applied[:] = (product + data.qfrc_bias).clip(-self.limit, self.limit)
            mujoco.mj_step2(model, data)
        return data.qpos.copy(), data.qvel.copy()


def main() -> None:
    arguments = _arguments()
    robot, count = load(arguments.robot), arguments.steps
    limits = robot.limits
    middle = (limits.lower + limits.upper) / 2
    goal = middle + 0.2 * (limits.upper - middle)
    trajectory = quintic(middle, goal, count * STEP)
    scenario = _scenario(robot, trajectory, middle + 0.02)
    crowds = {size: _scenario(robot, trajectory, _starts(middle, size)) for size in arguments.batch}
    rival = Rival(robot)
    reference = trajectory.at(STEP * np.arange(count))
    there, rate = rival.run(middle + 0.02, reference)
    ours = simulate(scenario, fused=True)
    gap = max(np.abs(there - ours.q[-1]).max(), np.abs(rate - ours.qd[-1]).max())
    times = race(
        {
            "mafsil": lambda: simulate(scenario, fused=True),
            "mafsil step by step": lambda: simulate(scenario, fused=False),
            "mujoco": lambda: rival.run(middle + 0.02, reference),
        }
        | {f"mafsil {size}": partial(simulate, crowd, fused=True) for size, crowd in crowds.items()},
        repeats=60,
        seconds=0.002,
    )
    single, his = times["mafsil"].least / count, times["mujoco"].least / count
    many = {size: times[f"mafsil {size}"].least / count / size for size in crowds}
    details = machine("numpy", "mujoco-core")
    print(", ".join(f"{key} {value}" for key, value in details.items()))
    print(f"final states differ by {gap:.1e}")
    print(f"mujoco {his * 1e6:.2f} us a step")
    print(f"mafsil {single * 1e6:.2f} us a step, {his / single:.2f} times as fast (a fused loop: {SINGLE_TARGET:g})")
    for size, mean in many.items():
        print(f"mafsil, {size} at once {mean * 1e6:.3f} us, {his / mean:.1f} times (target {BATCH_TARGET:g})")
    if arguments.json:
        figures = {"mujoco": his, "mafsil": single, "mafsil batch": many, "gap": float(gap)}
        Path(arguments.json).write_text(json.dumps({"machine": details, "seconds a step": figures}, indent=2))


def _scenario(robot: Robot, trajectory: PiecewisePolynomial, start: Floats) -> Scenario:
    law = computed_torque(robot, natural_frequency=FREQUENCY)
    return Scenario(robot=robot, trajectory=trajectory, law=law, plant=Plant(robot, friction=False), q=start, step=STEP)


def _starts(middle: Floats, size: int) -> Floats:
    return middle + 0.02 * np.random.default_rng(0).normal(size=(size, len(middle)))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--batch", type=int, nargs="+", default=[100, 500])
    parser.add_argument("--json")
    return parser.parse_args()


if __name__ == "__main__":
    main()
