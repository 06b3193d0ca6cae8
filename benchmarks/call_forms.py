"""What does each form of a call cost beside Pinocchio's Python call, in the same run?

python benchmarks/call_forms.py [--robots panda ur5e ...] [--json FILE] [--quick]

Public names only: a tip, a named frame, a tip wrench by position and by name, `out=`, keywords, lists, single
precision, strided rows, and batches of 2, 8, 32 and 2,048 rows as fresh arrays. Pinocchio always gets whole arrays,
also where we get lists; its results stay in its data object. For a batch its call counts once for each row. Results are
compared before anything is timed. Times are the least (median) of many short turns.
"""

from __future__ import annotations

import argparse
import json
import sys
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402
import pinocchio as pin  # noqa: E402

from benchmarks.batch_sizes import ARMS, TREES, robot_named  # noqa: E402
from benchmarks.comparison import Comparisons  # noqa: E402
from benchmarks.stopwatch import BRIEF, BRIEFER, Timing, machine, race, verdict  # noqa: E402
from mafsil.robot import Robot  # noqa: E402
from tests.oracles.pinocchio_model import MOTION_ORDER, model_of  # noqa: E402
from tests.oracles.states import sample  # noqa: E402

ROBOTS = (*ARMS, *TREES)
BATCHES = (2, 8, 32, 2048)
TARGET = 3.0
"""How many times quicker than Pinocchio's call any form should be."""

Task = Callable[[], object]


def main() -> None:
    options = _parsed()
    details = machine("mafsil", "numpy", "pin")
    print(" | ".join(f"{key} {value}" for key, value in details.items()), flush=True)
    turns = BRIEFER if options.quick else BRIEF
    rows: list[dict[str, Any]] = []
    print(f"{'robot':9}{'call':56}{'rows':>6}{'ns a call':>18}{'pin ns':>9}{'x':>8}")
    for name in options.robots:
        for row in measured(name, turns):
            rows.append(row)
            print(_line(row), flush=True)
    for single in (True, False):
        ratios = [row["ratio"] for row in rows if (row["rows"] == 1) == single]
        print(verdict("single calls" if single else "batches", ratios, TARGET))
    if options.json:
        found = Comparisons()
        for row in rows:
            call, count = f"{row['call']}, {row['rows']} rows", row["rows"]
            times = row["ns"]["least"] / count / 1e3, row["pinocchio_ns"]["least"] / 1e3
            found.add(call, row["robot"], times[0], "Pinocchio call", times[1], TARGET)
        figures = {"machine": details, "rows": rows, "comparisons": found.plain()}
        options.json.write_text(json.dumps(figures, indent=1))


def measured(name: str, turns: Any) -> Iterator[dict[str, Any]]:
    """One row for each form of each routine."""
    robot = robot_named(name)
    for routine in (ForwardKinematics, Jacobian, InverseDynamics):
        calls = routine(robot, name)
        for label, rows, task in calls.forms():
            calls.compare(label, rows, task)
            taken = race({"mafsil": task, "pinocchio": calls.rival(label)}, **turns)
            ours, rival = taken["mafsil"], taken["pinocchio"]
            yield {
                "robot": name,
                "call": label,
                "rows": rows,
                "ns": _ns(ours),
                "pinocchio_ns": _ns(rival),
                "ratio": rows * rival.least / ours.least,
            }


