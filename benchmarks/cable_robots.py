"""Tensions of cable robots beside a linear program (scipy's HiGHS) for the same question, single and in batches.

The linear program says yes or no; ours says how much, proves a no and gives the nearest tensions.
"""

from __future__ import annotations

import time

import numpy as np
from scipy.optimize import linprog

from mafsil import parallel

REPEATS = 5


def crane() -> parallel.CableRobot:
    corners = np.array([[x, y, z] for x in (-2, 2) for y in (-1.5, 1.5) for z in (0, 3)], dtype=float)
    eyes = np.array([[0.3 * np.sign(x), 0, -0.2] if z else [0, 0.3 * np.sign(y), 0.2] for x, y, z in corners])
    return parallel.CableRobot(corners, eyes, 10.0, 800.0)


def shortest(action) -> float:
    times = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        action()
        times.append(time.perf_counter() - begin)
    return min(times)


def main() -> None:
    robot, rng = crane(), np.random.default_rng(0)
    T = np.tile(np.eye(4), (4000, 1, 1))
    T[:, :3, 3] = rng.uniform([-1.5, -1.1, 0.5], [1.5, 1.1, 2.5], (4000, 3))
    load = robot.weight(T, 40.0)
    W, few = robot.structure_matrix(T), 200
    parallel.cable_tensions(robot, T[0], load[0])

    def programs() -> None:
        for k in range(few):
            linprog(np.zeros(8), A_eq=W[k], b_eq=-load[k], bounds=[(10, 800)] * 8)

    peer = shortest(programs) / few
    single = shortest(lambda: [parallel.cable_tensions(robot, T[k], load[k]) for k in range(few)]) / few
    batch = shortest(lambda: parallel.cable_tensions(robot, T, load)) / len(T)
    print(f"linear program {1e6 * peer:8.1f} us a pose")
    print(f"single         {1e6 * single:8.1f} us a pose, {peer / single:6.1f} times")
    print(f"batch of {len(T)}  {1e6 * batch:8.1f} us a pose, {peer / batch:6.1f} times")


if __name__ == "__main__":
    main()
