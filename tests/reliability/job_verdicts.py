"""J1: random jobs, hostile ones too: every word of the verdict is held against the recording, by plain NumPy.

`python -m tests.reliability.job_verdicts --jobs 1000 --seed 0 --resume DIR`

Arms of the library, some with weaker motors, friction, narrower limits; goals in joints and poses, parts known and not
known to the controller, pushes, wrong masses, hostile gains, low rates, noisy sensors. What the run says (verdict,
level, findings with their numbers, targets, integrator) must be what `tests.reliability.recording_check` finds in the
recorded arrays: nothing false is said, and nothing that has to be said is left out.
"""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np

from mafsil.errors import JobError
from mafsil.job import parse_job
from mafsil.job.planning.equipment import Equipment
from mafsil.job.planning.move_planner import plan_moves
from mafsil.job.planning.plan import Plan
from mafsil.job.planning.resting import resting_place
from mafsil.job.solve import drive
from mafsil.model import Friction, JointKind, Mechanism, library
from mafsil.robot import Robot
from tests.reliability import figures
from tests.reliability.recording_check import complaints

MASSES = (0.3, 2.0, 10.0)


def arm(rng: np.random.Generator, *, gentle: bool) -> Mechanism:
    """An arm of the library; unless gentle, with weaker motors, with friction, with narrow limits."""
    mechanism = library.load(str(rng.choice(library.robots())))
    if gentle:
        return mechanism
    weak = float(rng.choice([1.0, 1.0, 0.5, 0.1]))
    rubs = float(rng.choice([0.0, 0.0, 0.02, 0.3]))
    narrow = rng.random() < 0.2
    rest = resting_place(mechanism.limits)
    gravity = np.abs(np.asarray(Robot(mechanism).gravity_torque(rest)))
    joints = []
    for joint in mechanism.joints:
        if joint.kind is JointKind.FIXED:
            joints.append(joint)
            continue
        k = mechanism.joint_names.index(joint.name)
        limits = joint.limits
        effort = limits.effort if np.isfinite(limits.effort) else 3.0 * gravity[k] + 5.0
        limits = replace(limits, effort=weak * effort if weak < 1.0 else limits.effort)
        if narrow:
            limits = replace(limits, velocity=0.8, acceleration=3.0)
        friction = Friction(viscous=rubs, coulomb=rubs * (0.5 + 0.2 * gravity[k])) if rubs else joint.friction
        joints.append(replace(joint, limits=limits, friction=friction))
    return replace(mechanism, joints=tuple(joints))


def text_of(rng: np.random.Generator, robot: Robot, *, gentle: bool) -> str:
    """A random job for an arm; a gentle one has good gains, and nothing that its controller does not know but parts."""
    lines = [f'robot = "{robot.name}"', "[controller]"]
    start = resting_place(robot.limits)
    if gentle:
        lines.append(f'kind = "{rng.choice(["computed_torque", "computed_torque", "pd_gravity"])}"')
    elif rng.random() < 0.5:
        lines += ['kind = "computed_torque"', f"frequency = {rng.choice([3.0, 20.0, 20.0, 60.0, 500.0, 3000.0])}"]
    else:
        lines.append('kind = "pd_gravity"')
        inertia = np.diag(np.asarray(robot.mass_matrix(start)))
        if rng.random() < 0.5:
            scale = 10.0 ** rng.uniform(0.0, 5.0)
            lines.append(f"kp = {(scale * inertia + 1e-6).tolist()}")
        if rng.random() < 0.3:
            lines.append(f"kd = {(10.0 ** rng.uniform(0.0, 3.5) * inertia + 1e-6).tolist()}")
    if not gentle and rng.random() < 0.3:
        lines.append(f"rate = {rng.choice([500.0, 100.0, 50.0])}")
    lines += ["[simulation]", "step = 0.002", f"settle = {rng.choice([0.0, 0.2])}"]
    if not gentle:
        lines.append(f"mass_error = {rng.choice([0.0, 0.0, 0.0, 0.1, -0.3, 1.0])}")
    if rng.random() < 0.15:
        lines.append("noise = { position = 2e-4, velocity = 2e-3, seed = 3 }")
    if rng.random() < 0.3:
        lines += ["[tolerance]", f"position = {rng.choice([1e-4, 5e-3])}", f"orientation = {rng.choice([1e-3, 0.05])}"]
    return "\n".join([*lines, *_moves(rng, robot, start), *([] if gentle else _pushes(rng))]) + "\n"


