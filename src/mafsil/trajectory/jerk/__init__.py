"""Jerk-limited motions in the shortest time: between states, through via points, and anew in every cycle."""

from mafsil.trajectory.jerk.binding import Binding as Binding
from mafsil.trajectory.jerk.binding import Bindings as Bindings
from mafsil.trajectory.jerk.motion import JerkLimitedBatch as JerkLimitedBatch
from mafsil.trajectory.jerk.motion import JerkLimitedMotion as JerkLimitedMotion
from mafsil.trajectory.jerk.online import Online as Online
from mafsil.trajectory.jerk.online import online as online
from mafsil.trajectory.jerk.state_to_state import jerk_limited as jerk_limited
from mafsil.trajectory.jerk.status import JerkStatus as JerkStatus
from mafsil.trajectory.jerk.via_points import ViaMotion as ViaMotion
from mafsil.trajectory.jerk.via_points import jerk_limited_through as jerk_limited_through
