from mafsil.model.urdf.reader import diagnose as diagnose
from mafsil.model.urdf.reader import file_reader as file_reader
from mafsil.model.urdf.reader import read as read
from mafsil.model.urdf.reader import repair as repair
from mafsil.model.urdf.writer import LOSSES as LOSSES
from mafsil.model.urdf.writer import write as write
