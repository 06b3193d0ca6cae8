"""What a format of robot files cannot keep: refused, left out where the caller says so, or said in file and warning.

Tip frame and base pose as massless links behind fixed joints, for formats that know links alone.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass, field, replace
from enum import Enum
from os import PathLike
from pathlib import Path

import numpy as np

from mafsil.arrays import frozen
from mafsil.errors import FileError, InputError, ModelError, ModelWarning, warn
from mafsil.messages import clauses, say
from mafsil.model.diagnostics import shown
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Link
from mafsil.model.mechanism import Mechanism
from mafsil.whole_file import write_whole

MOST_NAMES = 8


class Weight(Enum):
    """What follows from a loss."""

    REFUSED = "refused"
    """The format cannot hold such a robot."""
    CHOSEN = "chosen"
    """What is read back would move otherwise: refused, unless the caller leaves it out by name."""
    WARNED = "warned"
    """The motion is the same without it: left out, and said."""
    NOTED = "noted"
    """Nothing is lost, but the file says it in another way."""


@dataclass(frozen=True, slots=True)
class Loss:
    """One thing that a robot file does not hold, or holds in another way.

    Attributes:
        key: of the sentence, `writing.name`.
        weight: what follows.
        what: the word of `without` that leaves it out.
        details: what the sentence mentions.
    """

    key: str
    weight: Weight
    what: str = ""
    details: dict[str, object] = field(default_factory=dict[str, object])

    def sentence(self, language: str | None = None) -> str:
        """What is lost and what to do, in `en` or `ar` or the current language."""
        return say(self.key, language=language, **self.details)

    def spoken(self, language: str | None = None) -> str:
        """The sentence, inside another one."""
        return self.sentence(language)

    def __repr__(self) -> str:
        return self.sentence()


@dataclass(frozen=True, slots=True)
class Losses:
    """Several of them, as one part of a sentence."""

    each: tuple[Loss, ...]

    def spoken(self, language: str | None = None) -> str:
        """The sentences in a row."""
        return clauses((loss.sentence(language) for loss in self.each), language)


@dataclass(frozen=True, slots=True)
class Document:
    """A robot as the text of a file.

    Attributes:
        text: of the file.
        losses: what it does not hold, or holds in another way; the text says them too.
    """

    text: str
    losses: tuple[Loss, ...]


def names_of(names: Iterable[str]) -> str:
    """Names for a sentence, the first ones of many."""
    every = [shown(name) for name in names]
    more = len(every) - MOST_NAMES
    return ", ".join([*every[:MOST_NAMES], f"... +{more}"] if more > 0 else every)


def joints_that(mechanism: Mechanism, is_so: Callable[[Joint], bool]) -> str:
    """Names of the joints of which something is so, for a sentence."""
    return names_of(joint.name for joint in mechanism.joints if is_so(joint))


def friction_loss(mechanism: Mechanism, name: str) -> Iterator[Loss]:
    """Friction that differs for both senses, or has an offset, in a format of that name."""
    if names := joints_that(mechanism, lambda joint: joint.friction is not None and joint.friction.is_uneven):
        yield Loss("writing.friction", Weight.CHOSEN, "friction", {"format": name, "names": names})


def curve_loss(mechanism: Mechanism, name: str, *, degree: int = 1) -> Iterator[Loss]:
    """Joints that follow others along a curve, in a format of that name that has curves up to a degree."""
    if names := joints_that(mechanism, lambda joint: joint.mimic is not None and len(joint.mimic.curve()) > degree + 1):
        yield Loss("writing.curve", Weight.REFUSED, "", {"format": name, "names": names, "degree": degree})


def settle_losses(losses: Iterable[Loss], known: tuple[str, ...], without: Collection[str]) -> tuple[Loss, ...]:
    """The losses, if none of them forbids the file.

    Args:
        losses: of a robot in a format.
        known: all words that `without` may hold.
        without: what the caller leaves out.

    Raises:
        InputError: a word that leaves out nothing.
        ModelError: a loss that the format forbids, or that changes the motion and is not left out by name.
    """
    found = tuple(losses)
    for word in _words(without):
        if word not in known:
            raise InputError("input.choice", name="without", value=word, known=", ".join(known))
    for loss in found:
        if loss.weight is Weight.REFUSED:
            raise ModelError("writing.refused", loss=loss)
    for loss in found:
        if loss.weight is Weight.CHOSEN and loss.what not in _words(without):
            raise ModelError("writing.refused_by_choice", loss=loss, what=loss.what)
    return found


def deliver(document: Document, robot: str, path: str | PathLike[str] | None, without: Collection[str]) -> str:
    """The text, written to a file if there is a path.

    Args:
        document: the text and what it does not hold.
        robot: its name.
        path: of a file, which is replaced, or None.
        without: what the caller leaves out, and need not be warned of.

    Warns:
        ModelWarning: something is left out that `without` does not name.

    Raises:
        FileError: the file cannot be written.
    """
    if path is not None:
        try:
            data = document.text.encode("utf-8")
        except UnicodeEncodeError as error:
            raise FileError("file.cannot_write", path=str(path), reason=str(error)) from None
        write_whole(Path(path), data)
    silent = _words(without)
    loud = tuple(loss for loss in document.losses if loss.weight is Weight.WARNED and loss.what not in silent)
    if loud:
        warn(ModelWarning("writing.losses", robot=shown(robot), losses=Losses(loud)))
    return document.text


def comment_lines(losses: tuple[Loss, ...]) -> list[str]:
    """What a file says of its losses, a line for each; nothing where nothing is lost."""
    return [say("writing.head", language="en"), *(loss.sentence("en") for loss in losses)] if losses else []


def xml_comment(losses: tuple[Loss, ...]) -> list[str]:
    """The lines as one comment of XML, which must not hold two hyphens in a row."""
    lines = [re.sub("-(?=-|$)", "- ", line) for line in comment_lines(losses)]
    return ["  <!-- " + "\n       ".join(lines) + " -->"] if lines else []


def _words(without: Collection[str]) -> Collection[str]:
    return (without,) if isinstance(without, str) else without


TIP_NAMES = ("tip", "tcp")
"""Names of a tip link; the second is one that every choice of a tip prefers."""
Marks = Callable[[Mechanism], Collection[str]]
"""The links that a format writes as named frames, which are tips only by a name of convention."""


def no_marks(_mechanism: Mechanism) -> Collection[str]:
    """Of a format that knows links alone."""
    return ()


def with_tip_link(mechanism: Mechanism, marks: Marks = no_marks) -> Mechanism:
    """The mechanism with its tip frame as the frame of a link, one that readers choose as the tip if that can be.

    Args:
        mechanism: any; itself if its tip is the frame of the link that readers choose.
        marks: of the format.
    """
    is_frame_of_link = np.array_equal(mechanism.T_lt, np.eye(4))
    if is_frame_of_link and chosen_tip(mechanism, marks) == mechanism.tip:
        return mechanism
    free = [_free(mechanism, name) for name in TIP_NAMES]
    candidates = [mechanism.with_frame(name).with_tip(name) for name in free]
    for candidate in candidates:
        if chosen_tip(candidate, marks) == candidate.tip:
            return candidate
    return mechanism if is_frame_of_link else candidates[0]


def with_space_link(mechanism: Mechanism) -> Mechanism:
    """The mechanism on a link that stands in the space frame; itself if its base stands there."""
    if np.array_equal(mechanism.T_sb, np.eye(4)):
        return mechanism
    name = _free(mechanism, "space")
    joint = Joint(f"{name}_joint", JointKind.FIXED, name, mechanism.links[0].name, mechanism.T_sb)
    links, joints = (Link(name), *mechanism.links), (joint, *mechanism.joints)
    return replace(mechanism, links=links, joints=joints, T_sb=frozen(np.eye(4)))


def tip_loss(mechanism: Mechanism, marks: Marks = no_marks) -> Iterator[Loss]:
    """The remark that readers choose another tip than this one."""
    chosen = chosen_tip(mechanism, marks)
    if chosen != mechanism.tip:
        yield Loss("writing.tip", Weight.WARNED, "tip", {"tip": mechanism.tip, "chosen": chosen})


def chosen_tip(mechanism: Mechanism, marks: Marks = no_marks) -> str:
    """The link that a reader of a file takes for the tip."""
    links, joints, loops = mechanism.links, mechanism.joints, mechanism.loops
    return Mechanism.assemble(mechanism.name, links, joints, loops=loops, marks=marks(mechanism)).tip


def _free(mechanism: Mechanism, name: str) -> str:
    """The name, with underscores until nothing else is called so."""
    taken = {*mechanism.link_names, *(joint.name for joint in (*mechanism.joints, *mechanism.loops))}
    while name in taken or f"{name}_joint" in taken:
        name += "_"
    return name
