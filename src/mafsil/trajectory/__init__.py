"""Motions in time: polynomials, trapezoids, Cartesian lines, sequences, and their checks."""

from mafsil.trajectory.cartesian_line import cartesian_line as cartesian_line
from mafsil.trajectory.cartesian_path import CartesianPath as CartesianPath
from mafsil.trajectory.laws import LAWS as LAWS
from mafsil.trajectory.laws import PolynomialLaw as PolynomialLaw
from mafsil.trajectory.laws import TimeLaw as TimeLaw
from mafsil.trajectory.limit_check import LimitCheck as LimitCheck
from mafsil.trajectory.limit_check import Violation as Violation
from mafsil.trajectory.limit_check import check as check
from mafsil.trajectory.motion import Motion as Motion
from mafsil.trajectory.motion import Trajectory as Trajectory
from mafsil.trajectory.motion_limits import MotionLimits as MotionLimits
from mafsil.trajectory.path import JointPath as JointPath
from mafsil.trajectory.path_following import follow as follow
from mafsil.trajectory.path_motion import PathMotion as PathMotion
from mafsil.trajectory.piecewise import PiecewisePolynomial as PiecewisePolynomial
from mafsil.trajectory.polynomial import cubic as cubic
from mafsil.trajectory.polynomial import cubic_through as cubic_through
from mafsil.trajectory.polynomial import quintic as quintic
from mafsil.trajectory.polynomial import rest as rest
from mafsil.trajectory.sequence import Sequence as Sequence
from mafsil.trajectory.sequence import sequence as sequence
from mafsil.trajectory.status import LimitStatus as LimitStatus
from mafsil.trajectory.status import PlanStatus as PlanStatus
from mafsil.trajectory.trapezoid import trapezoid as trapezoid
