"""Inverse kinematics: joint vectors that bring a frame to a wanted pose, with honest verdicts."""

from mafsil.ik.analysis import closed_form as closed_form
from mafsil.ik.answers import Branch as Branch
from mafsil.ik.answers import LimitExcess as LimitExcess
from mafsil.ik.answers import SolutionBatch as SolutionBatch
from mafsil.ik.answers import SolutionFamily as SolutionFamily
from mafsil.ik.answers import SolutionSet as SolutionSet
from mafsil.ik.answers import Verdict as Verdict
from mafsil.ik.closed_form import Branches as Branches
from mafsil.ik.closed_form import ClosedForm as ClosedForm
from mafsil.ik.inverse import inverse_kinematics as inverse_kinematics
from mafsil.ik.newton import NewtonRecord as NewtonRecord
from mafsil.ik.newton import newton_ik as newton_ik
from mafsil.ik.numerical import solve_ik as solve_ik
from mafsil.ik.rates import Rates as Rates
from mafsil.ik.rates import integrate_rates as integrate_rates
from mafsil.ik.rates import joint_rates as joint_rates
from mafsil.ik.rates import prioritised_rates as prioritised_rates
from mafsil.ik.rates import task_jacobian as task_jacobian
from mafsil.ik.result import IKResult as IKResult
from mafsil.ik.result import IKStatus as IKStatus
from mafsil.ik.subproblems import distances as distances
from mafsil.ik.subproblems import two_axes as two_axes
from mafsil.ik.subproblems import wrist_angles as wrist_angles
from mafsil.ik.tracking import Switch as Switch
from mafsil.ik.tracking import Track as Track
from mafsil.ik.tracking import track as track
