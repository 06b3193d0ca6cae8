"""Robotics Toolbox's ik_LM on chains and targets from a file; run by its own interpreter, for `ik_numerical.py`.

python benchmarks/ik_rival_rtb.py CHAIN.npz

The file holds constants (n + 1, 4, 4) between joints that turn about or slide along z, `slides`, `lower`, `upper`,
targets `T`. Prints JSON: joint coordinates of every solve, its seconds by the clock and of its thread's processor.
"""

import json
import sys
from time import perf_counter, thread_time

import numpy as np
import roboticstoolbox as rtb
from roboticstoolbox import ET


def main(path: str) -> None:
    chain = np.load(path)
    limits = list(zip(chain["lower"], chain["upper"], strict=True))
    ets = rtb.ETS([ET.SE3(chain["constants"][0])])
    for k, (low, high) in enumerate(limits):
        joint = ET.tz if chain["slides"][k] else ET.Rz
        ets = ets * joint(qlim=[low, high]) * ET.SE3(chain["constants"][k + 1])
    ets.ik_LM(chain["T"][0])
    rows, seconds, work = [], [], []
    for T in chain["T"]:
        begin, worked = perf_counter(), thread_time()
        answer = ets.ik_LM(T, tol=float(chain["tolerance"]))
        work.append(thread_time() - worked)
        seconds.append(perf_counter() - begin)
        rows.append([float(x) for x in np.ravel(answer.q)] if answer.success else None)
    print(json.dumps({"version": rtb.__version__, "q": rows, "seconds": seconds, "work": work}))


if __name__ == "__main__":
    main(sys.argv[1])
