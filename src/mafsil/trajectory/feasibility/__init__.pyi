from mafsil.trajectory.feasibility.diagnosis import Diagnosis as Diagnosis
from mafsil.trajectory.feasibility.diagnosis import Obstruction as Obstruction
from mafsil.trajectory.feasibility.diagnosis import Remedy as Remedy
from mafsil.trajectory.feasibility.diagnosis import RemedyKind as RemedyKind
from mafsil.trajectory.feasibility.diagnosis import suggest_fixes as suggest_fixes
from mafsil.trajectory.feasibility.request import MotionRequest as MotionRequest
