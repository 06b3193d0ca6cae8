"""Jerk-limited motions in the shortest time: between states, through via points, and anew in every cycle."""

from mafsil.trajectory.jerk.binding import Binding as Binding
from mafsil.trajectory.jerk.binding import Bindings as Bindings
from mafsil.trajectory.jerk.motion import JerkLimitedBatch as JerkLimitedBatch
from mafsil.trajectory.jerk.motion import JerkLimitedMotion as JerkLimitedMotion
from mafsil.trajectory.jerk.state_to_state import jerk_limited as jerk_limited
from mafsil.trajectory.jerk.status import JerkStatus as JerkStatus
