"""Arms of six joints without a special shape: all solutions, up to sixteen, of whole batches of poses."""

from mafsil.ik.general.solver import GeneralSix as GeneralSix
from mafsil.ik.general.solver import GeneralSolutions as GeneralSolutions
