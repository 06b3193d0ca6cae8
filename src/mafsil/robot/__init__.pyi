from mafsil.robot.loading import OpenTree as OpenTree
from mafsil.robot.loading import as_open_tree as as_open_tree
from mafsil.robot.loading import as_robot as as_robot
from mafsil.robot.loading import load as load
from mafsil.robot.loading import of_robot as of_robot
from mafsil.robot.robot import Robot as Robot