class _Calls(ABC):
    """States of one robot, and Pinocchio's model of it."""

    def __init__(self, robot: Robot, name: str) -> None:
        self.robot, self.name = robot, name
        self.model, frames = model_of(robot.mechanism)
        self.data = self.model.createData()
        self.tip = frames[-1]
        self.states = sample(robot.mechanism, max(BATCHES), np.random.default_rng(1)).arguments(("q", "qd", "qdd"))
        self.wrenches = np.random.default_rng(2).normal(size=(max(BATCHES), 6))
        self.point = [np.ascontiguousarray(x[0]) for x in self.states]
        # Numbers of single precision are the same in double: every form has one right answer.
        self.narrow = [x.astype(np.float32) for x in self.point]

    @abstractmethod
    def forms(self) -> Iterator[tuple[str, int, Task]]:
        """Label, rows and task of every form."""

    @abstractmethod
    def rival(self, label: str) -> Task:
        """Pinocchio's call."""

    @abstractmethod
    def compare(self, label: str, rows: int, task: Task) -> None:
        """The first row of the result against Pinocchio's result at the same state."""


class _OfPosition(_Calls):
    """The forms of a routine of q with frames."""

    routine: str
    frame: str

    def forms(self) -> Iterator[tuple[str, int, Task]]:
        f, q, link = getattr(self.robot, self.routine), self.point[0], self.robot.mechanism.link_names[3]
        out, lists, narrow = f(q), q.tolist(), self.narrow[0]
        strided = np.repeat(q, 2)[::2]
        yield f"{self.routine}(q)", 1, lambda: f(q)
        yield f"{self.routine}(q, frame=link)", 1, lambda: f(q, frame=link)
        yield f"{self.routine}(q, out=T)", 1, lambda: f(q, out=out)
        yield f"{self.routine}(q, frame=link, out=T)", 1, lambda: f(q, frame=link, out=out)
        yield f"{self.routine}(q=q)", 1, lambda: f(q=q)
        yield f"{self.routine}(list)", 1, lambda: f(lists)
        yield f"{self.routine}(float32)", 1, lambda: f(narrow)
        yield f"{self.routine}(strided)", 1, lambda: f(strided)
        for rows in BATCHES:
            batch = np.ascontiguousarray(self.states[0][:rows])
            result, wide = f(batch), np.ascontiguousarray(np.repeat(batch, 2, axis=1))[:, ::2]
            yield f"{self.routine}(batch)", rows, lambda b=batch: f(b)
            yield f"{self.routine}(batch, frame=link)", rows, lambda b=batch: f(b, frame=link)
            yield f"{self.routine}(batch, out=T)", rows, lambda b=batch, r=result: f(b, out=r)
            yield f"{self.routine}(strided batch)", rows, lambda w=wide: f(w)

    def frame_of(self, label: str) -> int:
        """Pinocchio's number of the frame that a form asks for."""
        if "frame=" not in label:
            return self.tip
        return _link_frame(self.robot, 3)


class ForwardKinematics(_OfPosition):
    """Poses."""

    routine = "forward_kinematics"

    def rival(self, label: str) -> Task:
        model, data, q, frame = self.model, self.data, self.point[0], self.frame_of(label)

        def call() -> None:
            pin.forwardKinematics(model, data, q)
            pin.updateFramePlacement(model, data, frame)

        return call

    def compare(self, label: str, rows: int, task: Task) -> None:
        q = self.narrow[0].astype(float) if "float32" in label else self.point[0]
        pin.framesForwardKinematics(self.model, self.data, q)
        wanted = self.data.oMf[self.frame_of(label)].homogeneous
        np.testing.assert_allclose(np.reshape(task(), (-1, 4, 4))[0], wanted, atol=1e-10, err_msg=label)


class Jacobian(_OfPosition):
    """Body Jacobians."""

    routine = "jacobian_body"

    def rival(self, label: str) -> Task:
        model, data, q, frame = self.model, self.data, self.point[0], self.frame_of(label)
        return lambda: pin.computeFrameJacobian(model, data, q, frame, pin.LOCAL)

    def compare(self, label: str, rows: int, task: Task) -> None:
        q = self.narrow[0].astype(float) if "float32" in label else self.point[0]
        wanted = pin.computeFrameJacobian(self.model, self.data, q, self.frame_of(label), pin.LOCAL)[MOTION_ORDER]
        np.testing.assert_allclose(np.reshape(task(), (-1, *wanted.shape))[0], wanted, atol=1e-10, err_msg=label)


