"""One controlled joint in closed form: error dynamics, stability, responses, gains, drives, friction, sampled loops."""

from mafsil.one_joint.error_dynamics import ErrorDynamics as ErrorDynamics
from mafsil.one_joint.gain_design import DesignedGains as DesignedGains
from mafsil.one_joint.gain_design import DesignStatus as DesignStatus
from mafsil.one_joint.gain_design import gains_from_roots as gains_from_roots
from mafsil.one_joint.gain_design import ki_limit as ki_limit
from mafsil.one_joint.gain_design import kp_for_damping_ratio as kp_for_damping_ratio
from mafsil.one_joint.gain_design import kp_for_rest_error as kp_for_rest_error
from mafsil.one_joint.gain_design import pd_for_settling as pd_for_settling
from mafsil.one_joint.polynomial import roots as roots
from mafsil.one_joint.routh import Stability as Stability
from mafsil.one_joint.routh import StabilityStatus as StabilityStatus
from mafsil.one_joint.routh import routh_hurwitz as routh_hurwitz
from mafsil.one_joint.second_order import Damping as Damping
from mafsil.one_joint.second_order import SecondOrder as SecondOrder
from mafsil.one_joint.steady_error import RestError as RestError
from mafsil.one_joint.steady_error import RestStatus as RestStatus
from mafsil.one_joint.steady_error import TrackingError as TrackingError
from mafsil.one_joint.steady_error import rest_of_joints as rest_of_joints
from mafsil.one_joint.steady_error import rest_under_gravity as rest_under_gravity
