"""What reports and pages draw: a robot as solids in Python, and the scripts that show solids in a browser.

call      no public face: pages draw with it
computed  `drawing` makes solids of a robot, `modules` names the scripts, `inline` puts them into one file
tested    tests/page, tests/report
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
