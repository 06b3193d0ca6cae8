"""Reports: one self-contained page per run, and pages that show a robot."""

from mafsil.report.still import write_picture as write_picture
