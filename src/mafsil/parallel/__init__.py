"""Parallel robots: platforms on legs, their poses, forces and singularities."""

from mafsil.parallel.assembly_modes import AssemblyModes as AssemblyModes
from mafsil.parallel.assembly_modes import AssemblyModesStatus as AssemblyModesStatus
from mafsil.parallel.forward_pose import ForwardPoses as ForwardPoses
from mafsil.parallel.forward_pose import ForwardStatus as ForwardStatus
from mafsil.parallel.planar_legs import PlanarThreeRPR as PlanarThreeRPR
from mafsil.parallel.planar_legs import PlanarThreeRRR as PlanarThreeRRR
from mafsil.parallel.planar_poses import PlanarPoses as PlanarPoses
from mafsil.parallel.planar_poses import PlanarPosesStatus as PlanarPosesStatus
from mafsil.parallel.platform_modes import stewart_assembly_modes as stewart_assembly_modes
from mafsil.parallel.singular_kinds import SingularKind as SingularKind
from mafsil.parallel.singular_kinds import SingularKinds as SingularKinds
from mafsil.parallel.stewart import StewartPlatform as StewartPlatform
