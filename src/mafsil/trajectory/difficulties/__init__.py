"""Difficulties of a path of the tip: places out of reach, high joint rates, changes of branch; and what mends them."""

from mafsil.trajectory.difficulties.detours import Detour as Detour
from mafsil.trajectory.difficulties.diagnosis import PathDiagnosis as PathDiagnosis
from mafsil.trajectory.difficulties.diagnosis import PathStatus as PathStatus
from mafsil.trajectory.difficulties.diagnosis import diagnose_path as diagnose_path
from mafsil.trajectory.difficulties.difficulty import BranchChange as BranchChange
from mafsil.trajectory.difficulties.difficulty import FastStretch as FastStretch
from mafsil.trajectory.difficulties.difficulty import UnreachableStretch as UnreachableStretch
from mafsil.trajectory.difficulties.reachability import PathReach as PathReach
from mafsil.trajectory.difficulties.reachability import PathReachStatus as PathReachStatus
from mafsil.trajectory.difficulties.reachability import reachability as reachability
from mafsil.trajectory.difficulties.remedies import MendStatus as MendStatus
from mafsil.trajectory.difficulties.remedies import PathRemedies as PathRemedies
from mafsil.trajectory.difficulties.remedies import PathRemedy as PathRemedy
from mafsil.trajectory.difficulties.remedies import mend_path as mend_path
