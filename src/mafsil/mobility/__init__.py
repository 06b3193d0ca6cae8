"""Mobility of mechanisms, closed chains and configuration spaces; `mf.mobility(mechanism).explain()`."""

import sys
from types import ModuleType

from numpy.typing import ArrayLike

from mafsil.mobility import library as library
from mafsil.mobility import synthesis as synthesis
from mafsil.mobility import torus as torus
from mafsil.mobility.actuation import Actuation as Actuation
from mafsil.mobility.actuation import ActuationStatus as ActuationStatus
from mafsil.mobility.actuation import actuation as actuation
from mafsil.mobility.actuation import locked_mobility as locked_mobility
from mafsil.mobility.actuation import locked_subsets as locked_subsets
from mafsil.mobility.assembly import AssemblyModes as AssemblyModes
from mafsil.mobility.assembly import AssemblyStatus as AssemblyStatus
from mafsil.mobility.assembly import assembly_modes as assembly_modes
from mafsil.mobility.components import ConfigurationCurves as ConfigurationCurves
from mafsil.mobility.components import CurvesStatus as CurvesStatus
from mafsil.mobility.components import configuration_curves as configuration_curves
from mafsil.mobility.configuration_space import Factor as Factor
from mafsil.mobility.configuration_space import ProductSpace as ProductSpace
from mafsil.mobility.configuration_space import configuration_space as configuration_space
from mafsil.mobility.configuration_space import configuration_space_names as configuration_space_names
from mafsil.mobility.configuration_space import space_named as space_named
from mafsil.mobility.drawing import common_freedoms as common_freedoms
from mafsil.mobility.drawing import drawn_at as drawn_at
from mafsil.mobility.drawing import locked as locked
from mafsil.mobility.drawing import split as split
from mafsil.mobility.existence import Existence as Existence
from mafsil.mobility.existence import ExistenceStatus as ExistenceStatus
from mafsil.mobility.existence import assembled as assembled
from mafsil.mobility.existence import existence as existence
from mafsil.mobility.finite import FiniteMobility as FiniteMobility
from mafsil.mobility.finite import FiniteStatus as FiniteStatus
from mafsil.mobility.finite import finite_mobility as finite_mobility
from mafsil.mobility.finite import generic_mobility as generic_mobility
from mafsil.mobility.four_bar import FourBar as FourBar
from mafsil.mobility.four_bar import FourBarPositions as FourBarPositions
from mafsil.mobility.four_bar import GrashofClass as GrashofClass
from mafsil.mobility.four_bar import PositionStatus as PositionStatus
from mafsil.mobility.gruebler import CountStatus as CountStatus
from mafsil.mobility.gruebler import GrueblerCount as GrueblerCount
from mafsil.mobility.gruebler import count as count
from mafsil.mobility.gruebler import gruebler as gruebler
from mafsil.mobility.instantaneous import IdleFreedom as IdleFreedom
from mafsil.mobility.instantaneous import InstantaneousMobility as InstantaneousMobility
from mafsil.mobility.instantaneous import InstantStatus as InstantStatus
from mafsil.mobility.instantaneous import instantaneous as instantaneous
from mafsil.mobility.joint_coordinates import JointCoordinates as JointCoordinates
from mafsil.mobility.joint_kind import KINDS as KINDS
from mafsil.mobility.joint_kind import Kind as Kind
from mafsil.mobility.linkage import Coupling as Coupling
from mafsil.mobility.linkage import Linkage as Linkage
from mafsil.mobility.linkage_file import read_linkage as read_linkage
from mafsil.mobility.linkage_joint import LinkageJoint as LinkageJoint
from mafsil.mobility.linkage_joint import coincident_joints as coincident_joints
from mafsil.mobility.linkage_joint import joint as joint
from mafsil.mobility.loop_closure import Closure as Closure
from mafsil.mobility.loop_closure import ClosureStatus as ClosureStatus
from mafsil.mobility.loop_closure import body_poses as body_poses
from mafsil.mobility.loop_closure import closed_near as closed_near
from mafsil.mobility.loop_closure import loop_matrix as loop_matrix
from mafsil.mobility.loop_closure import point_position as point_position
from mafsil.mobility.many import mobilities as mobilities
from mafsil.mobility.mechanism_linkage import LinkageLike as LinkageLike
from mafsil.mobility.mechanism_linkage import as_linkage as as_linkage
from mafsil.mobility.mechanism_linkage import linkage_of as linkage_of
from mafsil.mobility.mechanism_linkage import mechanism_of as mechanism_of
from mafsil.mobility.motion_group import Group as Group
from mafsil.mobility.motion_group import MotionGroup as MotionGroup
from mafsil.mobility.motion_group import motion_group as motion_group
from mafsil.mobility.pfaffian import Integrability as Integrability
from mafsil.mobility.pfaffian import IntegrabilityAnswer as IntegrabilityAnswer
from mafsil.mobility.pfaffian import Pfaffian as Pfaffian
from mafsil.mobility.pfaffian import lie_bracket as lie_bracket
from mafsil.mobility.planar_joints import SecondBody as SecondBody
from mafsil.mobility.planar_joints import joint_residual as joint_residual
from mafsil.mobility.planar_joints import second_body as second_body
from mafsil.mobility.planar_positions import PolygonSpace as PolygonSpace
from mafsil.mobility.planar_positions import PolygonStatus as PolygonStatus
from mafsil.mobility.planar_positions import circle_crossings as circle_crossings
from mafsil.mobility.planar_positions import circle_gap as circle_gap
from mafsil.mobility.planar_positions import polygon_space as polygon_space
from mafsil.mobility.redundancy import LoopCause as LoopCause
from mafsil.mobility.redundancy import Redundancy as Redundancy
from mafsil.mobility.redundancy import RedundancyStatus as RedundancyStatus
from mafsil.mobility.redundancy import redundancy as redundancy
from mafsil.mobility.report import Mobility as Mobility
from mafsil.mobility.report import MobilityStatus as MobilityStatus
from mafsil.mobility.report import body_rates as body_rates
from mafsil.mobility.report import mobility as mobility
from mafsil.mobility.report import rates as rates
from mafsil.mobility.rigid_points import BodyPoints as BodyPoints
from mafsil.mobility.rigid_points import PointCount as PointCount
from mafsil.mobility.rigid_points import body_of_points as body_of_points
from mafsil.mobility.rigid_points import count_points as count_points
from mafsil.mobility.rigid_points import explicit_body as explicit_body
from mafsil.mobility.rigid_points import implicit_body as implicit_body
from mafsil.mobility.rigid_points import planar_angle as planar_angle
from mafsil.mobility.rigid_points import planar_body as planar_body
from mafsil.mobility.rigid_points import planar_residual as planar_residual
from mafsil.mobility.rigid_points import points_of_body as points_of_body
from mafsil.mobility.rigid_points import third_point as third_point
from mafsil.mobility.slider_crank import SliderCrank as SliderCrank
from mafsil.mobility.slider_crank import SliderCrankPositions as SliderCrankPositions
from mafsil.mobility.slider_crank import SliderStatus as SliderStatus
from mafsil.mobility.structure import Structure as Structure
from mafsil.mobility.structure import StructureStatus as StructureStatus
from mafsil.mobility.structure import structure as structure
from mafsil.mobility.surface import Surface as Surface
from mafsil.mobility.surface import SurfaceStatus as SurfaceStatus
from mafsil.mobility.surface import trace_surface as trace_surface
from mafsil.mobility.surfaces import ConfigurationSurfaces as ConfigurationSurfaces
from mafsil.mobility.surfaces import SurfacesStatus as SurfacesStatus
from mafsil.mobility.surfaces import configuration_surfaces as configuration_surfaces
from mafsil.mobility.synthesis.answers import Synthesis as Synthesis
from mafsil.mobility.synthesis.function import synthesise_function as synthesise_function
from mafsil.mobility.synthesis.motion import synthesise_motion as synthesise_motion
from mafsil.mobility.synthesis.path import synthesise_path as synthesise_path
from mafsil.mobility.task_space import SphereBand as SphereBand
from mafsil.mobility.task_space import angles_of_direction as angles_of_direction
from mafsil.mobility.task_space import annulus as annulus
from mafsil.mobility.task_space import direction_of as direction_of
from mafsil.mobility.task_space import fibre as fibre
from mafsil.mobility.task_space import spatial_2r as spatial_2r
from mafsil.mobility.task_space import task_redundancy as task_redundancy
from mafsil.mobility.tracing import Trace as Trace
from mafsil.mobility.tracing import TraceStatus as TraceStatus
from mafsil.mobility.tracing import trace as trace
from mafsil.mobility.wheels import Car as Car
from mafsil.mobility.wheels import Cart as Cart
from mafsil.mobility.wheels import Coin as Coin
from mafsil.mobility.wheels import Unicycle as Unicycle


class _CallableModule(ModuleType):
    """The package can be called: `mf.mobility(mechanism)` is `mf.mobility.mobility(mechanism)`."""

    def __call__(
        self, source: LinkageLike, q: ArrayLike | None = None, *, rule: str | None = None, seed: int = 0
    ) -> Mobility:
        """Arguments as `mafsil.mobility.report.mobility`."""
        return mobility(source, q, rule=rule, seed=seed)


sys.modules[__name__].__class__ = _CallableModule
