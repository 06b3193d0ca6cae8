"""Laws of the tip that a job can choose, with gains that fit the arm where it names none; and what the tip touches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, Vector3
from mafsil.control import (
    Gains,
    Impedance,
    Law,
    TaskCoordinates,
    admittance_control,
    combine,
    hybrid_control,
    impedance_control,
    null_space_feedback,
    task_computed_torque,
    task_dynamics,
)
from mafsil.control.contact import (
    AtPoints,
    ContactSwitch,
    Door,
    Hole,
    RoundSurface,
    TipDamping,
    TipForceSensor,
    guiding_line,
    guiding_plane,
)
from mafsil.control.contact.environment import CombinedEnvironment, Environment, Wall
from mafsil.control.laws import TipOfJoints
from mafsil.job.language import surrounding_tables as tables
from mafsil.job.language.description import Job
from mafsil.job.language.driving_tables import PerAxis
from mafsil.robot import Robot
from mafsil.simulation import Plant, RigidSurface
from mafsil.trajectory import Trajectory

FREQUENCY, DAMPING = 20.0, 1.0
"""Of the tip's motion, where the job names none [rad/s, 1]."""
NORMAL_FORCE, FORCE_INTEGRAL = 10.0, 10.0
"""Of hybrid control, where the job names none [N, 1/s]."""
TOUCH = 0.5
"""Force from which on the tip counts as touching; with noise, five times its deviation if that is more [N]."""
REACHED = 1e-4
"""How far before a surface a planned tip counts as at it [m]."""
CONTACT_DAMPING = 0.5
"""Damping ratio that hybrid control gives the arm's inertia on a surface that gives way."""
LOOKED_AT = 2_000
"""Places of a stretch at which it is looked which surfaces the plan is on."""
MOVES = 1e-9
"""Entry of a Jacobian below which a joint does not move the tip along an axis [m]."""


def tip_law(job: Job, model: Robot, trajectory: Trajectory, plant: Plant) -> Law:
    """A law of the tip for a stretch of a job's motion; a redundant arm's joints follow theirs beside it.

    Args:
        job: whose controller it is; one of `TIP_LAWS`.
        model: the arm as the controller knows it.
        trajectory: of the stretch.
        plant: the arm that moves, whose tip carries the force sensor.
    """
    task = _coordinates(model, trajectory)
    law = _MAKERS[job.controller.kind](job, model, trajectory, plant, task)
    if model.n <= len(task.rows) or job.controller.kind == "task_computed_torque":
        return law
    return combine(law, null_space_feedback(model, coordinates=task))


def _coordinates(model: Robot, trajectory: Trajectory) -> TaskCoordinates:
    """All six for arms of six joints and more; for others the directions in which they can move the tip."""
    if model.n >= 6:
        return TaskCoordinates()
    places = trajectory.at(np.linspace(0.0, trajectory.duration, 5)).u
    moved = np.abs(TaskCoordinates(rows=(3, 4, 5)).jacobian(model, places)).max(axis=(0, 2)) > MOVES
    return TaskCoordinates(rows=tuple(int(k) + 3 for k in np.flatnonzero(moved)[: model.n]))


def _task_computed_torque(job: Job, model: Robot, trajectory: Trajectory, plant: Plant, task: TaskCoordinates) -> Law:
    own = job.controller
    return task_computed_torque(
        model, TipOfJoints(model, trajectory), coordinates=task,
        natural_frequency=own.frequency or FREQUENCY, damping_ratio=own.damping or DAMPING, rest_frequency=FREQUENCY,
    )  # fmt: skip


def _impedance(job: Job, model: Robot, trajectory: Trajectory, plant: Plant, task: TaskCoordinates) -> Law:
    inertia = np.diagonal(_inertia(model, trajectory, task))
    return impedance_control(
        model, _impedance_of(job, task, inertia), TipOfJoints(model, trajectory), coordinates=task,
        shift_acceleration=True,
    )  # fmt: skip


def _admittance(job: Job, model: Robot, trajectory: Trajectory, plant: Plant, task: TaskCoordinates) -> Law:
    own = job.controller
    inertia = _chosen(task, own.turn_inertia, own.tip_mass, np.diagonal(_inertia(model, trajectory, task)))
    sensor = _sensor(job, plant, task)
    wanted = _impedance_of(job, task, inertia)
    return admittance_control(
        model, wanted, TipOfJoints(model, trajectory), sensor, coordinates=task,
        own_state=False, shift_acceleration=True,
    )  # fmt: skip


