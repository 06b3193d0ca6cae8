"""How inverse kinematics of a pose ended: one status for exact lists and for searches, each with its sentence."""

from __future__ import annotations

from mafsil.answer import Status


class IKStatus(Status):
    """What can be said about a pose.

    OUT_OF_REACH and NOT_OF_THIS_ARM are said only where a closed form, a complete list or a bound of the reach proves
    it. BEYOND_LIMITS is proven where `inverse_kinematics` says it; of `solve_ik` it means that a solution was found
    beyond the limits and none within. What a search did not find is NOT_FOUND, NOT_FOUND_WITHIN_LIMITS, BUDGET_SPENT,
    TIME_SPENT or FEW_JOINTS, none of which proves anything.
    """

    SOLVED = ("ik.status_solved", True)
    CONTINUUM = ("ik.status_continuum", True)
    BEYOND_LIMITS = ("ik.status_beyond_limits", False)
    OUT_OF_REACH = ("ik.status_out_of_reach", False)
    NOT_OF_THIS_ARM = ("ik.status_not_of_this_arm", False)
    NOT_FOUND = ("ik.status_not_found", False)
    NOT_A_POSE = ("ik.status_not_a_pose", False)
    NOT_FOUND_WITHIN_LIMITS = ("ik.status_not_found_within_limits", False)
    FEW_JOINTS = ("ik.status_few_joints", False)
    BUDGET_SPENT = ("ik.status_budget_spent", False)
    TIME_SPENT = ("ik.status_time_spent", False)


STATUSES = tuple(IKStatus)
"""All of them in order; arrays of codes hold indices into it."""

CODES = {status: code for code, status in enumerate(STATUSES)}
"""The index of each."""
