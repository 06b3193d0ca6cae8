"""Pictures in files, by matplotlib: imported at the first picture."""

from mafsil.figures.dh_frames import save_dh_frames as save_dh_frames
from mafsil.figures.dh_frames import save_link_motions as save_link_motions
from mafsil.figures.mechanism import save_mechanism as save_mechanism
