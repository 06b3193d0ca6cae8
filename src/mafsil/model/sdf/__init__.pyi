from mafsil.model.sdf.reader import diagnose as diagnose
from mafsil.model.sdf.reader import file_reader as file_reader
from mafsil.model.sdf.reader import read as read
from mafsil.model.sdf.reader import repair as repair
from mafsil.model.sdf.writer import write as write
