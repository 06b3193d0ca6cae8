"""Parallel robots: platforms on legs, their poses, forces and singularities."""

from mafsil.parallel.assembly_modes import AssemblyModes as AssemblyModes
from mafsil.parallel.assembly_modes import AssemblyModesStatus as AssemblyModesStatus
from mafsil.parallel.closure import DrivenRates as DrivenRates
from mafsil.parallel.closure import driven_rates as driven_rates
from mafsil.parallel.five_bar import FiveBar as FiveBar
from mafsil.parallel.forward_pose import ForwardPoses as ForwardPoses
from mafsil.parallel.forward_pose import ForwardStatus as ForwardStatus
from mafsil.parallel.four_bar_curve import FourBarPoint as FourBarPoint
from mafsil.parallel.four_bar_curve import output_angles as output_angles
from mafsil.parallel.four_bar_curve import singular_points as singular_points
from mafsil.parallel.loop_singularity import LoopSingularities as LoopSingularities
from mafsil.parallel.loop_singularity import LoopSingularity as LoopSingularity
from mafsil.parallel.loop_singularity import good_motors as good_motors
from mafsil.parallel.parallel_cranks import ParallelCranks as ParallelCranks
from mafsil.parallel.planar_chain import PlanarChain as PlanarChain
from mafsil.parallel.planar_legs import PlanarThreeRPR as PlanarThreeRPR
from mafsil.parallel.planar_legs import PlanarThreeRRR as PlanarThreeRRR
from mafsil.parallel.planar_poses import PlanarPoses as PlanarPoses
from mafsil.parallel.planar_poses import PlanarPosesStatus as PlanarPosesStatus
from mafsil.parallel.platform_modes import stewart_assembly_modes as stewart_assembly_modes
from mafsil.parallel.singular_kinds import SingularKind as SingularKind
from mafsil.parallel.singular_kinds import SingularKinds as SingularKinds
from mafsil.parallel.stewart import StewartPlatform as StewartPlatform
