"""One robot file: loaded by mafsil, read by the peer of its format, and both compared at random states."""

from __future__ import annotations

import contextlib
import os
import tempfile
import warnings
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from mafsil.errors import MafsilError
from mafsil.model import Mechanism
from mafsil.model.loading import load_mechanism
from tests.oracles import ours
from tests.oracles.natural_scale import natural_scale
from tests.oracles.states import sample

if TYPE_CHECKING:
    from tests.corpus.sdf_peer import SdfFile
    from tests.oracles.pinocchio_file import PinocchioFileOracle

STATES = 20
EQUAL = 1e-9
MOST_JOINTS = 120
ARM = 4
"""Moving joints in one chain from which a file counts as a manipulator."""
_QUANTITIES = ("link_poses", "mass_matrix", "inverse_dynamics", "gravity_torque")


@dataclass(slots=True)
class Verdict:
    """What became of a file.

    Attributes:
        loaded: by mafsil.
        codes: of the errors, or the key of another refusal.
        remarks: codes of warnings.
        warnings: given by the load.
        joints: coordinates that mafsil read.
        peer: whether the peer reads it; None if the format has none.
        manipulator: whether the peer, or else mafsil, sees a chain of ARM moving joints.
        error: largest difference in natural scale, or None if not compared.
        why: why it was not compared, or what the peer said.
    """

    loaded: bool = False
    codes: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    warnings: int = 0
    joints: int = 0
    peer: bool | None = None
    manipulator: bool = False
    error: float | None = None
    why: str = ""

    @property
    def equal(self) -> bool:
        """Whether both read the same robot."""
        return self.error is not None and self.error < EQUAL

    def as_dict(self) -> dict[str, object]:
        """For JSON."""
        return asdict(self)


def judged(path: Path, form: str, arguments: Mapping[str, str] | None = None, expansion: str | None = None) -> Verdict:
    """Load and compare one file.

    Args:
        path: of the file.
        form: its format.
        arguments: of a xacro file.
        expansion: a xacro file as ROS's xacro expands it, for Pinocchio; None compares nothing.
    """
    verdict = Verdict()
    mechanism = _load(path, arguments, verdict)
    try:
        if form == "mjcf":
            _against_mujoco(path, mechanism, verdict)
        elif form == "urdf":
            _against_pinocchio(path.name, path.read_bytes(), mechanism, verdict)
        elif form == "sdf":
            _against_plain_sdf(path, mechanism, verdict)
        elif form == "xacro" and expansion is not None:
            _against_pinocchio(path.name, expansion.encode(), mechanism, verdict)
    except Exception as error:
        verdict.why = f"{type(error).__name__}: {error}"[:200]
        raise
    if mechanism is not None and verdict.peer is None:
        verdict.manipulator = longest_chain(mechanism) >= ARM
    return verdict


def longest_chain(mechanism: Mechanism) -> int:
    """Most moving joints from the base to a link."""
    depth = {mechanism.links[0].name: 0}
    for joint in mechanism.joints:
        depth[joint.child] = depth[joint.parent] + (joint.moves and joint.mimic is None)
    return max(depth.values())


def _load(path: Path, arguments: Mapping[str, str] | None, verdict: Verdict) -> Mechanism | None:
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            mechanism = load_mechanism(path, xacro_args=arguments or None)
    except MafsilError as error:
        report = error.details.get("report")
        errors = getattr(report, "errors", ())
        verdict.codes = sorted({diagnostic.code for diagnostic in errors}) or [error.key]
        verdict.why = str(error)[:300]
        return None
    verdict.loaded, verdict.joints, verdict.warnings = True, mechanism.n, len(caught)
    verdict.remarks = sorted({word for note in mechanism.provenance.notes for word in note.split()[1:2]})
    return mechanism


def _against_mujoco(path: Path, mechanism: Mechanism | None, verdict: Verdict) -> None:
    from tests.corpus.mujoco_file import MuJoCoFile, NotComparable

    at = Path.cwd()
    try:
        os.chdir(path.parent)
        peer = MuJoCoFile(path)
    except ValueError as error:
        verdict.peer, verdict.why = False, verdict.why or str(error)[:200]
        return
    finally:
        os.chdir(at)
    verdict.peer, verdict.manipulator = peer.model.nbody > 1, peer.longest_chain() >= ARM
    if mechanism is None or not _worth_comparing(mechanism, verdict):
        return
    try:
        verdict.error, worst = peer.difference(mechanism, STATES)
        verdict.why = worst if verdict.error >= EQUAL else ""
    except NotComparable as reason:
        verdict.why = str(reason)


