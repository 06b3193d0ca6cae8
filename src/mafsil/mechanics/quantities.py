"""The catalogue of quantities: one row for each algorithm, read by Robot, CLI, documentation, tests and benchmarks.

A new algorithm is one function of a `BodyTree` and expressions, plus one row here. Builders are named, not imported:
the catalogue is read at every start, expressions are needed only when a kernel has to be built.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING

from mafsil.errors import InputError

if TYPE_CHECKING:
    from mafsil.expression import Expression

INPUTS: Mapping[str, tuple[str | int, ...]] = MappingProxyType(
    {
        "q": ("n",),
        "qd": ("n",),
        "qdd": ("n",),
        "tau": ("n",),
        "tip_wrench": (6,),
        "base_twist": (6,),
        "base_acceleration": (6,),
    }
)
"""Core shapes of all inputs; `n` is the number of joint coordinates."""

INPUT_TEXTS: Mapping[str, str] = MappingProxyType(
    {
        "q": "(*batch, n) joint coordinates [rad | m].",
        "qd": "(*batch, n) joint rates [rad/s | m/s].",
        "qdd": "(*batch, n) joint accelerations [rad/s^2 | m/s^2].",
        "tau": "(*batch, n) joint efforts [N m | N].",
        "tip_wrench": "(*batch, 6) wrench (m, f) the tip exerts on the world, in the tip frame [N m, N]; optional.",
        "base_twist": "(*batch, 6) twist of a carried base: of {s}, which moves with it, in {s}; optional.",
        "base_acceleration": "(*batch, 6) time derivative of the base's twist, without gravity; optional.",
        "frame": "name of the link whose frame is meant; the tip frame if None.",
    }
)


@dataclass(frozen=True, slots=True)
class Quantity:
    """One row of the catalogue.

    Attributes:
        name: the public name, also of the method of Robot.
        symbol: as in the field's texts.
        title: one sentence.
        builder: `module:function` in this package: (tree, *inputs[, frame]) -> expression.
        inputs: names from INPUTS, in order.
        optional: further inputs that may be left out; the builder takes None for them.
        shape: core shape of the result; `n` joints, `L` links.
        unit: of the result.
        framed: whether the result belongs to a frame that the caller may choose.
        regrouped: whether the tree with regrouped inertias gives the same result (and a shorter expression).
        expressed_in: the frame in which the result is expressed, if it has one.
        reference: where the algorithm stands in the literature.
        beside: (names of other quantities, builder): the same result by the sweep that those quantities make too.
    """

    name: str
    symbol: str
    title: str
    builder: str
    inputs: tuple[str, ...]
    shape: tuple[str | int, ...]
    unit: str
    reference: str
    optional: tuple[str, ...] = ()
    framed: bool = False
    regrouped: bool = True
    expressed_in: str = ""
    beside: tuple[tuple[str, ...], str] = ((), "")

    def build(self, others: Collection[str] = ()) -> Callable[..., Expression]:
        """The builder function.

        Args:
            others: names of quantities that are computed at the same time.
        """
        partners, shared = self.beside
        module, _, function = (shared if any(name in others for name in partners) else self.builder).partition(":")
        return getattr(import_module(f"mafsil.mechanics.{module}"), function)

    def doc(self) -> str:
        """Documentation of the quantity as a routine of a robot: arguments, result, reference."""
        names = (*self.inputs, *self.optional, *(("frame",) if self.framed else ()))
        arguments = "\n".join(f"    {name}: {INPUT_TEXTS[name]}" for name in names)
        shape = "".join(f", {size}" for size in self.shape)
        frame = f", expressed in {self.expressed_in}" if self.expressed_in else ""
        return (
            f"{self.title}\n\nArgs:\n{arguments}\n    out: array for the result.\n"
            "    threads: how many threads share a large batch; all cores if None.\n\n"
            f"Returns:\n    {self.symbol} (*batch{shape}) [{self.unit}]{frame}.\n\nRaises:\n"
            "    InputError: a wrong shape, or NaN or infinity in a single call; in a batch such rows become NaN.\n\n"
            f"Reference: {self.reference}"
        )


_LYNCH = "Lynch & Park, Modern Robotics, "
_FEATHERSTONE = "Featherstone, Rigid Body Dynamics Algorithms, "

_ROWS = (
    Quantity(
        "forward_kinematics",
        "T_sf",
        "Pose of the tip frame, or of a named link's frame, in the space frame {s}.",
        "forward_kinematics:forward_kinematics",
        ("q",),
        (4, 4),
        "1, m",
        _LYNCH + "sec. 4.1",
        framed=True,
        regrouped=False,
        expressed_in="{s}",
        beside=(("jacobian_body", "jacobian_body_rate"), "forward_kinematics:forward_kinematics_inward"),
    ),
    Quantity(
        "link_poses",
        "T_sl",
        "Poses of all links in the space frame {s}, in the order of `mechanism.links`.",
        "forward_kinematics:link_poses",
        ("q",),
        ("L", 4, 4),
        "1, m",
        _LYNCH + "sec. 4.1",
        regrouped=False,
        expressed_in="{s}",
    ),
    Quantity(
        "jacobian_space",
        "J_s",
        "Space Jacobian: V_s = J_s qd, rows (omega, v).",
        "jacobian:jacobian_space",
        ("q",),
        (6, "n"),
        "1 | m",
        _LYNCH + "def. 5.1",
        framed=True,
        regrouped=False,
        expressed_in="{s}",
    ),
    Quantity(
        "jacobian_body",
        "J_b",
        "Body Jacobian: V_b = J_b qd, rows (omega, v).",
        "jacobian:jacobian_body",
        ("q",),
        (6, "n"),
        "1 | m",
        _LYNCH + "def. 5.2",
        framed=True,
        regrouped=False,
        expressed_in="the frame itself",
    ),
    Quantity(
        "jacobian_space_rate",
        "dJ_s/dt",
        "Time derivative of the space Jacobian: dV_s/dt = J_s qdd + dJ_s/dt qd.",
        "jacobian:jacobian_space_rate",
        ("q", "qd"),
        (6, "n"),
        "1/s | m/s",
        _LYNCH + "sec. 8.6",
        framed=True,
        regrouped=False,
        expressed_in="{s}",
    ),
    Quantity(
        "jacobian_body_rate",
        "dJ_b/dt",
        "Time derivative of the body Jacobian: dV_b/dt = J_b qdd + dJ_b/dt qd.",
        "jacobian:jacobian_body_rate",
        ("q", "qd"),
        (6, "n"),
        "1/s | m/s",
        _LYNCH + "sec. 8.6",
        framed=True,
        regrouped=False,
        expressed_in="the frame itself",
    ),
    Quantity(
        "inverse_dynamics",
        "tau",
        "Joint efforts that produce a motion: tau = M qdd + c + g + J' F_tip.",
        "inverse_dynamics:inverse_dynamics",
        ("q", "qd", "qdd"),
        ("n",),
        "N m | N",
        "Luh, Walker, Paul 1980; " + _LYNCH + "sec. 8.3",
        optional=("tip_wrench", "base_twist", "base_acceleration"),
    ),
    Quantity(
        "forward_dynamics",
        "qdd",
        "Joint accelerations that efforts produce: M qdd = tau - c - g - J' F_tip.",
        "forward_dynamics:forward_dynamics",
        ("q", "qd", "tau"),
        ("n",),
        "rad/s^2 | m/s^2",
        _FEATHERSTONE + "sec. 6.5 and 7.3",
        optional=("tip_wrench",),
    ),
    Quantity(
        "mass_matrix",
        "M",
        "Mass matrix, symmetric: kinetic energy qd' M qd / 2.",
        "mass_matrix:mass_matrix",
        ("q",),
        ("n", "n"),
        "kg m^2 | kg m | kg",
        _FEATHERSTONE + "sec. 6.2",
    ),
    Quantity(
        "coriolis_matrix",
        "C",
        "Coriolis matrix of the Christoffel symbols: C qd = c, dM/dt - 2 C skew.",
        "coriolis:coriolis_matrix",
        ("q", "qd"),
        ("n", "n"),
        "N m s | N s",
        _LYNCH + "sec. 8.1.3, prop. 8.1",
    ),
    Quantity(
        "velocity_torque",
        "c",
        "Centrifugal and Coriolis efforts c(q, qd).",
        "inverse_dynamics:velocity_torque",
        ("q", "qd"),
        ("n",),
        "N m | N",
        _LYNCH + "sec. 8.1",
    ),
    Quantity(
        "gravity_torque",
        "g",
        "Efforts g(q) that hold the robot still against gravity.",
        "inverse_dynamics:gravity_torque",
        ("q",),
        ("n",),
        "N m | N",
        _LYNCH + "sec. 8.1",
    ),
    Quantity(
        "kinetic_energy",
        "K",
        "Kinetic energy of all links and armatures.",
        "energy:kinetic_energy",
        ("q", "qd"),
        (),
        "J",
        _LYNCH + "sec. 8.1.3",
    ),
    Quantity(
        "potential_energy",
        "P",
        "Potential energy of all links in gravity; zero height at the origin of {s}.",
        "energy:potential_energy",
        ("q",),
        (),
        "J",
        _LYNCH + "sec. 8.1",
        regrouped=False,
    ),
    Quantity(
        "centrifugal_torque",
        "c_centrifugal",
        "Centrifugal efforts: the sum of Gamma_ijj qd_j^2.",
        "velocity_parts:centrifugal_torque",
        ("q", "qd"),
        ("n",),
        "N m | N",
        _LYNCH + "sec. 8.1.1",
    ),
    Quantity(
        "coriolis_torque",
        "c_Coriolis",
        "Coriolis efforts: the sum of 2 Gamma_ijk qd_j qd_k over j < k.",
        "velocity_parts:coriolis_torque",
        ("q", "qd"),
        ("n",),
        "N m | N",
        _LYNCH + "sec. 8.1.1",
    ),
    Quantity(
        "christoffel_symbols",
        "Gamma",
        "Christoffel symbols of the first kind: c_i = sum of Gamma_ijk qd_j qd_k.",
        "coriolis:christoffel_symbols",
        ("q",),
        ("n", "n", "n"),
        "kg m^2 | kg m | kg",
        _LYNCH + "eq. 8.12",
    ),
    Quantity(
        "lagrange_torque",
        "tau",
        "Joint efforts of a motion from the energies, by Lagrange's equations: the second road to `inverse_dynamics`.",
        "lagrange:lagrange_torque",
        ("q", "qd", "qdd"),
        ("n",),
        "N m | N",
        _LYNCH + "sec. 8.1.2",
        regrouped=False,
    ),
    Quantity(
        "inverse_dynamics_derivatives",
        "dtau/d(q, qd, qdd)",
        "Derivatives of inverse dynamics, in closed form: [0] by q, [1] by qd, [2] by qdd, the mass matrix.",
        "derivatives:inverse_dynamics_derivatives",
        ("q", "qd", "qdd"),
        (3, "n", "n"),
        "N m | N per rad | m, and per s, s^2",
        "Singh, Wensing, Echeandia 2022",
        optional=("tip_wrench",),
    ),
    Quantity(
        "forward_dynamics_derivatives",
        "dqdd/d(q, qd, tau)",
        "Derivatives of forward dynamics, in closed form: [0] by q, [1] by qd, [2] by tau, the inverse mass matrix.",
        "derivatives:forward_dynamics_derivatives",
        ("q", "qd", "tau"),
        (3, "n", "n"),
        "rad/s^2 | m/s^2 per rad | m, per their rates, per N m | N",
        "Carpentier & Mansard 2018",
        optional=("tip_wrench",),
    ),
    Quantity(
        "link_twists",
        "V_l",
        "Body twists of all links, each in its own frame, in the order of `mechanism.links`.",
        "link_motion:link_twists",
        ("q", "qd"),
        ("L", 6),
        "rad/s, m/s",
        _LYNCH + "eq. 8.50",
        optional=("base_twist",),
        regrouped=False,
        expressed_in="the links' frames",
    ),
    Quantity(
        "link_accelerations",
        "dV_l/dt",
        "Time derivatives of the body twists of all links, gravity given back, each in its own frame.",
        "link_motion:link_accelerations",
        ("q", "qd", "qdd"),
        ("L", 6),
        "rad/s^2, m/s^2",
        _LYNCH + "eq. 8.51",
        optional=("base_twist", "base_acceleration"),
        regrouped=False,
        expressed_in="the links' frames",
    ),
    Quantity(
        "link_wrenches",
        "F_l",
        "Wrenches that each link gets from the one before (the first from the ground), through any joint.",
        "link_wrenches:link_wrenches",
        ("q", "qd", "qdd"),
        ("L", 6),
        "N m, N",
        _LYNCH + "eq. 8.53",
        optional=("tip_wrench", "base_twist", "base_acceleration"),
        regrouped=False,
        expressed_in="the links' frames",
    ),
    Quantity(
        "com_twists",
        "V_i",
        "Twists of all links in frames at their centres of mass, parallel to {s} at zero coordinates.",
        "link_motion:com_twists",
        ("q", "qd"),
        ("L", 6),
        "rad/s, m/s",
        _LYNCH + "eq. 8.50",
        optional=("base_twist",),
        regrouped=False,
        expressed_in="frames at the centres of mass",
    ),
    Quantity(
        "com_accelerations",
        "dV_i/dt",
        "Time derivatives of the twists at the centres of mass, gravity given back.",
        "link_motion:com_accelerations",
        ("q", "qd", "qdd"),
        ("L", 6),
        "rad/s^2, m/s^2",
        _LYNCH + "eq. 8.51",
        optional=("base_twist", "base_acceleration"),
        regrouped=False,
        expressed_in="frames at the centres of mass",
    ),
    Quantity(
        "com_wrenches",
        "F_i",
        "Wrenches as `link_wrenches`, at the centres of mass, in axes parallel to {s} at zero coordinates.",
        "link_wrenches:com_wrenches",
        ("q", "qd", "qdd"),
        ("L", 6),
        "N m, N",
        _LYNCH + "eq. 8.53",
        optional=("tip_wrench", "base_twist", "base_acceleration"),
        regrouped=False,
        expressed_in="frames at the centres of mass",
    ),
    Quantity(
        "regressor",
        "Y",
        "Efforts per inertial parameter of each link (m, h, Ixx, Iyy, Izz, Ixy, Ixz, Iyz), in the links' frames.",
        "regressor:regressor",
        ("q", "qd", "qdd"),
        ("n", "L", 10),
        "m/s^2, 1/s^2 and so on",
        "Atkeson, An & Hollerbach 1986",
        regrouped=False,
    ),
    Quantity(
        "payload_regressor",
        "Y_f",
        "Efforts per inertial parameter of a body fixed to the tip frame, or to a named link's frame.",
        "regressor:frame_regressor",
        ("q", "qd", "qdd"),
        ("n", 10),
        "m/s^2, 1/s^2 and so on",
        "Atkeson, An & Hollerbach 1986",
        framed=True,
        regrouped=False,
        expressed_in="the frame itself",
    ),
)

CATALOGUE: Mapping[str, Quantity] = MappingProxyType({row.name: row for row in _ROWS})
"""All quantities by name."""


def quantity(name: str) -> Quantity:
    """The row of that name.

    Raises:
        InputError: there is none; the sentence lists the names.
    """
    if name not in CATALOGUE:
        raise InputError("input.choice", name="quantity", value=name, known=", ".join(CATALOGUE))
    return CATALOGUE[name]
