"""Pictures in files, by matplotlib: imported at the first picture."""

from mafsil.figures.mechanism import save_mechanism as save_mechanism