def _moves(rng: np.random.Generator, robot: Robot, start: np.ndarray) -> list[str]:
    lines: list[str] = []
    held = False
    lower, upper = np.maximum(robot.limits.lower, -10.0), np.minimum(robot.limits.upper, 10.0)
    for number in range(int(rng.integers(1, 4))):
        goal = np.clip(start + rng.uniform(-0.4, 0.4, robot.n), lower, upper)
        lines += ["[[move]]", f'name = "go {number}"']
        if rng.random() < 0.3 and robot.n >= 6:
            T = np.asarray(robot.forward_kinematics(goal))
            rows = T[:3, :3]
            w = 0.5 * np.sqrt(max(1e-12, 1.0 + np.trace(rows)))
            turn = [rows[2, 1] - rows[1, 2], rows[0, 2] - rows[2, 0], rows[1, 0] - rows[0, 1]]
            if w > 0.2:
                quaternion = [w, *(x / (4.0 * w) for x in turn)]
                values = ", ".join(f"{x:.12g}" for x in quaternion)
                position = ", ".join(f"{x:.12g}" for x in T[:3, 3])
                lines.append(f"pose = {{ position = [{position}], quaternion = [{values}] }}")
            else:
                lines.append(f"joints = {goal.tolist()}")
        else:
            lines.append(f"joints = {goal.tolist()}")
            if rng.random() < 0.2:
                lines.append(f"tolerance = {{ joints = {rng.choice([1e-4, 0.02])} }}")
        if rng.random() < 0.4:
            known = str(rng.random() < 0.5).lower()
            lines.append("[[move]]")
            lines.append("place = true" if held else f"pick = {{ mass = {rng.choice(MASSES)}, known = {known} }}")
            held = not held
    return [*lines, "[[move]]", "place = true"] if held and rng.random() < 0.7 else lines


def _pushes(rng: np.random.Generator) -> list[str]:
    lines: list[str] = []
    if rng.random() < 0.35:
        wrench = (10.0 ** rng.uniform(-1.0, 2.3) * rng.uniform(-1.0, 1.0, 6) * [0.1, 0.1, 0.1, 1, 1, 1]).tolist()
        start, duration = rng.choice([0.0, 0.3, 0.6, 30.0]), rng.choice([0.05, 0.5, 2.0])
        lines += ["[[disturbance]]", f"start = {start}", f"duration = {duration}", f"wrench = {wrench}"]
    return lines


def judged(number: int) -> dict[str, int]:
    """One job: counts of what it became, and of false or missing words."""
    rng = np.random.default_rng([101, number])
    gentle = rng.random() < 0.4
    robot = Robot(arm(rng, gentle=gentle))
    text = text_of(rng, robot, gentle=gentle)
    job = parse_job(text)
    motion = plan_moves(job, (Equipment(None, job.tool, robot, np.eye(4), np.eye(4)),))
    if not isinstance(motion, Plan):
        return {"refused": 1}
    try:
        run = drive(job, text, robot, motion)
    except JobError as error:
        return {"refused": 1, "bad_refusals": int(error.key != "job.stiff_method")}
    counts, found = complaints(run)
    for complaint in found:
        print(f"job {number}: {complaint}\n{text}", file=sys.stderr)
    return counts | {"bad_words": len(found)}


def work(seed: int, count: int) -> dict[str, int]:
    """Jobs of a shard, counted by what became of them."""
    total = {"jobs": count, "refused": 0, "bad_words": 0, "bad_refusals": 0}
    for number in range(seed * 1000, seed * 1000 + count):
        for name, value in judged(number).items():
            total[name] = total.get(name, 0) + value
    return total


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "jobs", 1000, 10)
    sys.exit(not figures.run("J1", options, work)["passed"])
