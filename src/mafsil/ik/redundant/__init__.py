"""Arms with seven joints: postures by arm angle or by a held joint, and the intervals in which they exist."""

from mafsil.ik.redundant.form import PostureFamily as PostureFamily
from mafsil.ik.redundant.form import Postures as Postures
from mafsil.ik.redundant.form import Redundancy as Redundancy
from mafsil.ik.redundant.form import redundancy as redundancy