def _hybrid(job: Job, model: Robot, trajectory: Trajectory, plant: Plant, task: TaskCoordinates) -> Law:
    """Motion until the tip touches the surfaces that the plan is on, then force into them until the plan leaves.

    Surfaces that it is on at once, in a corner, are pressed at once: each such set has its own switch, the larger ones
    outside, so that a smaller one acts until all of a larger one are touched.
    """
    law = _task_computed_torque(job, model, trajectory, plant, task)
    faces = [(Face(shape_of(one), task.rows), one.stiffness) for one in job.surface]
    for members in _planned_contacts(job, [face for face, _ in faces], trajectory, model):
        law = _pressing(job, model, trajectory, plant, task, [faces[j] for j in members], law)
    return law


def _planned_contacts(job: Job, faces: list[Face], trajectory: Trajectory, model: Robot) -> list[tuple[int, ...]]:
    """The sets of surfaces that a plan is on at once, small ones first."""
    times = np.linspace(0.0, trajectory.duration, LOOKED_AT)
    p = model.forward_kinematics(trajectory.at(times).u)[:, :3, 3]
    on = np.array([face.surface.distance(p) < REACHED for face in faces]).T
    found = {tuple(int(j) for j in np.flatnonzero(row)) for row in on if row.any()}
    return sorted(found, key=lambda members: (len(members), members))


def _pressing(
    job: Job,
    model: Robot,
    trajectory: Trajectory,
    plant: Plant,
    task: TaskCoordinates,
    faces: list[tuple[Face, float | None]],
    free: Law,
) -> Law:
    """Force into some surfaces while the plan is on all of them, and another law without that contact."""
    own, tip, sensor = job.controller, TipOfJoints(model, trajectory), _sensor(job, plant, task)
    gains = Gains.from_natural_frequency(len(task.rows), own.frequency or FREQUENCY, own.damping or DAMPING)
    normal_force = NORMAL_FORCE if own.normal_force is None else own.normal_force
    integral = FORCE_INTEGRAL if own.force_integral is None else own.force_integral
    normals = [face for face, _ in faces]

    def along(T: PoseMatrix) -> Floats:
        return np.stack([face.along(T) for face in normals])

    def constraint(T: PoseMatrix, V: Floats) -> tuple[Floats, Floats]:
        A, rate = zip(*(face.constraint(T, V) for face in normals), strict=True)
        return np.concatenate(A), np.concatenate(rate)

    force = hybrid_control(
        model, tip, constraint, lambda T: -normal_force * along(T).sum(axis=0), coordinates=task, gains=gains,
        sensor=sensor,
        force_kp=own.force_gain or 0.0, force_ki=integral,
    )  # fmt: skip
    slowing = _slowing(model, trajectory, task, faces)
    shifts = [k for k, row in enumerate(task.rows) if row >= 3]
    return ContactSwitch(
        free=free,
        touching=force if slowing is None else combine(force, TipDamping(model, task, slowing)),
        intended=lambda t: all(face.depth(tip(t).pose) > -REACHED for face in normals),
        sensor=sensor,
        direction=lambda t: -along(tip(t).pose)[:, shifts],
        least=max(TOUCH, 5.0 * job.simulation.noise.force),
    )


def _slowing(
    model: Robot, trajectory: Trajectory, task: TaskCoordinates, faces: list[tuple[Face, float | None]]
) -> Callable[[PoseMatrix], Floats] | None:
    """Damping (m, m) of the tip along the normals of those surfaces that give way; None without any."""
    inertia, start = _inertia(model, trajectory, task), TipOfJoints(model, trajectory)(0.0).pose
    slowed: list[tuple[Face, float]] = []
    for face, stiffness in faces:
        if stiffness is not None:
            n = face.along(start)
            slowed.append((face, 2.0 * CONTACT_DAMPING * np.sqrt(stiffness * max(float(n @ inertia @ n), 0.0))))

    def damping(T: PoseMatrix) -> Floats:
        return sum((b * np.outer(face.along(T), face.along(T)) for face, b in slowed), np.zeros_like(inertia))

    return damping if slowed else None


_MAKERS: dict[str, Callable[[Job, Robot, Trajectory, Plant, TaskCoordinates], Law]] = {
    "task_computed_torque": _task_computed_torque,
    "impedance": _impedance,
    "admittance": _admittance,
    "hybrid": _hybrid,
}


def _inertia(model: Robot, trajectory: Trajectory, task: TaskCoordinates) -> Floats:
    """(m, m) of the tip where the stretch begins."""
    return task_dynamics(model, trajectory.at(0.0).u, coordinates=task).inertia


def _chosen(task: TaskCoordinates, rotations: PerAxis | None, shifts: PerAxis | None, default: Floats) -> Floats:
    """(m,) of rotations and shifts: what the job says, or the default."""
    given = [each for one in (rotations, shifts) for each in (one if isinstance(one, tuple) else (one,) * 3)]
    pairs = ((given[k], value) for k, value in zip(task.rows, default.tolist(), strict=True))
    return np.array([value if said is None else said for said, value in pairs])


