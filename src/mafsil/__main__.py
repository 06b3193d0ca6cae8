"""`python -m mafsil`."""

from mafsil.cli.__main__ import program

program()
