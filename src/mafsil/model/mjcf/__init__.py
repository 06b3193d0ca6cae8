"""MuJoCo's model files: a reader of the part that describes mechanisms, with coded diagnostics and repairs."""

from mafsil.model.mjcf.reader import diagnose as diagnose
from mafsil.model.mjcf.reader import read as read
from mafsil.model.mjcf.reader import repair as repair
