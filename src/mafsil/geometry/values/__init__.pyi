from mafsil.geometry.values.point import METRES as METRES
from mafsil.geometry.values.point import Point as Point
from mafsil.geometry.values.point import Vector as Vector
from mafsil.geometry.values.pose import Pose as Pose
from mafsil.geometry.values.rotation import Rotation as Rotation
from mafsil.geometry.values.screw_axis import ScrewAxis as ScrewAxis
from mafsil.geometry.values.twist import Twist as Twist
from mafsil.geometry.values.wrench import Wrench as Wrench
