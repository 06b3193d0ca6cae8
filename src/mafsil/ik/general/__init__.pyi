from mafsil.ik.general.solver import GeneralSix as GeneralSix
from mafsil.ik.general.solver import GeneralSolutions as GeneralSolutions
