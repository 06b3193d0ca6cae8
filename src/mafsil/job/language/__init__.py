"""What is asked: the tables of a job file, its frames, names, patterns, loops and units; and the job that it asks for.

The door is `reading`: a file or text in, a checked `description.Job` out, or the complaint with its key and line.
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
