"""What does a rigid surface cost beside a wall so stiff that the motion is as near to the rigid one, in the same run?

python benchmarks/rigid_contact.py [--duration 0.3] [--json FILE]

A planar arm is pressed against a plane with 30 N and slides along it: `RigidPlant` at steps of 1 ms beside `Plant` with
a critically damped `Wall`, whose step follows from its stiffness. The table says how far each wall's motion is from the
rigid one, and how far the rigid one is from itself at a tenth of the step: that is its own error.
"""

from __future__ import annotations

import argparse
import json
import sys
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402

from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil.arrays import Floats, JointVector  # noqa: E402
from mafsil.control import Law, Wall  # noqa: E402
from mafsil.robot import load  # noqa: E402
from mafsil.simulation import Plant, Recording, RigidPlant, RigidSurface, Scenario, simulate  # noqa: E402
from mafsil.trajectory import Motion  # noqa: E402
from mafsil.trajectory.profiles import rest  # noqa: E402

START, NORMAL, PUSH = np.array([0.4, 0.9]), np.array([0.6, -0.8, 0.0]), 30.0
STEP = 1e-3
WALLS = {1e4: 2.5e-4, 1e5: 1e-4, 1e6: 2.5e-5}
"""Stiffness [N/m] -> a step that resolves it [s]."""


class Constant:
    """The same efforts all the time."""

    def __init__(self, efforts: Floats) -> None:
        self.efforts = efforts

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        return self.efforts

    def session(self, period: float) -> Law:
        return self


def main() -> None:
    arguments = _arguments()
    robot = load("planar2r_point_masses")
    T = robot.forward_kinematics(START)
    point, J = T[:3, 3] - 0.02 * NORMAL, T[:3, :3] @ robot.jacobian_body(START)[3:]
    law = Constant(robot.gravity_torque(START) - PUSH * J.T @ NORMAL)

    def run(plant: Plant, step: float) -> Recording:
        scenario = Scenario(
            robot=robot, trajectory=rest(START, arguments.duration), qd=[0.3, 0.0], law=law, plant=plant, step=step,
            period=STEP, integrator="rk4", saturate=False,
        )  # fmt: skip
        return simulate(scenario, fused=False)

    rigid = RigidPlant(robot, friction=False, surface=RigidSurface.plane(point, NORMAL))
    tasks = {"rigid": partial(run, rigid, STEP)}
    fine = run(rigid, STEP / 10.0).q
    errors: dict[str, float] = {}
    for stiffness, step in WALLS.items():
        wall = Wall(point, NORMAL, stiffness, damping=2.0 * np.sqrt(stiffness))
        tasks[f"wall {stiffness:.0e}"] = partial(run, Plant(robot, friction=False, environment=wall), step)
    for name, task in tasks.items():
        errors[name] = float(np.abs(task().q - fine).max())
    timings = race(tasks, repeats=5)
    report = {
        name: {"error": errors[name], "seconds": timing.median, "ratio": timing.median / timings["rigid"].median}
        for name, timing in timings.items()
    }
    print(json.dumps(machine("numpy"), indent=1))
    for name, row in report.items():
        print(
            f"{name:12} {1e3 * row['seconds']:9.1f} ms   {row['ratio']:6.2f} times rigid   {row['error']:.1e} rad apart"
        )
    if arguments.json:
        arguments.json.write_text(json.dumps({"machine": machine("numpy"), "report": report}, indent=1))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--duration", type=float, default=0.3, help="of the motion [s]")
    parser.add_argument("--json", type=Path)
    return parser.parse_args()


if __name__ == "__main__":
    main()
