"""Reports: one self-contained page per run with its data, and pages that show a robot.

call      mafsil run writes it; mf.report
computed  `contents` says what is shown, `results` saves and loads, `replay` draws the run, `comparison` lays two
          beside each other
tested    tests/report
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
