"""Laws of every family as C, beside their own sessions in Python, tick by tick with the memory handed on."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass, field
from functools import cache

import numpy as np
import pytest

import mafsil as mf
from mafsil import control
from mafsil.control import TaskCoordinates, TaskTarget, export_law, saturate
from mafsil.control.joints.elastic_laws import ElasticState
from mafsil.errors import InputError
from mafsil.geometry import rotation
from mafsil.kernels.export.exported import compiler, trial
from mafsil.model import sdf
from mafsil.parallel import ClosedChain
from mafsil.trajectory import Motion, quintic
from tests.model.sdf.test_sdf_loops import ENDS, bars

CC = compiler()
needs_compiler = pytest.mark.skipif(CC is None, reason="no C compiler")
PERIOD, TICKS = 2e-3, 12
PLACE = TaskCoordinates(rows=(3, 4, 5))
NEAR = 1e-9
"""Of the largest effort: inverses of the tip's inertia by other ways."""


@cache
def robot(name: str) -> mf.Robot:
    return mf.load(name)


@dataclass
class World:
    """What laws ask for, as it is at a tick."""

    tip: tuple = ()
    read: dict = field(default_factory=dict)

    def target(self, t: float) -> TaskTarget:
        place, rate, growth = self.tip
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = rotation.from_quaternion(place[3:] / np.linalg.norm(place[3:])), place[:3]
        return TaskTarget(T, rate, growth)

    def force(self, q, qd):
        return self.read["force"]

    def acceleration(self, q, qd):
        return self.read["acceleration"]


def families(world: World) -> dict:
    """A law of every family that is arithmetic, with memory where it has one; the arm's name beside."""
    arm, seven = robot("puma560"), robot("panda")
    pid = control.pid(6, 90.0, 9.0, 50.0)
    task = {"coordinates": PLACE}
    soft = control.Impedance.of(3, inertia=2.0, damping=30.0, stiffness=200.0)
    whole = control.Impedance.of(6, inertia=2.0, damping=30.0, stiffness=200.0)
    matrix = 50.0 * np.eye(6) + 5.0
    wall = control.Wall([0.3, 0.0, 0.2], [0.0, 0.6, 0.8], 900.0, 20.0, friction=0.3)
    elastic = control.elastic_arm(arm, 5e3)
    return {
        "adaptive": control.adaptive_control(arm, learning=0.3, initial=np.linspace(0.1, 1.0, 10)),
        "sliding_mode": control.sliding_mode(arm),
        "min_max": control.analysis.min_max(arm),
        "linear_quadratic": control.linear_quadratic(arm, np.full(6, 0.3)),
        "matrix_pid": control.matrix_pid(6, matrix, 3.0, matrix),
        "matrix_gravity": control.matrix_gravity_compensation(arm, matrix, 3.0, 2.0),
        "matrix_computed_torque": control.matrix_computed_torque(arm, matrix, 20.0, 5.0),
        "null_space": control.null_space_feedback(seven, **task),
        "task_space": control.task_computed_torque(arm, world.target, integral=30.0, **task),
        "task_space_redundant": control.task_computed_torque(seven, world.target, **task),
        "task_space_body": control.task_computed_torque(arm, world.target, coordinates=TaskCoordinates("body")),
        "task_space_angles": control.task_computed_torque(
            seven, world.target, coordinates=TaskCoordinates("ZYX", (0, 1, 2))
        ),
        "impedance": control.impedance_control(arm, soft, world.target, sensor=world.force, **task),
        "impedance_alone": control.impedance_control(arm, soft, world.target, shift_acceleration=True, **task),
        "impedance_by_force": control.impedance_by_force(
            arm, soft, world.target, world.force, kp=0.5, ki=9.0, clamp=4.0, acceleration=world.acceleration, **task
        ),
        "admittance": control.admittance_control(arm, soft, world.target, world.force, **task),
        "admittance_whole": control.admittance_control(arm, whole, world.target, world.force, shift_acceleration=True),
        "admittance_of_books": control.admittance_control(
            arm, soft, world.target, world.force, own_state=False, **task
        ),
        "force": control.force_control(arm, np.arange(6.0), sensor=world.force, kp=0.5, ki=9.0, damping=2.0, clamp=3.0),
        "hybrid": control.hybrid_control(
            arm, world.target, np.eye(3)[2:], np.full(3, 9.0), sensor=world.force, force_kp=0.5, force_ki=9.0,
            gains=control.Gains.of(3, 100.0, 20.0, 50.0), **task,
        ),
        "virtual_environment": control.contact.virtual_environment(arm, wall),
        "contact_feedforward": control.combine(control.contact.contact_feedforward(arm, wall), pid),
        "tip_damping": control.contact.TipDamping(arm, PLACE, np.diag([1.0, 2.0, 3.0])),
        "encoder_loop": control.encoder_loop(pid, 2.0 * np.pi / 512, filter_time=5e-3),
        "delayed": control.add_delay(pid, 3 * PERIOD),
        "delayed_again": control.add_delay(control.encoder_loop(pid, 0.0), PERIOD),
        "current_loop": control.current_loop(pid, 300.0),
        "sum": control.combine(control.adaptive_control(arm), control.matrix_pid(6, 5.0, 1.0, 9.0), pid),
        "tip_and_null_space": control.combine(
            control.impedance_control(seven, soft, world.target, sensor=world.force, **task),
            control.admittance_control(seven, soft, world.target, world.force, **task),
            control.null_space_feedback(seven, **task),
        ),
        "function": control.as_law(
            lambda t, q, qd, r: np.where(q > 0.0, np.sin(3.0 * t), 2.0) * (r.u - q) - np.tanh(qd)
        ),
        "motor_feedback": control.motor_feedback(elastic, 400.0, 30.0),
        "singular_perturbation_control": control.singular_perturbation_control(
            elastic, control.computed_torque(arm, integral=20.0), 5.0
        ),
    }  # fmt: skip


