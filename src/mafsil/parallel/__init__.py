"""Parallel robots: platforms on legs, their poses, forces and singularities."""

from mafsil.parallel.forward_pose import ForwardPoses as ForwardPoses
from mafsil.parallel.forward_pose import ForwardStatus as ForwardStatus
from mafsil.parallel.stewart import StewartPlatform as StewartPlatform
