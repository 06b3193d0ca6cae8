"""Pictures in files, by matplotlib: imported at the first picture.

call      robot.plot(), mf.figures.plot_frames, plot_configurations ...
computed  a module a picture; `frames`, `space` and `picture_file` are what they share
tested    tests/figures
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
