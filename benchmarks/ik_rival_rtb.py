"""Robotics Toolbox's ik_LM on chains and targets from a file; run by its own interpreter, for `ik_numerical.py`.

python benchmarks/ik_rival_rtb.py CHAIN.npz

The file holds constants (n + 1, 4, 4) between joints that turn about or slide along z, `slides`, `lower`, `upper`,
targets `T`, `tolerance`; all of it is read before any clock starts. Prints a line of JSON with the version; then, for
every line "first last" on its input, solves those poses one by one and prints the joint coordinates of every solve, its
seconds by the clock and of its thread's processor. It waits in between, so that both sides can take turns.
"""

import json
import sys
from time import perf_counter, thread_time

import numpy as np
import roboticstoolbox as rtb
from roboticstoolbox import ET


def main(path: str) -> None:
    with np.load(path) as file:
        chain = {name: file[name] for name in file.files}
    T, tolerance = np.ascontiguousarray(chain["T"]), float(chain["tolerance"])
    ets = rtb.ETS([ET.SE3(chain["constants"][0])])
    for k, (low, high) in enumerate(zip(chain["lower"].tolist(), chain["upper"].tolist(), strict=True)):
        joint = ET.tz if chain["slides"][k] else ET.Rz
        ets = ets * joint(qlim=[low, high]) * ET.SE3(chain["constants"][k + 1])
    ets.ik_LM(T[0], tol=tolerance)
    print(json.dumps({"version": rtb.__version__}), flush=True)
    for line in sys.stdin:
        first, last = map(int, line.split())
        rows, seconds, work = [], [], []
        for wanted in T[first:last]:
            begin, worked = perf_counter(), thread_time()
            answer = ets.ik_LM(wanted, tol=tolerance)
            work.append(thread_time() - worked)
            seconds.append(perf_counter() - begin)
            rows.append([float(x) for x in np.ravel(answer.q)] if answer.success else None)
        print(json.dumps({"q": rows, "seconds": seconds, "work": work}), flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
