"""The tip link of a description that names none: a frame of convention, or the arm's last link before its hand."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from mafsil.messages import say
from mafsil.model.joint import Joint

CONVENTIONS: tuple[str, ...] = (
    r"tcp|tcp_link|tcp_frame|tool_cent(er|re)_point",
    r"grasp_?target|grasp(ing)?_(frame|link|point)|gripper_(frame|tool_frame)(_link)?",
    r"tool0",
    r"tool(_link|_frame|_tip)?",
    r"eef?(_link|_frame)?|link_eef|end_?effector(_link|_frame)?|effector",
    r"flange(_link|_frame)?",
)
"""Names that makers and drivers give to the frame of the tool, the most telling first; prefixes such as `panda_hand_`
may stand before them."""
_FRAMES = tuple(re.compile(rf"(?:.*[_/ ])?(?:{words})") for words in CONVENTIONS)
_HAND_JOINT = re.compile(r"finger|thumb|knuckle|jaw|claw|gripper|pinch|pinky|(^|_)(hand|index|middle|ring|little)_")
_HAND_LINK = re.compile(r"finger|thumb|knuckle|jaw|claw|mover")
_ARM_JOINT = re.compile(r"roll|pitch|yaw|wrist|rotat|elbow|shoulder|arm")
_BYSTANDER = re.compile(r"imu|camera|optical|sensor|rotor")
_MOST_OTHERS = 6


@dataclass(frozen=True, slots=True)
class TipChoice:
    """The tip link that was chosen, and what else could have been meant.

    Attributes:
        tip: name of the link.
        others: other links that end a moved chain, or that bear a name of convention on the same arm.
    """

    tip: str
    others: tuple[str, ...]

    def __format__(self, language: str) -> str:
        """The sentence, in the language named by the format."""
        return self.sentence(language or None)

    def sentence(self, language: str | None = None) -> str:
        """What was chosen, the others, and how to choose."""
        shown = ", ".join(self.others[:_MOST_OTHERS])
        more = len(self.others) - _MOST_OTHERS
        others = f"{shown}, ... +{more}" if more > 0 else shown
        return say("model.tip_chosen", language=language, tip=self.tip, others=others)


def choose_tip(base: str, joints: Iterable[Joint]) -> TipChoice:
    """The tip of a tree of joints.

    1. The chain is cut where the tree forks into several moving branches; mimic joints fork a hand, not an arm.
    2. The arm is the part with the most joints of its own; joints of the hand at its end do not count.
    3. Among the links fixed to the arm's last one, a frame of convention is the tip.
    4. Else the last of them before a fork: the flange, or the palm.

    Args:
        base: name of the base link.
        joints: of the spanning tree, every parent before its children.
    """
    tree = _Tree(base, tuple(joints))
    root = tree.arm_end
    cluster = tree.fixed_to(root)
    named = [(rank, -k, link) for k, link in enumerate(cluster) if (rank := _rank(link)) is not None]
    tip = min(named)[2] if named else tree.last_before_fork(root)
    beyond = tree.beyond(root)
    moved = [link for link in tree.leaves if link in tree.moved and not _BYSTANDER.search(link.lower())]
    moved.sort(key=lambda link: link not in beyond)
    others = dict.fromkeys([link for _, _, link in sorted(named)] + moved)
    return TipChoice(tip, tuple(link for link in others if link != tip))


def is_named_as_tip(link: str) -> bool:
    """Whether makers and drivers call the frame of the tool so."""
    return _rank(link) is not None


def _rank(link: str) -> int | None:
    """Place of a link's name among the conventions; None for any other name."""
    name = re.sub(r"[-. ]", "_", link.lower())
    return next((k for k, words in enumerate(_FRAMES) if words.fullmatch(name)), None)


