"""Closed chains driven at 1 kHz: ours with loops closed to rounding, MuJoCo's equality constraints with soft ones.

    python benchmarks/closed_runs.py

Same mechanism, same trajectory and gains, semi-implicit Euler in both, all in one process; the minimum of several runs.
Ours is `simulate(scenario, fused=True)` as a whole: reference, loop, tip errors, recording; `batch` the same for runs
side by side from different starts, per run and tick on all cores; `steps` one tick at a time in Python, and `own law`
the same with the two lines of NumPy of MuJoCo's loop as a law. MuJoCo's loop
writes its feedback with two lines of NumPy (`mj_step` alone stands beside), and holds the mechanism up by itself:
`qfrc_applied = qfrc_bias` is left out, which saves it time.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from time import perf_counter

import mujoco
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import mafsil as mf  # noqa: E402
from mafsil.control import closed_gravity_compensation  # noqa: E402
from mafsil.control.laws import driven_trajectory  # noqa: E402
from mafsil.model import mjcf  # noqa: E402
from mafsil.parallel import ClosedChain  # noqa: E402
from mafsil.simulation import Scenario, simulate  # noqa: E402
from mafsil.trajectory import quintic  # noqa: E402
from tests.parallel.closed_chains import four_bar, hexapod  # noqa: E402

FILE = ROOT / "examples" / "robots" / "palletiser.xml"
REPEATS, TICKS, ROWS, KP, KD = 5, 1000, 64, 2000.0, 120.0


def least(run) -> float:
    """Shortest of several runs [s]."""
    times = []
    for _ in range(REPEATS):
        begin = perf_counter()
        run()
        times.append(perf_counter() - begin)
    return min(times)


class Springs:
    """The feedback that MuJoCo's loop writes, as somebody's own law."""

    def __init__(self, chain) -> None:
        self.driven, self.n = chain.actuated, chain.n

    def __call__(self, t, q, qd, reference):
        effort, a = np.zeros(self.n), self.driven
        error, rate = reference.u[a] - q[a], reference.v[a] - qd[a]
        effort[a] = KP * error + KD * rate
        return effort

    def session(self, period):
        return self


def compare(name, robot, near, away, text) -> None:
    """One mechanism, driven `away` from where it is closed near some coordinates."""
    chain = ClosedChain(robot)
    start = chain.close_loops(near, hold=chain.actuated).q
    here = start[chain.actuated]
    motion = driven_trajectory(chain, quintic(here, here + away, TICKS * 1e-3), start)
    law = closed_gravity_compensation(chain, KP, KD)
    settings = {"robot": robot, "trajectory": motion, "law": law, "integrator": "semi_implicit_euler"}
    scenario = Scenario(**settings, saturate=False)
    beside = np.random.default_rng(0).uniform(-0.02, 0.02, (ROWS, chain.n))
    many = Scenario(**settings, saturate=False, q=chain.close_loops(start + beside).q, qd=np.zeros(chain.n))
    gap = chain.error(simulate(scenario, fused=True).q).max()
    ours = least(lambda: simulate(scenario, fused=True)) / TICKS
    batch = least(lambda: simulate(many, fused=True)) / TICKS / ROWS
    steps = least(lambda: simulate(scenario, fused=False)) / TICKS
    by_own_law = Scenario(**settings | {"law": Springs(chain)}, saturate=False)
    own = least(lambda: simulate(by_own_law, fused=False)) / TICKS

    model = mujoco.MjModel.from_xml_string(text)
    model.opt.timestep = 1e-3
    data = mujoco.MjData(model)
    names = [joint.name for joint in chain.robot.mechanism.coordinates]
    places = [model.joint(name).qposadr[0] for name in names]
    dofs = [model.joint(names[k]).dofadr[0] for k in chain.actuated]
    driven = [places[k] for k in chain.actuated]
    reference = motion.driven.at(np.arange(TICKS) * 1e-3)
    worst = [0.0]

    def theirs(feedback=True) -> None:
        mujoco.mj_resetData(model, data)
        data.qpos[places] = start
        for k in range(TICKS):
            if feedback:
                error, rate = reference.u[k] - data.qpos[driven], reference.v[k] - data.qvel[dofs]
                data.qfrc_applied[dofs] = KP * error + KD * rate
            mujoco.mj_step(model, data)

    def gaps() -> None:
        mujoco.mj_resetData(model, data)
        data.qpos[places] = start
        for k in range(TICKS):
            data.qfrc_applied[dofs] = KP * (reference.u[k] - data.qpos[driven])
            data.qfrc_applied[dofs] += KD * (reference.v[k] - data.qvel[dofs])
            mujoco.mj_step(model, data)
            worst[0] = max(worst[0], float(np.abs(data.efc_pos[: data.ne]).max(initial=0.0)))

    gaps()
    other, alone = least(theirs) / TICKS, least(lambda: theirs(False)) / TICKS
    print(f"{name}: {chain.n} joints, {len(chain.actuated)} driven, {chain.m} rows of loops; us a tick")
    print(f"  mafsil  {1e6 * ours:7.2f}   batch {1e6 * batch:7.3f}   steps {1e6 * steps:7.1f}   "
          f"own law {1e6 * own:.1f}   gap {gap:.1e}")  # fmt: skip
    print(f"  MuJoCo  {1e6 * other:7.2f}   mj_step alone {1e6 * alone:7.2f}   gap {worst[0]:.1e}")
    print(f"  ratio   {other / ours:7.2f}   batch {other / batch:7.1f}   steps {other / steps:7.2f}   "
          f"own law {other / own:.2f}   "
          f"beside mj_step alone {alone / ours:.2f}, batch {alone / batch:.1f}")  # fmt: skip


def main() -> None:
    """All mechanisms."""
    warnings.simplefilter("ignore")
    bars, platform = four_bar(), hexapod()
    compare("four-bar", mf.Robot(bars), np.array([0.5, 0.5, 1.5]), np.array([1.5]), mjcf.write(bars))
    palletiser = mf.load(str(FILE), tip="forearm")
    compare("palletiser", palletiser, np.zeros(4), np.array([0.7, 0.4]), FILE.read_text(encoding="utf-8"))
    legs = 0.1 * np.array([1, -1, 0.5, 0, 1, -0.5])
    compare("hexapod", mf.Robot(platform), np.zeros(platform.n), legs, mjcf.write(platform))


if __name__ == "__main__":
    main()