NAMES = list(families(World()))


def arm_of(name: str) -> mf.Robot:
    return robot(
        "panda" if "null_space" in name or name in ("task_space_redundant", "task_space_angles") else "puma560"
    )


def ticks_in_c(files, shapes: dict[str, int], rows: dict[str, np.ndarray], n: int, folder) -> np.ndarray:
    """Efforts (ticks, n) of the function, called with its memory handed on."""
    files.write(folder)
    order = [name for name in shapes if name not in ("effort", "next_memory", "memory")]
    memory = shapes.get("memory", 0)
    arrays = "".join(
        f"static const double {name}[] = {{{','.join(float(x).hex() for x in rows[name].ravel())}}};\n"
        for name in order
    )  # fmt: skip
    given = [f"{name} + {shapes[name]} * k" for name in order]
    if memory:
        given += ["memory"]
    calls = ", ".join([*given, "effort", *(["memory"] if memory else [])])
    state = f"double memory[{memory}] = {{0}};" if memory else ""
    (folder / "main.c").write_text(f"""
#include <stdio.h>
#include "law.h"
{arrays}
int main(void) {{
    double effort[{n}];
    {state}
    for (int k = 0; k < {TICKS}; k++) {{
        law({calls});
        for (int i = 0; i < {n}; i++) printf("%.17g ", effort[i]);
    }}
    return 0;
}}
""")
    program = folder / "run"
    subprocess.run([CC, "-std=c99", "-O1", "main.c", "law.c", "-o", str(program), "-lm"], cwd=folder, check=True)
    said = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout
    return np.array(said.split(), float).reshape(TICKS, n)


def shapes_of(header: str) -> dict[str, int]:
    """Sizes of the arguments in their order, as the header declares them."""
    declared = header[header.index("void law(") :].partition(";")[0]
    found = re.findall(r"(\w+)((?:\[\d+\])*)\s*[,)]", declared)
    return {name: int(np.prod([int(x) for x in re.findall(r"\d+", size)] or [1])) for name, size in found}


