"""The textbook, live: its figures, worked examples and remarks by number, computed and drawn on request.

call      mf.book.figure('2.5'), mf.book.example('2.4'), mf.book.exercise('4.2', seed=3), mafsil book
computed  `entry` is their shape; `chapter_2` to `chapter_10` hold figures, `example` examples,
          `remarks` remarks; `family` makes questions, `exercise` draws exercises, `judging` checks answers, `sheet`
          writes pages; `edition` has a page for each section and finds, `errata` proves by `counterexamples`
tested    tests/book
"""

from mafsil.lazy_module import face

__all__ = face(__name__)
