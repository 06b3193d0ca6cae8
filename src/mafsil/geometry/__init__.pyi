from mafsil.geometry.frames import FrameGraph as FrameGraph
from mafsil.geometry.values import Point as Point
from mafsil.geometry.values import Pose as Pose
from mafsil.geometry.values import Rotation as Rotation
from mafsil.geometry.values import ScrewAxis as ScrewAxis
from mafsil.geometry.values import Twist as Twist
from mafsil.geometry.values import Vector as Vector
from mafsil.geometry.values import Wrench as Wrench
