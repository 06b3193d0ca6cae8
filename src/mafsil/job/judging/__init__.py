"""A run judged: its numbers held against what was asked, what they mean in words, and what failures come from.

The door is `judge_run` with `summary`: a `Run` in, its numbers and the sentences that they deserve out.
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
