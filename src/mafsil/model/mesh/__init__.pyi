from mafsil.model.mesh.reader import read as read
from mafsil.model.mesh.surface import MeshLimits as MeshLimits
from mafsil.model.mesh.surface import Surface as Surface
