"""Paths of a frame without time: curves of its origin, orientation laws side by side, blends of corners."""

from mafsil.trajectory.paths.build import Orientation as Orientation
from mafsil.trajectory.paths.build import arc_path as arc_path
from mafsil.trajectory.paths.build import circle_path as circle_path
from mafsil.trajectory.paths.build import joined_path as joined_path
from mafsil.trajectory.paths.build import line_path as line_path
from mafsil.trajectory.paths.build import screw_path as screw_path
from mafsil.trajectory.paths.build import spline_path as spline_path
from mafsil.trajectory.paths.joined import CornerBlend as CornerBlend
from mafsil.trajectory.paths.joined import JoinedPath as JoinedPath
from mafsil.trajectory.paths.pose_path import PosePath as PosePath
from mafsil.trajectory.paths.pose_path import TipPath as TipPath
