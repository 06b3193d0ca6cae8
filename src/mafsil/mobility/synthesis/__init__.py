"""Dimensional synthesis of planar four-bars and slider-cranks: for poses, for paths with timing, for functions."""

from mafsil.mobility.synthesis.answers import Ranking as Ranking
from mafsil.mobility.synthesis.answers import Synthesis as Synthesis
from mafsil.mobility.synthesis.answers import SynthesisStatus as SynthesisStatus
from mafsil.mobility.synthesis.burmester import BurmesterCurves as BurmesterCurves
from mafsil.mobility.synthesis.burmester import burmester_curves as burmester_curves
from mafsil.mobility.synthesis.candidate import Candidate as Candidate
from mafsil.mobility.synthesis.candidate import CandidateStatus as CandidateStatus
from mafsil.mobility.synthesis.dyads import Dyad as Dyad
from mafsil.mobility.synthesis.dyads import DyadKind as DyadKind
from mafsil.mobility.synthesis.function import synthesise_function as synthesise_function
from mafsil.mobility.synthesis.function_task import FunctionTask as FunctionTask
from mafsil.mobility.synthesis.function_task import StructuralError as StructuralError
from mafsil.mobility.synthesis.function_task import chebyshev_spacing as chebyshev_spacing
from mafsil.mobility.synthesis.many_poses import ManyDyads as ManyDyads
from mafsil.mobility.synthesis.many_poses import five_pose_dyads as five_pose_dyads
from mafsil.mobility.synthesis.motion import synthesise_motion as synthesise_motion
from mafsil.mobility.synthesis.path import synthesise_path as synthesise_path
from mafsil.mobility.synthesis.task_file import synthesise_file as synthesise_file
