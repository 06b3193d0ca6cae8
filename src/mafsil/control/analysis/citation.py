"""The works that laws, measures and mathematics of the package come from, by key and by module."""

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


def modules(*names: str) -> tuple[str, ...]:
    """Full names of modules: `modules("control.hybrid")` is `("mafsil.control.hybrid",)`."""
    return tuple(f"mafsil.{name}" for name in names)


WORKS_ON_CONTROL = (
    Citation(
        "lynch2017", "K. M. Lynch, F. C. Park", "Modern Robotics", "Cambridge University Press", 2017,
        modules(
            "control.laws.computed_torque", "control.laws.joint_feedback", "control.laws.tip_motion",
            "control.contact.force", "control.contact.hybrid", "control.contact.impedance",
            "control.contact.impedance_by_force", "control.analysis.compare_pose_errors",
            "control.analysis.block_diagram", "one_joint.error_dynamics", "one_joint.drives.gear",
        ),
    ),
    Citation(
        "khatib1987", "O. Khatib", "A unified approach for motion and force control of robot manipulators",
        "IEEE Journal on Robotics and Automation 3(1)", 1987,
        modules("control.laws.task_dynamics", "control.laws.tip_motion"),
    ),
    Citation(
        "hogan1985", "N. Hogan", "Impedance control: an approach to manipulation",
        "ASME Journal of Dynamic Systems, Measurement, and Control 107", 1985,
        modules("control.contact.impedance", "control.analysis.suitability"),
    ),
    Citation(
        "raibert1981", "M. H. Raibert, J. J. Craig", "Hybrid position/force control of manipulators",
        "ASME Journal of Dynamic Systems, Measurement, and Control 103", 1981, modules("control.contact.hybrid"),
    ),
    Citation(
        "slotine1987", "J.-J. E. Slotine, W. Li", "On the adaptive control of robot manipulators",
        "International Journal of Robotics Research 6(3)", 1987,
        modules("control.laws.adaptive", "control.laws.sliding_mode"),
    ),
    Citation(
        "spong1992", "M. W. Spong", "On the robust control of robot manipulators",
        "IEEE Transactions on Automatic Control 37", 1992, modules("control.analysis.worst_case"),
    ),
    Citation(
        "mayne2000", "D. Q. Mayne, J. B. Rawlings, C. V. Rao, P. O. M. Scokaert",
        "Constrained model predictive control: stability and optimality", "Automatica 36", 2000,
        modules("control.laws.receding_horizon"),
    ),
    Citation(
        "spong1987", "M. W. Spong", "Modeling and control of elastic joint robots",
        "ASME Journal of Dynamic Systems, Measurement, and Control 109", 1987,
        modules("control.joints.elastic_laws"),
    ),
    Citation(
        "tomei1991", "P. Tomei", "A simple PD controller for robots with elastic joints",
        "IEEE Transactions on Automatic Control 36", 1991, modules("control.joints.elastic_laws"),
    ),
    Citation(
        "takegaki1981", "M. Takegaki, S. Arimoto", "A new feedback method for dynamic control of manipulators",
        "ASME Journal of Dynamic Systems, Measurement, and Control 103", 1981,
        modules("control.laws.joint_feedback", "control.analysis.lyapunov"),
    ),
    Citation(
        "colgate1997", "J. E. Colgate, G. Schenkel", "Passivity of a class of sampled-data systems",
        "Journal of Robotic Systems 14(1)", 1997, modules("control.contact.impedance", "control.contact.admittance"),
    ),
    Citation(
        "spong2006", "M. W. Spong, S. Hutchinson, M. Vidyasagar", "Robot Modeling and Control", "Wiley", 2006,
        modules("control.analysis.lyapunov", "control.laws.computed_torque"),
    ),
    Citation(
        "siciliano2009", "B. Siciliano, L. Sciavicco, L. Villani, G. Oriolo",
        "Robotics: Modelling, Planning and Control", "Springer", 2009,
        modules("control.laws.gains", "control.contact.constraint_estimate"),
    ),
    Citation(
        "murray1994", "R. M. Murray, Z. Li, S. S. Sastry", "A Mathematical Introduction to Robotic Manipulation",
        "CRC Press", 1994, modules("control.contact.constraint"),
    ),
    Citation(
        "featherstone2008", "R. Featherstone", "Rigid Body Dynamics Algorithms", "Springer", 2008,
        modules("mechanics.quantities.forward_dynamics", "mechanics.quantities.inverse_dynamics"),
    ),
    Citation(
        "morrison1969", "N. Morrison", "Introduction to Sequential Smoothing and Prediction", "McGraw-Hill", 1969,
        modules("control.joints.motion_estimator"),
    ),
)  # fmt: skip
"""Each with the modules that follow it."""
"""By which the laws and measures of this package go."""

