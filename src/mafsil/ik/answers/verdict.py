"""What can be said about a pose: the status, and the sentence of the reason."""

from __future__ import annotations

from mafsil.answer import Status


class Verdict(Status):
    """What can be said about a pose.

    BEYOND_LIMITS, OUT_OF_REACH and NOT_OF_THIS_ARM are said only where a closed form, a complete list or a bound of the
    reach proves it; what a search did not find is NOT_FOUND or NOT_FOUND_WITHIN_LIMITS.
    """

    SOLVED = ("ik.set_solved", True)
    CONTINUUM = ("ik.set_continuum", True)
    BEYOND_LIMITS = ("ik.set_beyond_limits", False)
    OUT_OF_REACH = ("ik.set_out_of_reach", False)
    NOT_OF_THIS_ARM = ("ik.set_not_of_this_arm", False)
    NOT_FOUND = ("ik.set_not_found", False)
    NOT_A_POSE = ("ik.not_a_pose", False)
    NOT_FOUND_WITHIN_LIMITS = ("ik.set_not_found_within", False)
