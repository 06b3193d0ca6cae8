"""Parallel robots: platforms on legs, their poses, forces and singularities."""

from mafsil.parallel.assembly_modes import AssemblyModes as AssemblyModes
from mafsil.parallel.assembly_modes import AssemblyModesStatus as AssemblyModesStatus
from mafsil.parallel.forward_pose import ForwardPoses as ForwardPoses
from mafsil.parallel.forward_pose import ForwardStatus as ForwardStatus
from mafsil.parallel.platform_modes import stewart_assembly_modes as stewart_assembly_modes
from mafsil.parallel.stewart import StewartPlatform as StewartPlatform
