"""What can be said about a pose: the status, and the sentence of the reason."""

from __future__ import annotations

from mafsil.solvers import Status


class Verdict(Status):
    """What can be said about a pose."""

    SOLVED = ("ik.set_solved", True)
    CONTINUUM = ("ik.set_continuum", True)
    BEYOND_LIMITS = ("ik.set_beyond_limits", False)
    OUT_OF_REACH = ("ik.set_out_of_reach", False)
    NOT_OF_THIS_ARM = ("ik.set_not_of_this_arm", False)
    NOT_FOUND = ("ik.set_not_found", False)
    NOT_A_POSE = ("ik.not_a_pose", False)
