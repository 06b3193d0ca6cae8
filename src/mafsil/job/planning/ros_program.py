"""The plan of a job for ROS 2: one JointTrajectory of the whole cycle, and its obstacles as a scene of MoveIt.

Reference: the messages trajectory_msgs/JointTrajectory, moveit_msgs/PlanningScene and shape_msgs/SolidPrimitive.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.collision import Box, Capsule, Cone, ConvexHull, Cylinder, Obstacle, Plane, Sphere, TriangleMesh
from mafsil.errors import InputError
from mafsil.geometry.quaternion import to_quaternion
from mafsil.job.language.description import Job
from mafsil.job.planning.controller_program import Program, language_of, write_program
from mafsil.job.planning.instructions import lost_keys
from mafsil.job.planning.plan import Leg, Plan
from mafsil.job.remark import Remark
from mafsil.messages.visible import visible
from mafsil.model.mesh.surface import hull_surface
from mafsil.trajectory import sequence
from mafsil.trajectory.files.exporting import as_yaml, sample_trajectory

ENDINGS = (".yaml", ".yml")
RATE = 125.0
"""Points of the trajectory per second [Hz]; a controller of ros2_control joins them by quintics."""
LOST = ("until", "until_force", "process_wrench")
"""Keys of moves that neither the trajectory nor its comments say."""
BOX, SPHERE, CYLINDER, CONE = 1, 2, 3, 4
"""Types of shape_msgs/SolidPrimitive."""


def program_for(job: Job, plan: Plan, ending: str) -> Program:
    """The plan of a job as a program of a controller, in the language of a file's ending.

    Args:
        job, plan: of an arm without loops.
        ending: such as `.script`, `.src`, `.mod`, `.yaml`.

    Raises:
        InputError: an ending of no language, a robot that the controller does not drive.
    """
    if ending.lower() in ENDINGS:
        return _ros_program(job, plan)
    return write_program(job, plan, language_of(ending, ENDINGS))


def _ros_program(job: Job, plan: Plan) -> Program:
    robot = plan.legs[0].load.robot
    if robot.mechanism.loops:
        raise InputError("job.program_loops")
    samples = sample_trajectory(sequence(*(leg.trajectory for leg in plan.legs)), robot.joint_names, RATE)
    events = [event for leg, start in zip(plan.legs, plan.starts, strict=False) for event in _events(job, leg, start)]
    comments = "".join(f"# at {time:.6g} s: {words}\n" for time, words in events)
    lost = [Remark("warning", "job.program_events", {"count": len(events)})] if events else []
    lost += [remark for leg in plan.legs for remark in lost_keys(job, leg, LOST)]
    obstacles = () if plan.surroundings is None else plan.surroundings.obstacles
    objects = {each.name: _collision_object(each, robot.mechanism.links[0].name) for each in obstacles}
    lost += [
        Remark("warning", "job.program_obstacle", {"name": visible(name)}) for name, one in objects.items() if not one
    ]
    text = comments + as_yaml(samples).decode()
    return Program(text, len(samples.t), tuple(lost), _scene([one for one in objects.values() if one]))


def _events(job: Job, leg: Leg, start: float) -> Iterator[tuple[float, str]]:
    """What happens beside the motion: signals, loads and tools, at times of the trajectory [s]."""
    move = job.move[leg.index]
    if leg.kind in ("set", "wait"):
        values = move.set if leg.kind == "set" else move.wait
        yield start, f"{leg.kind} " + ", ".join(f"{visible(name)} = {value}" for name, value in values.items())
    elif leg.kind in ("pick", "place", "tool", "if"):
        yield start, f"{leg.kind} {visible(leg.name)}".strip()
    for after, values in leg.outputs:
        yield start + after, "set " + ", ".join(f"{visible(name)} = {value}" for name, value in values.items())


def _scene(objects: list[dict[str, Any]]) -> str:
    """A moveit_msgs/PlanningScene that adds objects; empty without them."""
    import yaml  # the reader and writer of YAML takes a tenth of a second

    if not objects:
        return ""
    message = {"name": "mafsil job", "is_diff": True, "world": {"collision_objects": objects}}
    return str(yaml.safe_dump(message, sort_keys=False, default_flow_style=None, width=120))


def _collision_object(obstacle: Obstacle, frame: str) -> dict[str, Any]:
    """A moveit_msgs/CollisionObject in the frame of the robot's base; empty where MoveIt has no such shape."""
    shapes = _shapes(obstacle)
    if not shapes:
        return {}
    return {"header": {"frame_id": frame}, "id": obstacle.name, "pose": _pose(np.eye(4))} | shapes


def _shapes(obstacle: Obstacle) -> dict[str, Any]:
    shape, T = obstacle.geometry, obstacle.T_so
    match shape:
        case Box():
            return _primitives((BOX, shape.size, T))
        case Sphere():
            return _primitives((SPHERE, [shape.radius], T))
        case Cylinder():
            return _primitives((CYLINDER, [shape.length, shape.radius], T))
        case Cone():
            return _primitives((CONE, [shape.length, shape.radius], T))
        case Capsule():
            ends = [T @ _shift(side * 0.5 * shape.length) for side in (-1.0, 1.0)]
            balls = [(SPHERE, [shape.radius], end) for end in ends]
            return _primitives((CYLINDER, [shape.length, shape.radius], T), *balls)
        case Plane():
            return {"planes": [{"coef": [0.0, 0.0, 1.0, 0.0]}], "plane_poses": [_pose(T)]}
        case TriangleMesh():
            return _mesh(shape.vertices, shape.faces, T)
        case ConvexHull() if shape.rounding == 0.0:
            surface = hull_surface(shape.points)
            return {} if surface is None else _mesh(surface.vertices, surface.faces, T)
        case _:
            return {}


def _primitives(*solids: tuple[int, Any, PoseMatrix]) -> dict[str, Any]:
    return {
        "primitives": [{"type": kind, "dimensions": [float(size) for size in sizes]} for kind, sizes, _ in solids],
        "primitive_poses": [_pose(T) for _, _, T in solids],
    }


def _mesh(vertices: Floats, faces: Any, T: PoseMatrix) -> dict[str, Any]:
    triangles = [{"vertex_indices": face} for face in np.asarray(faces).tolist()]
    points = [dict(zip("xyz", point, strict=True)) for point in vertices.tolist()]
    return {"meshes": [{"triangles": triangles, "vertices": points}], "mesh_poses": [_pose(T)]}


def _pose(T: PoseMatrix) -> dict[str, Any]:
    w, *xyz = np.asarray(to_quaternion(T[:3, :3])).tolist()
    return {
        "position": dict(zip("xyz", T[:3, 3].tolist(), strict=True)),
        "orientation": dict(zip("xyzw", [*xyz, w], strict=True)),
    }


def _shift(z: float) -> PoseMatrix:
    T = np.eye(4)
    T[2, 3] = z
    return T
