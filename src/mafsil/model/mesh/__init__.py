"""Surfaces in files, for pictures: STL, OBJ and the triangles of Collada, with sizes checked before memory is taken."""

from mafsil.model.mesh.reader import read as read
from mafsil.model.mesh.surface import MeshLimits as MeshLimits
from mafsil.model.mesh.surface import Surface as Surface
