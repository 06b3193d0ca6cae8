"""Collision of arms with what stands around them and with themselves; `mf.collision.Checker(robot, scene).check(q)`."""

from mafsil.collision.checker import Checker as Checker
from mafsil.collision.pairs import Reason as Reason
from mafsil.collision.pairs import SkippedPair as SkippedPair
from mafsil.collision.path_check import PathCheck as PathCheck
from mafsil.collision.path_check import PathStatus as PathStatus
from mafsil.collision.scene import Obstacle as Obstacle
from mafsil.collision.scene import Scene as Scene
from mafsil.collision.separation import Separation as Separation
from mafsil.collision.separation import SeparationStatus as SeparationStatus
from mafsil.collision.separation import distance as distance
from mafsil.collision.shapes import Cone as Cone
from mafsil.collision.shapes import ConvexHull as ConvexHull
from mafsil.collision.shapes import HeightMap as HeightMap
from mafsil.collision.shapes import Plane as Plane
from mafsil.collision.shapes import PointCloud as PointCloud
from mafsil.collision.shapes import TriangleMesh as TriangleMesh
from mafsil.collision.status import Check as Check
from mafsil.collision.status import CheckStatus as CheckStatus
from mafsil.collision.status import Clearance as Clearance
from mafsil.collision.status import Contact as Contact
from mafsil.model.shape import Box as Box
from mafsil.model.shape import Capsule as Capsule
from mafsil.model.shape import Cylinder as Cylinder
from mafsil.model.shape import Sphere as Sphere
