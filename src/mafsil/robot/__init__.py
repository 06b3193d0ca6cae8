"""Description and machine code together: load a robot, call its quantities."""

from mafsil.robot.loading import load as load
from mafsil.robot.loading import load_mechanism as load_mechanism
from mafsil.robot.robot import Robot as Robot
