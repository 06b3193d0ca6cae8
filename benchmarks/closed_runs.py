"""A palletiser with a loop, driven for a second at 1 kHz: ours with loops closed to rounding, MuJoCo with soft ones.

    python benchmarks/closed_runs.py

Same mechanism, same trajectory and gains, semi-implicit Euler in both; the minimum of several runs.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from time import perf_counter

import mujoco
import numpy as np

import mafsil as mf
from mafsil.control import closed_gravity_compensation, driven_trajectory
from mafsil.parallel import ClosedChain
from mafsil.simulation import Scenario, simulate
from mafsil.trajectory import quintic

FILE = Path(__file__).resolve().parents[1] / "examples" / "robots" / "palletiser.xml"
REPEATS, TICKS, KP, KD = 5, 1000, 2000.0, 120.0


def least(run) -> float:
    """Shortest of several runs [s]."""
    times = []
    for _ in range(REPEATS):
        begin = perf_counter()
        run()
        times.append(perf_counter() - begin)
    return min(times)


def main() -> None:
    """Print both times, their ratio, and how far the loops gape."""
    warnings.simplefilter("ignore")
    robot = mf.load(str(FILE), tip="forearm")
    chain = ClosedChain(robot)
    start = chain.closed(np.zeros(4), hold=["shoulder", "lever"]).q
    motion = driven_trajectory(chain, quintic([0, 0], [0.7, 0.4], TICKS * 1e-3), start)
    law = closed_gravity_compensation(chain, KP, KD)
    scenario = Scenario(robot=robot, trajectory=motion, law=law, integrator="semi_implicit_euler", saturate=False)
    gap = chain.error(simulate(scenario).q).max()
    ours = least(lambda: simulate(scenario))

    model = mujoco.MjModel.from_xml_path(str(FILE))
    model.opt.timestep = 1e-3
    data = mujoco.MjData(model)
    driven = [model.joint(name).qposadr[0] for name in ("shoulder", "lever")]
    reference = motion.driven.at(np.arange(TICKS) * 1e-3)
    worst = [0.0]

    def theirs() -> None:
        mujoco.mj_resetData(model, data)
        for k in range(TICKS):
            data.ctrl[:] = KP * (reference.u[k] - data.qpos[driven]) + KD * (reference.v[k] - data.qvel[driven])
            mujoco.mj_step(model, data)
            worst[0] = max(worst[0], float(np.abs(data.efc_pos[: data.ne]).max(initial=0.0)))

    other = least(theirs)
    print(f"mafsil  {1e6 * ours / TICKS:8.1f} us a tick, loops gape by {gap:.1e}")
    print(f"MuJoCo  {1e6 * other / TICKS:8.1f} us a tick, loops gape by {worst[0]:.1e}")
    print(f"ratio   {other / ours:8.3f}")


if __name__ == "__main__":
    main()
