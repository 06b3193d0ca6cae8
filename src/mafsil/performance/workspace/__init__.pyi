from mafsil.performance.workspace.annulus import Annulus as Annulus
from mafsil.performance.workspace.annulus import dexterous_annuli as dexterous_annuli
from mafsil.performance.workspace.annulus import reachable_annulus as reachable_annulus
from mafsil.performance.workspace.maps import WorkspaceMap as WorkspaceMap
from mafsil.performance.workspace.maps import workspace_map as workspace_map
