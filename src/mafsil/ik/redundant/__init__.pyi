from mafsil.ik.redundant.form import Redundancy as Redundancy
from mafsil.ik.redundant.form import SelfMotionFamily as SelfMotionFamily
from mafsil.ik.redundant.form import redundancy as redundancy
from mafsil.ik.redundant.parametric_form import ParametricSolutions as ParametricSolutions
