"""Closed loops in time: plant, law, disturbances, and the recording they leave."""

from mafsil.simulation.disturbance import SensorNoise as SensorNoise
from mafsil.simulation.disturbance import WrenchPulse as WrenchPulse
from mafsil.simulation.loop import simulate as simulate
from mafsil.simulation.motion import ForwardMotion as ForwardMotion
from mafsil.simulation.motion import FreeBodyMotion as FreeBodyMotion
from mafsil.simulation.motion import InverseMotion as InverseMotion
from mafsil.simulation.motion import Sampled as Sampled
from mafsil.simulation.motion import forward_dynamics_trajectory as forward_dynamics_trajectory
from mafsil.simulation.motion import free_body_motion as free_body_motion
from mafsil.simulation.motion import inverse_dynamics_trajectory as inverse_dynamics_trajectory
from mafsil.simulation.plant import Plant as Plant
from mafsil.simulation.recording import Recording as Recording
from mafsil.simulation.recording import SimulationStatus as SimulationStatus
from mafsil.simulation.scenario import Scenario as Scenario
from mafsil.simulation.stepping import INTEGRATORS as INTEGRATORS
from mafsil.simulation.stepping import suitable_integrator as suitable_integrator