def _impedance_of(job: Job, task: TaskCoordinates, inertia: Floats) -> Impedance:
    own, ratio = job.controller, DAMPING if job.controller.damping is None else job.controller.damping
    stiffness = _chosen(task, own.rotational_stiffness, own.tip_stiffness, inertia * FREQUENCY**2)
    damping = _chosen(task, own.rotational_damping, own.tip_damping, 2.0 * ratio * np.sqrt(stiffness * inertia))
    return Impedance.of(len(task.rows), inertia=inertia, damping=damping, stiffness=stiffness)


def _sensor(job: Job, plant: Plant, task: TaskCoordinates) -> TipForceSensor:
    """What the surfaces' force follows from: the state, or the run where one of them is rigid."""
    noise, rigid = job.simulation.noise, any(one.rigid for one in job.surface)
    felt = None if rigid else plant.environment or CombinedEnvironment(())
    return TipForceSensor(plant.robot, felt, task, noise.force, noise.seed)


def environment_of(job: Job, doors: tuple[Door, ...] = ()) -> CombinedEnvironment | None:
    """What acts on the tip of a job: all that it can touch and all that holds it; None of a job without any.

    Args:
        job: with its tables.
        doors: whose handles the tip holds.
    """
    parts: list[Environment] = [solid(one) for one in job.surface if not one.rigid]
    parts += [_hole(one) for one in job.hole]
    parts += doors
    parts += [_guide(one) for one in job.guide]
    return CombinedEnvironment(tuple(parts)) if parts else None


def solid(one: tables.Surface) -> Wall | RoundSurface:
    """A surface that gives way as what pushes the tip."""
    assert one.stiffness is not None
    point, constants = np.array(one.point), (one.stiffness, one.damping, one.friction)
    if one.normal is not None:
        return Wall(point, np.array(one.normal), *constants)
    radius = one.sphere if one.sphere is not None else one.cylinder
    assert radius is not None
    axis = None if one.axis is None else np.array(one.axis)
    return RoundSurface(point, radius, *constants, axis=axis, hollow=one.hollow)


def rigid_surfaces_of(job: Job) -> tuple[RigidSurface, ...]:
    """The surfaces of a job that do not give way, in the order of its file."""
    return tuple(shape_of(one) for one in job.surface if one.rigid)


def shape_of(one: tables.Surface) -> RigidSurface:
    """Where a surface is, as if it did not give way."""
    radius = one.sphere if one.sphere is not None else one.cylinder
    normal, axis = (None if given is None else np.array(given) for given in (one.normal, one.axis))
    return RigidSurface(np.array(one.point), one.restitution or 0.0, normal, radius, axis, one.hollow, one.friction)


def _hole(one: tables.Hole) -> Environment:
    hole = Hole(
        np.array(one.mouth), np.array(one.axis), one.clearance, one.depth, one.chamfer, one.stiffness, one.damping,
        one.friction,
    )  # fmt: skip
    return AtPoints(hole, np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -one.peg]])) if one.peg else hole


def _guide(one: tables.Guide) -> Environment:
    if one.direction is not None:
        return guiding_line(one.point, one.direction, one.stiffness, one.damping)
    assert one.normal is not None
    return guiding_plane(one.point, one.normal, one.stiffness, one.damping)


@dataclass(frozen=True, eq=False, slots=True)
class Face:
    """The side of a surface that the tip touches, as constraint of a law.

    Attributes:
        surface: whose it is; where it is, whether it gives way or not.
        rows: coordinates of the task, as in `TaskCoordinates`.
    """

    surface: RigidSurface
    rows: tuple[int, ...]

    def normal(self, p: Vector3) -> Vector3:
        """(3,) out of the surface at a point (3,)."""
        return self.surface.outward(p)

    def depth(self, T: PoseMatrix) -> float:
        """How deep the tip is in it [m]."""
        return -float(self.surface.distance(T[:3, 3]))

    def along(self, T: PoseMatrix) -> Floats:
        """(m,) the normal at the tip in the coordinates of the task."""
        return np.concatenate([np.zeros(3), self.normal(T[:3, 3])])[list(self.rows)]

    def constraint(self, T: PoseMatrix, V: Floats) -> tuple[Floats, Floats]:
        """A (1, m) and dA/dt (1, m): along a round surface the normal turns as the tip moves."""
        whole = np.zeros(6)
        whole[list(self.rows)] = V
        rate = self.surface.outward_rate(T[:3, 3], whole[3:])
        return self.along(T)[None], np.concatenate([np.zeros(3), rate])[list(self.rows)][None]
