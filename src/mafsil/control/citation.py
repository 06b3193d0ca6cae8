"""The works that laws and measures of control come from, as data."""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.errors import InputError


@dataclass(frozen=True, slots=True)
class Citation:
    """One work.

    Attributes:
        key: short name, such as `khatib1987`.
        authors, title, where: as one cites it.
        year: of publication.
        modules: of the package that follow it.
    """

    key: str
    authors: str
    title: str
    where: str
    year: int
    modules: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.authors}: {self.title}. {self.where}, {self.year}."

    def bibtex(self) -> str:
        """The entry for a bibliography in LaTeX."""
        return (
            f"@misc{{{self.key},\n  author = {{{self.authors.replace(', ', ' and ')}}},\n  title = {{{self.title}}},\n"
            f"  howpublished = {{{self.where}}},\n  year = {{{self.year}}}\n}}"
        )


def _control(*names: str) -> tuple[str, ...]:
    return tuple(f"mafsil.control.{name}" for name in names)


CITATIONS = (
    Citation(
        "lynch2017",
        "K. M. Lynch, F. C. Park",
        "Modern Robotics",
        "Cambridge University Press",
        2017,
        (
            *_control(
                "computed_torque",
                "joint_feedback",
                "task_space",
                "force",
                "hybrid",
                "impedance",
                "impedance_by_force",
                "tip_ways",
                "block_diagram",
            ),
            "mafsil.one_joint.error_dynamics",
            "mafsil.one_joint.gear",
        ),
    ),
    Citation(
        "khatib1987",
        "O. Khatib",
        "A unified approach for motion and force control of robot manipulators",
        "IEEE Journal on Robotics and Automation 3(1)",
        1987,
        _control("task_dynamics", "task_space", "null_space"),
    ),
    Citation(
        "hogan1985",
        "N. Hogan",
        "Impedance control: an approach to manipulation",
        "ASME Journal of Dynamic Systems, Measurement, and Control 107",
        1985,
        _control("impedance", "suitability"),
    ),
    Citation(
        "raibert1981",
        "M. H. Raibert, J. J. Craig",
        "Hybrid position/force control of manipulators",
        "ASME Journal of Dynamic Systems, Measurement, and Control 103",
        1981,
        _control("hybrid"),
    ),
    Citation(
        "slotine1987",
        "J.-J. E. Slotine, W. Li",
        "On the adaptive control of robot manipulators",
        "International Journal of Robotics Research 6(3)",
        1987,
        _control("adaptive", "sliding_mode"),
    ),
    Citation(
        "spong1992",
        "M. W. Spong",
        "On the robust control of robot manipulators",
        "IEEE Transactions on Automatic Control 37",
        1992,
        _control("worst_case"),
    ),
    Citation(
        "mayne2000",
        "D. Q. Mayne, J. B. Rawlings, C. V. Rao, P. O. M. Scokaert",
        "Constrained model predictive control: stability and optimality",
        "Automatica 36",
        2000,
        _control("receding_horizon"),
    ),
    Citation(
        "spong1987",
        "M. W. Spong",
        "Modeling and control of elastic joint robots",
        "ASME Journal of Dynamic Systems, Measurement, and Control 109",
        1987,
        _control("elastic_arm", "elastic_laws"),
    ),
    Citation(
        "tomei1991",
        "P. Tomei",
        "A simple PD controller for robots with elastic joints",
        "IEEE Transactions on Automatic Control 36",
        1991,
        _control("elastic_laws"),
    ),
    Citation(
        "takegaki1981",
        "M. Takegaki, S. Arimoto",
        "A new feedback method for dynamic control of manipulators",
        "ASME Journal of Dynamic Systems, Measurement, and Control 103",
        1981,
        _control("joint_feedback", "lyapunov"),
    ),
    Citation(
        "colgate1997",
        "J. E. Colgate, G. Schenkel",
        "Passivity of a class of sampled-data systems",
        "Journal of Robotic Systems 14(1)",
        1997,
        _control("impedance", "admittance"),
    ),
    Citation(
        "spong2006",
        "M. W. Spong, S. Hutchinson, M. Vidyasagar",
        "Robot Modeling and Control",
        "Wiley",
        2006,
        _control("lyapunov", "computed_torque"),
    ),
    Citation(
        "siciliano2009",
        "B. Siciliano, L. Sciavicco, L. Villani, G. Oriolo",
        "Robotics: Modelling, Planning and Control",
        "Springer",
        2009,
        _control("inertia_gains", "felt_constraint"),
    ),
    Citation(
        "murray1994",
        "R. M. Murray, Z. Li, S. S. Sastry",
        "A Mathematical Introduction to Robotic Manipulation",
        "CRC Press",
        1994,
        _control("constraint"),
    ),
    Citation(
        "featherstone2008",
        "R. Featherstone",
        "Rigid Body Dynamics Algorithms",
        "Springer",
        2008,
        ("mafsil.mechanics.quantities.forward_dynamics", "mafsil.mechanics.quantities.inverse_dynamics"),
    ),
    Citation(
        "morrison1969",
        "N. Morrison",
        "Introduction to Sequential Smoothing and Prediction",
        "McGraw-Hill",
        1969,
        _control("motion_estimator"),
    ),
)
"""All works, each with the modules that follow it."""


def citation(key: str) -> Citation:
    """A work by its key.

    Raises:
        InputError: no such work.
    """
    found = {one.key: one for one in CITATIONS}
    if key not in found:
        raise InputError("input.choice", name="key", value=key, known=", ".join(found))
    return found[key]


def citations_of(module: str) -> tuple[Citation, ...]:
    """The works that a module follows.

    Args:
        module: its full name, such as `mafsil.control.hybrid`.
    """
    return tuple(one for one in CITATIONS if module in one.modules)