def _worth_comparing(mechanism: Mechanism, verdict: Verdict) -> bool:
    if not 0 < mechanism.n <= MOST_JOINTS:
        verdict.why = f"{mechanism.n} joints"
    return 0 < mechanism.n <= MOST_JOINTS


def _against_pinocchio(name: str, data: bytes, mechanism: Mechanism | None, verdict: Verdict) -> None:
    """Pinocchio gets the file with its attributes normalised as XML wants it: its parser keeps line breaks in them
    and drops an inertia whose number ends with one."""
    with contextlib.suppress(ElementTree.ParseError):
        data = _normalised(data)
    with tempfile.TemporaryDirectory() as folder:
        clean = Path(folder) / name
        clean.write_bytes(data)
        _compare_with_pinocchio(clean, mechanism, verdict)


def _normalised(data: bytes) -> bytes:
    """A document without blanks around the values of its attributes."""
    root = ElementTree.fromstring(data)
    for element in root.iter():
        element.attrib.update({name: value.strip() for name, value in element.attrib.items()})
    return ElementTree.tostring(root)


def _compare_with_pinocchio(path: Path, mechanism: Mechanism | None, verdict: Verdict) -> None:
    import pinocchio

    try:
        model = pinocchio.buildModelFromUrdf(str(path))
    except (ValueError, RuntimeError) as error:
        verdict.peer, verdict.why = False, verdict.why or str(error)[:200]
        return
    verdict.peer = True
    parents = list(model.parents)
    depth = [0] * len(parents)
    for k in range(1, len(parents)):
        depth[k] = depth[parents[k]] + 1
    verdict.manipulator = max(depth) >= ARM
    if mechanism is None or not _worth_comparing(mechanism, verdict):
        return
    from tests.oracles.pinocchio_file import PinocchioFileOracle

    try:
        oracle = PinocchioFileOracle(path, mechanism)
    except AssertionError:
        verdict.why = "Pinocchio reads another number of joints"
        verdict.error = np.inf
        return
    _judge_numbers(oracle, mechanism, _QUANTITIES, verdict)


def _against_plain_sdf(path: Path, mechanism: Mechanism | None, verdict: Verdict) -> None:
    """A second reader of SDF, which hands what it understands to Pinocchio."""
    from tests.corpus.sdf_peer import NotPlain, SdfFile

    if mechanism is None or not _worth_comparing(mechanism, verdict):
        return
    try:
        oracle = SdfFile(path, mechanism)
    except NotPlain as reason:
        verdict.why = f"not compared: {reason}"
        return
    except AssertionError:
        verdict.why, verdict.error = "the second reader finds other joints", np.inf
        return
    _judge_numbers(oracle, mechanism, ("link_poses", "mass_matrix", "inverse_dynamics"), verdict, oracle.rows)


def _judge_numbers(
    oracle: PinocchioFileOracle | SdfFile,
    mechanism: Mechanism,
    quantities: tuple[str, ...],
    verdict: Verdict,
    links: list[int] | None = None,
) -> None:
    """The largest difference; poses of the named links only, relative to the first of them.

    Rotors, of which neither URDF in Pinocchio nor the plain reader knows, are left out.
    """
    plain = replace(mechanism, joints=tuple(replace(joint, actuator=None) for joint in mechanism.joints))
    standard = plain.with_gravity((0.0, 0.0, -9.81))
    states = sample(standard, STATES, np.random.default_rng(0))
    theirs, mine = oracle.evaluate(states), ours.traced(standard, states, quantities)
    if links is not None:
        poses = mine["link_poses"][:, links]
        mine["link_poses"] = np.linalg.inv(poses[:, :1]) @ poses
    scale = natural_scale(standard)
    errors = {name: float(scale.error(name, mine[name], theirs[name]).max()) for name in quantities}
    worst = max(errors, key=lambda name: errors[name])
    verdict.error = errors[worst]
    verdict.why = f"{worst} differs by {errors[worst]:.2g}" if errors[worst] >= EQUAL else ""