@dataclass(frozen=True)
class _Tree:
    base: str
    joints: tuple[Joint, ...]

    @cached_property
    def outgoing(self) -> dict[str, list[Joint]]:
        found: dict[str, list[Joint]] = {}
        for joint in self.joints:
            found.setdefault(joint.parent, []).append(joint)
        return found

    @cached_property
    def leaves(self) -> list[str]:
        return [joint.child for joint in self.joints if joint.child not in self.outgoing]

    @cached_property
    def moved(self) -> set[str]:
        """Links that some joint moves."""
        moved: set[str] = set()
        for joint in self.joints:
            if joint.moves or joint.parent in moved:
                moved.add(joint.child)
        return moved

    @cached_property
    def reach(self) -> dict[str, tuple[int, bool]]:
        """For each link, the most own coordinates on a way from it to a leaf, and whether anything moves beyond it."""
        found: dict[str, tuple[int, bool]] = {}
        for joint in reversed(self.joints):
            own, moving = found.get(joint.child, (0, False))
            own, moving = own + _owns(joint), moving or joint.moves
            before = found.get(joint.parent, (0, False))
            found[joint.parent] = (max(own, before[0]), moving or before[1])
        return found

    def forks(self, link: str) -> bool:
        """Whether several moving branches leave a link: several with coordinates, or the fingers of a hand."""
        branches = [
            (self.reach.get(joint.child, (0, False))[0] + _owns(joint))
            for joint in self.outgoing.get(link, ())
            if joint.moves or self.reach.get(joint.child, (0, False))[1]
        ]
        own = [depth for depth in branches if depth]
        return len(own) > 1 or (len(branches) > 1 and max(branches) <= 1)

    @cached_property
    def arm_end(self) -> str:
        """The child of the last arm joint of the longest part between forks; of equals the one farther out."""
        # for each link: own joints of its part and in all, the last arm link of the part with its own joints
        state: dict[str, tuple[int, int, str, int]] = {self.base: (0, 0, self.base, 0)}
        best = (0, 0, self.base)
        for joint in self.joints:
            length, depth, end, counted = (
                (0, state[joint.parent][1], joint.parent, 0) if self.forks(joint.parent) else state[joint.parent]
            )
            follows = end == best[2] and joint.moves and not _of_hand(joint)
            if joint.moves:
                length, depth = length + _owns(joint), depth + _owns(joint)
                if not _of_hand(joint):
                    end, counted = joint.child, length
            state[joint.child] = (length, depth, end, counted)
            if (counted, depth) > best[:2] or (follows and (counted, depth) == best[:2]):
                best = (counted, depth, end)
        return best[2] if best[0] else self._deepest

    @property
    def _deepest(self) -> str:
        """Where everything is a hand, or nothing moves: the link behind the most joints that own a coordinate."""
        depth = {self.base: 0}
        for joint in self.joints:
            depth[joint.child] = depth[joint.parent] + _owns(joint)
        return max(depth, key=lambda link: depth[link])

    def fixed_to(self, root: str) -> list[str]:
        """The link and all that fixed joints carry on it, in order."""
        found = [root]
        for joint in self.joints:
            if joint.parent in found and not joint.moves:
                found.append(joint.child)
        return found

    def beyond(self, root: str) -> set[str]:
        """The link and all that any joints carry on it."""
        found = {root}
        for joint in self.joints:
            if joint.parent in found:
                found.add(joint.child)
        return found

    def last_before_fork(self, root: str) -> str:
        """Outwards over fixed joints, towards what still moves, past bystanders such as cameras, to the first fork."""
        link = root
        while True:
            children = self.outgoing.get(link, [])
            onward = [j for j in children if j.moves or self.reach.get(j.child, (0, False))[1]] or children
            onward = [j for j in onward if not _BYSTANDER.search(j.child.lower())]
            if len(onward) != 1 or onward[0].moves:
                return link
            link = onward[0].child


def _owns(joint: Joint) -> int:
    return int(joint.moves and joint.mimic is None)


def _of_hand(joint: Joint) -> bool:
    """Whether the names say that a joint opens and closes a hand."""
    name, child = joint.name.lower(), joint.child.lower()
    if _ARM_JOINT.search(name):
        return False
    return bool(_HAND_JOINT.search(name) or _HAND_LINK.search(child))