WORKS_OF_ROBOTICS = (
    Citation(
        "hamilton1844", "W. R. Hamilton", "On quaternions, or on a new system of imaginaries in algebra",
        "Philosophical Magazine 25", 1844, modules("algebra.quaternion"),
    ),
    Citation(
        "shoemake1985", "K. Shoemake", "Animating rotation with quaternion curves", "Computer Graphics 19(3)", 1985,
        modules("geometry.quaternion"),
    ),
    Citation(
        "selig2005", "J. M. Selig", "Geometric Fundamentals of Robotics", "Springer", 2005, modules("algebra.se3"),
    ),
    Citation(
        "bruyninckx2010", "H. Bruyninckx", "Robot Kinematics and Dynamics", "KU Leuven", 2010,
        modules("algebra.spatial"),
    ),
    Citation(
        "abramowitz1964", "M. Abramowitz, I. A. Stegun", "Handbook of Mathematical Functions",
        "National Bureau of Standards", 1964, modules("algebra.series"),
    ),
    Citation(
        "anton2005", "H. Anton, C. Rorres", "Elementary Linear Algebra: Applications Version", "Wiley", 2005,
        modules("geometry.rotation"),
    ),
    Citation(
        "kreyszig2011", "E. Kreyszig", "Advanced Engineering Mathematics", "Wiley", 2011,
        modules("one_joint.error_dynamics", "one_joint.second_order"),
    ),
    Citation(
        "atkinson1989", "K. E. Atkinson", "An Introduction to Numerical Analysis", "Wiley", 1989,
        modules("solvers.bracketed_root"),
    ),
    Citation(
        "antia2002", "H. M. Antia", "Numerical Methods for Scientists and Engineers", "Birkhäuser", 2002,
        modules("solvers.integrate"),
    ),
    Citation(
        "kaw2008", "A. K. Kaw, E. E. Kalu", "Numerical Methods with Applications", "University of South Florida", 2008,
        modules("ik.newton"),
    ),
    Citation(
        "sommese2004", "A. J. Sommese, J. Verschelde, C. W. Wampler",
        "Advances in polynomial continuation for solving problems in kinematics",
        "ASME Journal of Mechanical Design 126(2)", 2004, modules("parallel.platforms.platform_paths"),
    ),
    Citation(
        "winston2004", "W. L. Winston", "Operations Research: Applications and Algorithms", "Brooks/Cole", 2004,
        modules("solvers.linear_program"),
    ),
    Citation(
        "harrison1997", "H. R. Harrison, T. Nettleton", "Advanced Engineering Dynamics", "Arnold", 1997,
        modules("mechanics.rigid_body"),
    ),
    Citation(
        "josephs2002", "H. Josephs, R. L. Huston", "Dynamics of Mechanical Systems", "CRC Press", 2002,
        modules("mechanics.rigid_body"),
    ),
    Citation(
        "ruina2015", "A. Ruina, R. Pratap", "Introduction to Statics and Dynamics", "Oxford University Press", 2015,
        modules("mechanics.wrench"),
    ),
    Citation(
        "asada1986", "H. Asada, J.-J. E. Slotine", "Robot Analysis and Control", "Wiley", 1986,
        modules("control.laws.computed_torque"),
    ),
    Citation(
        "craig2005", "J. J. Craig", "Introduction to Robotics: Mechanics and Control", "Prentice Hall", 2005,
        modules("model.denavit_hartenberg"),
    ),
    Citation(
        "mittal2003", "R. K. Mittal, I. J. Nagrath", "Robotics and Control", "Tata McGraw-Hill", 2003,
        modules("model.denavit_hartenberg"),
    ),
    Citation(
        "cubero2007", "S. Cubero", "Industrial Robotics: Theory, Modelling and Control", "Pro Literatur", 2007,
        modules("one_joint.joint_law"),
    ),
    Citation(
        "kurfess2005", "T. R. Kurfess", "Robotics and Automation Handbook", "CRC Press", 2005,
        modules("one_joint.drives.sensors", "one_joint.drives.motor"),
    ),
    Citation(
        "siciliano2008", "B. Siciliano, O. Khatib", "Springer Handbook of Robotics", "Springer", 2008,
        modules("control.laws.tip_motion", "control.contact.hybrid"),
    ),
    Citation(
        "angeles2007", "J. Angeles", "Fundamentals of Robotic Mechanical Systems", "Springer", 2007,
        modules("performance.dexterity.isotropy"),
    ),
    Citation(
        "tsai1999", "L.-W. Tsai", "Robot Analysis: The Mechanics of Serial and Parallel Manipulators", "Wiley", 1999,
        modules("parallel.platforms.stewart"),
    ),
    Citation(
        "dombre2007", "E. Dombre, W. Khalil", "Robot Manipulators: Modeling, Performance Analysis and Control",
        "ISTE", 2007, modules("mechanics.frame_choice"),
    ),
    Citation(
        "park1999", "F. C. Park, J. W. Kim", "Singularity analysis of closed kinematic chains",
        "ASME Journal of Mechanical Design 121(1)", 1999, modules("parallel.loop_singularity"),
    ),
    Citation(
        "nguyen1986", "V.-D. Nguyen", "The synthesis of stable force-closure grasps",
        "MIT Artificial Intelligence Laboratory, TR-905", 1986, modules("grasp.two_fingers"),
    ),
    Citation(
        "mishra1987", "B. Mishra, J. T. Schwartz, M. Sharir",
        "On the existence and synthesis of multifinger positive grips", "Algorithmica 2", 1987,
        modules("grasp.closure"),
    ),
    Citation(
        "li2003", "J.-W. Li, H. Liu, H.-G. Cai",
        "On computing three-finger force-closure grasps of 2-D and 3-D objects",
        "IEEE Transactions on Robotics and Automation 19(1)", 2003, modules("grasp.three_fingers"),
    ),
    Citation(
        "kelly2005", "R. Kelly, V. Santibáñez, A. Loría", "Control of Robot Manipulators in Joint Space", "Springer",
        2005, modules("control.laws.joint_feedback", "control.analysis.lyapunov"),
    ),
    Citation(
        "ahmed2011", "M. R. Ahmed",
        "Compliance control of robot manipulator for safe physical human robot interaction", "Örebro University", 2011,
        modules("control.contact.impedance"),
    ),
    Citation(
        "jazar2010", "R. N. Jazar", "Theory of Applied Robotics: Kinematics, Dynamics, and Control",
        "2nd ed., Springer", 2010, modules("model.denavit_hartenberg", "mechanics.quantities.inverse_dynamics"),
    ),
)  # fmt: skip
"""Each with the modules whose matter it treats."""
"""What stands behind more than control: textbooks, and papers on one question."""

CITATIONS = WORKS_ON_CONTROL + WORKS_OF_ROBOTICS
"""All works, each with the modules that follow it or whose matter it treats."""


def citation(key: str) -> Citation:
    """A work by its key.

    Raises:
        InputError: no such work.
    """
    found = {one.key: one for one in CITATIONS}
    if not isinstance(key, str) or key not in found:  # pyright: ignore[reportUnnecessaryIsInstance] - what users give
        raise InputError("input.choice", name="key", value=key, known=", ".join(found))
    return found[key]


def citations_of(module: str) -> tuple[Citation, ...]:
    """The works that a module follows.

    Args:
        module: its full name, such as `mafsil.control.hybrid`.
    """
    return tuple(one for one in CITATIONS if module in one.modules)
