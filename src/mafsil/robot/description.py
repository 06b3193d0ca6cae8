"""What a robot knows without computing: names, limits, ways to describe it, variants with a tool, a load, a lock.

A robot as a table that fits a screen: joints with their kinds and limits, tip, masses; in notebooks too.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from html import escape
from math import isfinite
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal, NoReturn, Self, Unpack, cast

from numpy.typing import ArrayLike

from mafsil.arrays import JointVector, PoseMatrix, as_batch
from mafsil.errors import InputError, UnknownNameError
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.model import Joint, JointKind, JointLimits, Mechanism
from mafsil.model.denavit_hartenberg import Convention, DHRowLike, mechanism_from_dh
from mafsil.model.exponentials import ArmParts, mechanism_from_screws
from mafsil.robot.degrees import in_radians, radians_per_unit

if TYPE_CHECKING:
    import mafsil.model.inertia_check as impossible_inertia
    import mafsil.model.saving as saving
    from mafsil.model.losses import Loss
else:
    impossible_inertia = lazily("mafsil.model.inertia_check")
    saving = lazily("mafsil.model.saving")


MOST_JOINTS = 20
"""Rows of the table; with its head and what stands around it, it takes no more than 25 lines."""
LONGEST_NAME = 28
"""Letters of a name; with five numbers and their units beside it, a row takes no more than 100 columns."""


class Description:
    """The description that a robot is made from.

    Attributes:
        mechanism: the description; immutable.
        derived: what higher packages keep of it, by their own keys; it ends with the robot, and no pickle carries it.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        if not isinstance(cast(object, mechanism), Mechanism):
            raise InputError("robot.mechanism", got=type(mechanism).__name__)
        self.mechanism = mechanism
        self.derived: dict[tuple[Any, ...], Any] = {}

    def __repr__(self) -> str:
        frames = len(self.mechanism.frame_names)
        links = f"{len(self.mechanism.links) - frames} links" + (
            f", {frames} named frame{'s'[: frames > 1]}" if frames else ""
        )
        return f"<Robot {self.name!r}: {self.n} joints, {links}, tip {self.mechanism.tip!r}>"

    def __str__(self) -> str:
        return overview(self.mechanism)

    def _repr_html_(self) -> str:
        """In a notebook: joints, kinds, limits, tip and masses as a table."""
        return overview_html(self.mechanism)

    def __reduce__(self) -> tuple[type[Self], tuple[Mechanism]]:
        return type(self), (self.mechanism,)

    @classmethod
    def from_dh(
        cls,
        rows: Sequence[DHRowLike],
        convention: Convention | str,
        *,
        columns: Sequence[str] | None = None,
        degrees: bool = False,
        base: ArrayLike | None = None,
        tool: ArrayLike | None = None,
        **parts: Unpack[ArmParts],
    ) -> Self:
        """A serial robot from a table of Denavit and Hartenberg; see `mafsil.model.denavit_hartenberg`.

        Args:
            rows: one per joint: a `DHRow`, numbers in the order of `columns`, or a mapping of names to numbers.
            convention: `classic` or `modified`.
            columns: what the numbers of a plain row are; a, alpha, d, theta by default, as in `DHRow`.
            degrees: alpha and theta (and offset of a revolute joint) are degrees.
            base, tool, **parts: see `mechanism_from_dh`.

        Warns:
            ModelWarning: a link with mass properties that no body has.
        """
        mechanism = mechanism_from_dh(rows, convention, columns=columns, degrees=degrees, base=base, tool=tool, **parts)
        return cls(impossible_inertia.warned_of_impossible(mechanism))

    @classmethod
    def from_screws(
        cls,
        screws: ArrayLike,
        home: ArrayLike,
        *,
        form: Literal["space", "body"] = "space",
        normalise: bool = False,
        inertial_frames: Sequence[PoseMatrix] | None = None,
        **parts: Unpack[ArmParts],
    ) -> Self:
        """A serial robot from its screw axes and home pose; see `mafsil.model.exponentials`."""
        mechanism = mechanism_from_screws(
            screws, home, form=form, normalise=normalise, inertial_frames=inertial_frames, **parts
        )
        return cls(impossible_inertia.warned_of_impossible(mechanism))

    @property
    def name(self) -> str:
        """Name of the robot."""
        return self.mechanism.name

    @property
    def n(self) -> int:
        """Number of joint coordinates."""
        return self.mechanism.n

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, in the order of q."""
        return self.mechanism.joint_names

    @property
    def limits(self) -> JointLimits:
        """Bounds of positions, rates, accelerations and efforts, arrays of shape (n,)."""
        return self.mechanism.limits

    @property
    def tip(self) -> str:
        """Name of the link that carries the tip frame."""
        return self.mechanism.tip

    def radians(self, q: ArrayLike) -> JointVector:
        """(*batch, n) coordinates given with angles in degrees, as mafsil takes them; lengths stay.

        Args:
            q: (*batch, n) joint coordinates [deg | m].
        """
        return in_radians(self.mechanism, "q", q)

    def degrees(self, q: ArrayLike) -> JointVector:
        """(*batch, n) coordinates with angles in degrees, as people read them; lengths stay.

        Args:
            q: (*batch, n) joint coordinates [rad | m].
        """
        return as_batch("q", q, (self.n,)) / radians_per_unit(self.mechanism)

    def with_tip(self, tip: str, T_lt: ArrayLike | None = None) -> Self:
        """The robot with another tip frame.

        Args:
            tip: name of the link that carries it.
            T_lt: (4, 4) pose of the tip frame in that link; the link's own frame if None.
        """
        return type(self)(self.mechanism.with_tip(tip, T_lt))

    def with_frame(self, name: str, pose: ArrayLike | None = None, link: str | None = None) -> Self:
        """The robot with a named frame, which every `frame=` and `tip=` takes; masses and motion stay.

        Args:
            name: of the new frame.
            pose: (4, 4) of the frame in that of the link, or its origin (3,) [m] alone; the link's own frame if None.
            link: that carries it; the present tip frame if None.
        """
        return type(self)(self.mechanism.with_frame(name, pose, link))

    def with_tool(
        self,
        tool: ArrayLike | None = None,
        *,
        mass: float = 0.0,
        com: ArrayLike = (0.0, 0.0, 0.0),
        inertia: ArrayLike | None = None,
        link: str | None = None,
    ) -> Self:
        """The robot with a tool mounted on its tip frame, or on `link`: a new tip frame, and the tool's mass.

        Args:
            tool: pose (4, 4) of the new tip frame in the frame on which the tool is mounted, or its origin (3,) [m].
            mass, com, inertia: of the tool, in the mounting frame [kg, m, kg m^2]; see `mafsil.model.tooling`.
            link: mount on this link, in its frame.
        """
        return type(self)(self.mechanism.with_tool(tool, mass=mass, com=com, inertia=inertia, link=link))

    def with_payload(
        self,
        mass: float,
        *,
        com: ArrayLike = (0.0, 0.0, 0.0),
        inertia: ArrayLike | None = None,
        link: str | None = None,
    ) -> Self:
        """The robot with a body fixed to its tip frame, or to `link`; the tip frame stays.

        Args:
            mass: [kg].
            com: (3,) centre of mass in that frame [m].
            inertia: (3, 3) about the centre of mass [kg m^2]; a point mass if None.
            link: that carries the body, in whose frame the numbers are.
        """
        return type(self)(self.mechanism.with_payload(mass, com=com, inertia=inertia, link=link))

    def with_locked_joints(self, coordinates: Mapping[str, float]) -> Self:
        """The robot with joints locked, such as `robot.with_locked_joints({"finger": 0.02})`; mimic pairs go together.

        Args:
            coordinates: coordinate [rad | m] by name of the joint.
        """
        return type(self)(self.mechanism.with_locked_joints(coordinates))

    def without_loops(self) -> Self:
        """The open tree of a robot with loops."""
        return type(self)(self.mechanism.without_loops())

    def save(self, path: str | PathLike[str], *, without: Collection[str] = ()) -> tuple[Loss, ...]:
        """Write the robot to a file: .urdf, .sdf or .world (Gazebo), .xml or .mjcf (MuJoCo), .toml; see `mafsil.save`.

        Args:
            path: of the file, which is replaced.
            without: what may be left out though the format cannot keep it.

        Returns:
            What the file does not hold, or says in another way.
        """
        return saving.save(self.mechanism, path, without=without)

    if not TYPE_CHECKING:  # type checkers find misspelt names themselves

        def __getattr__(self, name: str) -> NoReturn:
            raise UnknownNameError(type(self).__name__, name, dir(self))


def overview(mechanism: Mechanism) -> str:
    """What `print(robot)` shows; the whole of it is shown by `mafsil show`.

    Args:
        mechanism: the robot's description.
    """
    rows = _rows(mechanism)
    widths = [max(len(row[k]) for row in rows if row[-1] or k != 1) for k in range(len(rows[0]))]
    lines = ["  " + "  ".join(_pad(row, widths)).rstrip() for row in rows if len(rows) > 1]
    return "\n".join([_title(mechanism), *lines, *_rest(mechanism)])


def overview_html(mechanism: Mechanism) -> str:
    """The same for notebooks.

    Args:
        mechanism: the robot's description.
    """
    head, *rows = _rows(mechanism)
    cells = ["".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows]
    table = "".join(f"<tr>{row}</tr>" for row in ("".join(f"<th>{escape(name)}</th>" for name in head), *cells))
    lines = "".join(f'<div dir="auto">{escape(line.strip())}</div>' for line in _rest(mechanism))
    return f'<div dir="auto">{escape(_title(mechanism))}</div>{f"<table>{table}</table>" if rows else ""}{lines}'


def _title(mechanism: Mechanism) -> str:
    return say("robot.overview", robot=mechanism.name, n=mechanism.n, tip=mechanism.tip)


def _rows(mechanism: Mechanism) -> list[list[str]]:
    """The table, its head first."""
    head = [say(f"robot.column_{name}") for name in ("joint", "kind", "lower", "upper", "speed", "effort")]
    shown = [joint for joint in mechanism.joints if joint.moves]
    return [head, *(_row(joint) for joint in shown[:MOST_JOINTS])]


def _rest(mechanism: Mechanism) -> list[str]:
    """What stands below the table."""
    bodies = [link.inertial for link in mechanism.links if link.inertial is not None and link.inertial.mass > 0.0]
    mass = sum(body.mass for body in bodies)
    more = sum(joint.moves for joint in mechanism.joints) - MOST_JOINTS
    return [
        *([say("robot.overview_more", count=more)] if more > 0 else []),
        say("robot.overview_mass", mass=mass, count=len(bodies)) if bodies else say("robot.overview_massless"),
    ]


def _row(joint: Joint) -> list[str]:
    length, force = ("m", "N") if joint.kind is JointKind.PRISMATIC else ("rad", "N m")
    kind = say(f"robot.kind_{joint.kind.value}")
    if joint.mimic is not None:
        follows = say("robot.follows", kind=kind, leader=_cut(joint.mimic.leader))
        return [_cut(joint.name), follows, "", "", "", ""]
    bounds = joint.limits
    pairs = ((bounds.lower, length), (bounds.upper, length), (bounds.velocity, f"{length}/s"), (bounds.effort, force))
    return [_cut(joint.name), kind, *(f"{value:.4g} {unit}" if isfinite(value) else "-" for value, unit in pairs)]


def _cut(name: str) -> str:
    return name if len(name) <= LONGEST_NAME else name[: LONGEST_NAME - 1] + "…"


def _pad(row: list[str], widths: list[int]) -> list[str]:
    sized = list(zip(row, widths, strict=True))
    return [cell.ljust(size) for cell, size in sized[:2]] + [cell.rjust(size) for cell, size in sized[2:]]
