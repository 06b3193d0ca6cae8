"""Pictures in files, by matplotlib: imported at the first picture.

call      robot.plot(), mf.figures.plot_frames, plot_configurations ...
computed  a module a picture; `frames` and `space` are what they share, `panel_data` is for pages
tested    tests/figures
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