@needs_compiler
@pytest.mark.parametrize("name", NAMES)
def test_ticks_in_c_are_those_of_the_session(name, tmp_path):
    """The reference moves, sensors read something else at every tick; the memory goes on from call to call."""
    world = World()
    law, arm = families(world)[name], arm_of(name)
    files = export_law(arm, law, period=PERIOD, function="law", saturate=name != "sum")
    shapes = shapes_of(files.files["law.h"].decode())
    rng = np.random.default_rng(5)
    steps = np.arange(TICKS)[:, None] * PERIOD
    start, course = rng.uniform(-1, 1, (2, arm.n))
    rows = {
        "q": start + course * steps + 1e-3 * rng.normal(size=(TICKS, arm.n)),
        "qd": course + 0.1 * rng.normal(size=(TICKS, arm.n)),
        "reference": np.stack([start + course * steps, course + 0.0 * steps, 0.0 * course * steps + 0.2], axis=1),
        "motor": start + course * steps + 0.01,
        "motor_rate": course + 0.1 * rng.normal(size=(TICKS, arm.n)),
        "t": steps[:, 0],
        "target_rate": 0.2 * rng.normal(size=(TICKS, 6)),
        "target_growth": 0.2 * rng.normal(size=(TICKS, 6)),
        "force": 5.0 * rng.normal(size=(TICKS, shapes.get("force", 6))),
        "acceleration": rng.normal(size=(TICKS, shapes.get("acceleration", 6))),
    }  # fmt: skip
    poses = arm.forward_kinematics(rows["q"])
    rows["target"] = np.concatenate(
        [poses[:, :3, 3] + 0.05, 3.0 * rotation.to_quaternion(poses[:, :3, :3]) + 0.2 * rng.normal(size=(TICKS, 4))], 1
    )
    assert set(shapes) <= {*rows, "memory", "effort", "next_memory"}
    there = ticks_in_c(files, shapes, rows, arm.n, tmp_path)
    session, here = law.session(PERIOD), []
    for k in range(TICKS):
        world.tip = rows["target"][k], rows["target_rate"][k], rows["target_growth"][k]
        world.read = {"force": rows["force"][k], "acceleration": rows["acceleration"][k]}
        state = (rows["q"][k], rows["qd"][k])
        if "motor_rate" in shapes:
            state = (ElasticState(*state, rows["motor"][k], rows["motor_rate"][k]),)
        effort = session(k * PERIOD, *state, Motion(*rows["reference"][k]))
        here.append(saturate(effort, arm.limits.effort) if name != "sum" else effort)
    assert np.abs(here).max() > 1e-3
    assert np.ptp(np.array(here), axis=0).max() > 1e-4
    np.testing.assert_allclose(there, here, rtol=0, atol=NEAR * np.abs(here).max())


@needs_compiler
@pytest.mark.parametrize("name", ["adaptive", "impedance", "encoder_loop"])
def test_the_proof_of_the_files_holds(name):
    found = trial(export_law(arm_of(name), families(World())[name], function="law"), CC)
    assert found.ok, found.said


def refused() -> dict:
    """Laws that are no expression, the law that is named and a word of the reason."""
    arm, world = robot("puma560"), World()
    pid = control.pid(6, 9.0)
    chain = ClosedChain(sdf.read(bars(ENDS, "ABDC")))

    class Counting:
        """Memory in an array that is changed in place."""

        def __init__(self):
            self.count = np.zeros(1)

        def __call__(self, t, q, qd, reference):
            self.count += 1.0
            return self.count * (reference.u - q)

        def session(self, period):
            return Counting()

    class Listing(Counting):
        """Memory that grows."""

        def __init__(self):
            self.kept = []

        def __call__(self, t, q, qd, reference):
            self.kept.append(q)
            return self.kept[0] - q

        def session(self, period):
            return Listing()

    switch = control.contact.ContactSwitch(
        pid, pid, lambda t: True, world.force, lambda t: np.array([0.0, 0.0, 1.0]), 1.0
    )
    course = control.elastic_linearization(control.elastic_arm(arm, 5e3), quintic(np.zeros(6), np.ones(6), 1.0))
    return {
        "predictive": (control.model_predictive(arm), "ModelPredictive", "not plain arithmetic"),
        "table": (control.joints.LearnedEffort(1e-3, np.zeros((9, 6))), "LearnedEffort", "branches"),
        "switch": (control.combine(pid, switch), "ContactSwitch", "branches"),
        "course": (course, "ElasticLinearization", "not plain arithmetic"),
        "if": (control.as_law(lambda t, q, qd, r: -q if q[0] > 0.0 else q), "FunctionLaw", "branches"),
        "closed": (control.closed_computed_torque(chain), "ClosedComputedTorque", "not plain arithmetic"),
        "around": (control.add_delay(control.model_predictive(arm), 1e-3), "ModelPredictive", "not plain arithmetic"),
        "in place": (Counting(), "Counting", "remembers"),
        "growing": (Listing(), "Listing", "remembers"),
    }


@pytest.mark.parametrize("name", list(refused()))
def test_what_is_no_expression_is_named_with_the_reason(name):
    law, family, reason = refused()[name]
    with pytest.raises(InputError, match=f"{family} .*{reason}") as caught:
        export_law(robot("puma560"), law)
    assert caught.value.message("ar") != caught.value.message("en")
