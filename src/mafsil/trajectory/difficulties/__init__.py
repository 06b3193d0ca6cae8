"""What stands in the way of a path of the tip: places out of reach, high joint rates, changes of branch."""

from mafsil.trajectory.difficulties.diagnosis import PathDiagnosis as PathDiagnosis
from mafsil.trajectory.difficulties.diagnosis import PathStatus as PathStatus
from mafsil.trajectory.difficulties.diagnosis import diagnose_path as diagnose_path
from mafsil.trajectory.difficulties.difficulty import BranchChange as BranchChange
from mafsil.trajectory.difficulties.difficulty import FastStretch as FastStretch
from mafsil.trajectory.difficulties.difficulty import UnreachableStretch as UnreachableStretch
from mafsil.trajectory.difficulties.reachability import PathReach as PathReach
from mafsil.trajectory.difficulties.reachability import PathReachStatus as PathReachStatus
from mafsil.trajectory.difficulties.reachability import reachability as reachability
