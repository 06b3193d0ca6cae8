"""Planning: paths that meet nothing, among polygons, for arms, in any number of coordinates; several robots in time."""

from mafsil.planning.arm_plan import ArmPlan as ArmPlan
from mafsil.planning.arm_planning import plan as plan
from mafsil.planning.configuration_space import PlanarArm as PlanarArm
from mafsil.planning.configuration_space import configuration_space as configuration_space
from mafsil.planning.configuration_space import planar_arm as planar_arm
from mafsil.planning.coordination import Coordination as Coordination
from mafsil.planning.coordination import CoordinationStatus as CoordinationStatus
from mafsil.planning.coordination import avoid_moving as avoid_moving
from mafsil.planning.coordination import coordinate as coordinate
from mafsil.planning.navigation import NavigationFunction as NavigationFunction
from mafsil.planning.navigation import navigation_function as navigation_function
from mafsil.planning.outcome import Plan as Plan
from mafsil.planning.outcome import PlanningStatus as PlanningStatus
from mafsil.planning.pipeline import find_path as find_path
from mafsil.planning.polygons import PolygonWorld as PolygonWorld
from mafsil.planning.polygons import minkowski_sum as minkowski_sum
from mafsil.planning.potential_field import PotentialField as PotentialField
from mafsil.planning.potential_field import disc as disc
from mafsil.planning.problem import Problem as Problem
from mafsil.planning.quadtree import Quadtree as Quadtree
from mafsil.planning.quadtree import quadtree as quadtree
from mafsil.planning.search import PLANNERS as PLANNERS
from mafsil.planning.search import Budget as Budget
from mafsil.planning.search import Planner as Planner
from mafsil.planning.shortening import shortened as shortened
from mafsil.planning.visibility import visibility_path as visibility_path
