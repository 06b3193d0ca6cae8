from mafsil.geometry.values.pose import METRES as METRES
from mafsil.geometry.values.pose import Point as Point
from mafsil.geometry.values.pose import Pose as Pose
from mafsil.geometry.values.pose import Rotation as Rotation
from mafsil.geometry.values.pose import Vector as Vector
from mafsil.geometry.values.twist import ScrewAxis as ScrewAxis
from mafsil.geometry.values.twist import Twist as Twist
from mafsil.geometry.values.twist import Wrench as Wrench
