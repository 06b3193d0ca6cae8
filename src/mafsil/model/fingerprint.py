"""A name for the content of a mechanism: equal numbers, equal fingerprint, in every process and on every machine."""

from __future__ import annotations

from collections.abc import Iterator
from hashlib import blake2b
from weakref import WeakKeyDictionary

from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Link
from mafsil.model.mechanism import Mechanism

_KNOWN: WeakKeyDictionary[Mechanism, str] = WeakKeyDictionary()
"""Of mechanisms that were asked for: they do not change."""


def fingerprint(mechanism: Mechanism) -> str:
    """Hash (hexadecimal, 128 bits) of what shapes the motion, without limits; friction: `friction_fingerprint`."""
    known = _KNOWN.get(mechanism)
    if known is None:
        digest = blake2b(digest_size=16)
        for item in _content(mechanism):
            digest.update(len(item).to_bytes(8, "little"))
            digest.update(item)
        known = _KNOWN[mechanism] = digest.hexdigest()
    return known


def friction_fingerprint(mechanism: Mechanism) -> str:
    """Hash (hexadecimal, 128 bits) of the friction of the joints; apart, for most equations do not know it."""
    numbers = [(joint.name, joint.friction) for joint in mechanism.joints]
    return blake2b(repr(numbers).encode(), digest_size=16).hexdigest()


def _content(mechanism: Mechanism) -> Iterator[bytes]:
    for link in mechanism.links:
        yield from _link(link)
    for joint in (*mechanism.joints, *mechanism.loops):
        yield from _joint(joint)
    yield from (mechanism.tip.encode(), mechanism.T_lt.tobytes(), mechanism.T_sb.tobytes(), mechanism.gravity.tobytes())


def _link(link: Link) -> Iterator[bytes]:
    yield link.name.encode()
    if link.inertial is not None:
        yield repr(link.inertial.mass).encode() + link.inertial.com.tobytes() + link.inertial.inertia.tobytes()


def _joint(joint: Joint) -> Iterator[bytes]:
    reflected = 0.0 if joint.actuator is None else joint.actuator.reflected_inertia
    details = (joint.name, joint.kind.value, joint.parent, joint.child, joint.pitch, reflected, joint.mimic)
    yield repr(details).encode()
    yield joint.T_pj.tobytes() + joint.axis.tobytes()
    if joint.kind is JointKind.UNIVERSAL:
        yield joint.second.tobytes()
