"""The message catalogue: every sentence that a user reads, in English and Arabic.

call      say(key, language=...), language('ar')
computed  `catalogue` finds the sentence and fills it in; `quantities` writes numbers with units, `tables` fits a
          screen, `isolates` keeps left-to-right words inside Arabic; the texts: en/*.toml, ar/*.toml
tested    tests/messages, tests/house/test_glossary.py
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
