from mafsil.simulation.motion.forward import ForwardMotion as ForwardMotion
from mafsil.simulation.motion.forward import forward_dynamics_trajectory as forward_dynamics_trajectory
from mafsil.simulation.motion.free_body import FreeBodyMotion as FreeBodyMotion
from mafsil.simulation.motion.free_body import free_body_motion as free_body_motion
from mafsil.simulation.motion.inverse import InverseMotion as InverseMotion
from mafsil.simulation.motion.inverse import differentiate as differentiate
from mafsil.simulation.motion.inverse import inverse_dynamics_trajectory as inverse_dynamics_trajectory
from mafsil.simulation.motion.system import Sampled as Sampled
