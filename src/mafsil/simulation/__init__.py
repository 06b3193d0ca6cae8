"""Closed loops in time: plant, law, disturbances, and the recording they leave."""

from mafsil.simulation.disturbance import SensorNoise as SensorNoise
from mafsil.simulation.disturbance import WrenchPulse as WrenchPulse
from mafsil.simulation.loop import simulate as simulate
from mafsil.simulation.plant import Plant as Plant
from mafsil.simulation.recording import Recording as Recording
from mafsil.simulation.recording import SimulationStatus as SimulationStatus
from mafsil.simulation.scenario import Scenario as Scenario
