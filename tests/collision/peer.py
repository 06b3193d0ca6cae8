"""The same bodies in coal, and random poses."""

from __future__ import annotations

import coal
import numpy as np

from mafsil import collision
from mafsil.collision.pairs import still_shapes
from mafsil.geometry import rotation

POINTS = np.random.default_rng(5).normal(size=(30, 3)) * 0.2


def coal_hull(points):
    """The convex hull of points."""
    list_of_points = coal.StdVec_Vec3s()
    for point in points:
        list_of_points.append(np.asarray(point, float))
    return coal.Convex.convexHull(list_of_points, True, "Qt")


BODIES = {
    "sphere": (collision.Sphere(0.3), coal.Sphere(0.3)),
    "capsule": (collision.Capsule(0.1, 0.6), coal.Capsule(0.1, 0.6)),
    "box": (collision.Box((0.3, 0.5, 0.7)), coal.Box(0.3, 0.5, 0.7)),
    "cylinder": (collision.Cylinder(0.2, 0.6), coal.Cylinder(0.2, 0.6)),
    "cone": (collision.Cone(0.2, 0.6), coal.Cone(0.2, 0.6)),
    "hull": (collision.ConvexHull(POINTS), coal_hull(POINTS)),
    "plane": (collision.Plane(), coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)),
}
SIZE = 0.6
ROUND = ("cylinder", "cone")


def random_poses(count: int, size: float, seed: int):
    """(count, 4, 4) poses with positions within `size` of the origin along each axis."""
    rng = np.random.default_rng(seed)
    w = rng.normal(size=(count, 4))
    T = np.tile(np.eye(4), (count, 1, 1))
    T[:, :3, :3] = rotation.from_quaternion(w / np.linalg.norm(w, axis=1, keepdims=True))
    T[:, :3, 3] = rng.uniform(-size, size, (count, 3))
    return T


def coal_pose(T):
    return coal.Transform3s(np.array(T[:3, :3]), np.array(T[:3, 3]))


def coal_distance(a, T_a, b, T_b) -> float:
    """Signed distance by coal, its tolerances as tight as they go."""
    request, result = coal.DistanceRequest(True, True), coal.DistanceResult()
    return coal.distance(a, coal_pose(T_a), b, coal_pose(T_b), request, result)


def coal_shape(geometry):
    """One of our convex geometries in coal."""
    match geometry:
        case collision.Sphere(radius=r):
            return coal.Sphere(r)
        case collision.Capsule(radius=r, length=h):
            return coal.Capsule(r, h)
        case collision.Cylinder(radius=r, length=h):
            return coal.Cylinder(r, h)
        case collision.Cone(radius=r, length=h):
            return coal.Cone(r, h)
        case collision.Box(size=size):
            return coal.Box(*size)
        case collision.Plane():
            return coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)
        case collision.ConvexHull(points=points):
            return coal_hull(points)


class CoalChecker:
    """Every pair of shapes of an arm and a scene by coal, one after another; poses come from our link poses."""

    def __init__(self, checker: collision.Checker):
        self.checker = checker
        self.shapes = [[(coal_shape(g), T) for g, T in body.shapes] for body in checker.bodies]
        self.obstacles = [(coal_shape(each.geometry), each.T_so) for each in checker.scene]
        self.pairs = checker.arm.pairs

    def distance(self, q) -> float:
        """The smallest signed distance."""
        poses = self.checker.robot.link_poses(q)
        placed = [
            [(shape, poses[body.link] @ T) for shape, T in shapes]
            for body, shapes in zip(self.checker.bodies, self.shapes, strict=True)
        ]
        best = np.inf
        still = still_shapes(self.checker.robot.mechanism, self.checker.bodies)
        for shapes, fixed in zip(placed, still, strict=True):
            for (a, T_a), stays in zip(shapes, fixed, strict=True):
                # What no joint moves is not checked against what stands still.
                for b, T_b in () if stays else self.obstacles:
                    best = min(best, coal_distance(a, T_a, b, T_b))
        for i, j in self.pairs:
            for a, T_a in placed[i]:
                for b, T_b in placed[j]:
                    best = min(best, coal_distance(a, T_a, b, T_b))
        return best
