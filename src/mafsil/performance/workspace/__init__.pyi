from mafsil.performance.workspace.maps import workspace_map as workspace_map
from mafsil.performance.workspace.workspace_answers import Annulus as Annulus
from mafsil.performance.workspace.workspace_answers import WorkspaceMap as WorkspaceMap
from mafsil.performance.workspace.workspace_answers import dexterous_annuli as dexterous_annuli
from mafsil.performance.workspace.workspace_answers import reachable_annulus as reachable_annulus
