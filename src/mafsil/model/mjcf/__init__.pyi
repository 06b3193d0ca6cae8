from mafsil.model.mjcf.reader import diagnose as diagnose
from mafsil.model.mjcf.reader import read as read
from mafsil.model.mjcf.reader import repair as repair
from mafsil.model.mjcf.writer import write as write