class InverseDynamics(_Calls):
    """Efforts, with and without a wrench at the tip; Pinocchio gets none, which is its quicker call."""

    def forms(self) -> Iterator[tuple[str, int, Task]]:
        f, (q, v, a), F = self.robot.inverse_dynamics, self.point, self.wrenches[0]
        out, lists, narrow = f(q, v, a), [x.tolist() for x in self.point], self.narrow
        x, y, z = lists
        k, l, m = narrow
        strided = [np.repeat(part, 2)[::2] for part in self.point]
        s, t, u = strided
        yield "inverse_dynamics(q, qd, qdd)", 1, lambda: f(q, v, a)
        yield "inverse_dynamics(q, qd, qdd, F)", 1, lambda: f(q, v, a, F)
        yield "inverse_dynamics(q, qd, qdd, tip_wrench=F)", 1, lambda: f(q, v, a, tip_wrench=F)
        yield "inverse_dynamics(q, qd, qdd, tip_wrench=F, out=tau)", 1, lambda: f(q, v, a, tip_wrench=F, out=out)
        yield "inverse_dynamics(q, qd, qdd, out=tau)", 1, lambda: f(q, v, a, out=out)
        yield "inverse_dynamics(q=q, qd=qd, qdd=qdd)", 1, lambda: f(q=q, qd=v, qdd=a)
        yield "inverse_dynamics(lists)", 1, lambda: f(x, y, z)
        yield "inverse_dynamics(float32)", 1, lambda: f(k, l, m)
        yield "inverse_dynamics(strided)", 1, lambda: f(s, t, u)
        for rows in BATCHES:
            q_, v_, a_ = (np.ascontiguousarray(part[:rows]) for part in self.states)
            F_, result = self.wrenches[:rows], f(q_, v_, a_)
            yield "inverse_dynamics(batch)", rows, lambda b=(q_, v_, a_): f(*b)
            yield "inverse_dynamics(batch, tip_wrench=F)", rows, lambda b=(q_, v_, a_), w=F_: f(*b, tip_wrench=w)
            yield "inverse_dynamics(batch, out=tau)", rows, lambda b=(q_, v_, a_), r=result: f(*b, out=r)

    def rival(self, label: str) -> Task:
        model, data, (q, v, a) = self.model, self.data, self.point
        return lambda: pin.rnea(model, data, q, v, a)

    def compare(self, label: str, rows: int, task: Task) -> None:
        q, v, a = (x.astype(float) for x in self.narrow) if "float32" in label else self.point
        wanted = np.array(pin.rnea(self.model, self.data, q, v, a))
        if "F" in label:
            wanted += self.robot.jacobian_body(q).T @ self.wrenches[0]
        np.testing.assert_allclose(np.reshape(task(), (-1, len(q)))[0], wanted, atol=1e-9, err_msg=label)


def _link_frame(robot: Robot, link: int) -> int:
    """Pinocchio's number of the frame of a link."""
    return model_of(robot.mechanism)[1][link]


def _ns(timing: Timing) -> dict[str, float]:
    return {"least": 1e9 * timing.least, "median": 1e9 * timing.median}


def _line(row: dict[str, Any]) -> str:
    ours, rival = row["ns"], row["pinocchio_ns"]["least"]
    figures = f"{ours['least']:9.0f} ({ours['median']:6.0f}){rival:9.0f}{row['ratio']:8.2f}"
    return f"{row['robot']:9}{row['call']:56}{row['rows']:6}{figures}"


def _parsed() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robots", nargs="+", default=list(ROBOTS), choices=ROBOTS)
    parser.add_argument("--json", type=Path, help="file for the figures")
    parser.add_argument("--quick", action="store_true", help="a quarter of the repeats")
    return parser.parse_args()


if __name__ == "__main__":
    main()
