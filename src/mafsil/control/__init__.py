"""Control laws: time, measured state and reference in, joint efforts out."""

from mafsil.control.computed_torque import ComputedTorque as ComputedTorque
from mafsil.control.computed_torque import computed_torque as computed_torque
from mafsil.control.gains import Gains as Gains
from mafsil.control.inertia_gains import inertia_gains as inertia_gains
from mafsil.control.joint_feedback import Feedforward as Feedforward
from mafsil.control.joint_feedback import JointFeedback as JointFeedback
from mafsil.control.joint_feedback import feedforward as feedforward
from mafsil.control.joint_feedback import gravity_compensation as gravity_compensation
from mafsil.control.joint_feedback import pid as pid
from mafsil.control.law import Combined as Combined
from mafsil.control.law import Law as Law
from mafsil.control.law import combined as combined
from mafsil.control.law import saturated as saturated
