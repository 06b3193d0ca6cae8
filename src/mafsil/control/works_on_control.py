"""Works on the control of robots, by which the laws and measures of this package go."""

from __future__ import annotations

from mafsil.control.cited_work import Citation, modules

WORKS_ON_CONTROL = (
    Citation(
        "lynch2017", "K. M. Lynch, F. C. Park", "Modern Robotics", "Cambridge University Press", 2017,
        modules(
            "control.computed_torque", "control.joint_feedback", "control.task_space", "control.force",
            "control.hybrid", "control.impedance", "control.impedance_by_force", "control.compare_pose_errors",
            "control.block_diagram", "one_joint.error_dynamics", "one_joint.gear",
        ),
    ),
    Citation(
        "khatib1987", "O. Khatib", "A unified approach for motion and force control of robot manipulators",
        "IEEE Journal on Robotics and Automation 3(1)", 1987,
        modules("control.task_dynamics", "control.task_space", "control.null_space"),
    ),
    Citation(
        "hogan1985", "N. Hogan", "Impedance control: an approach to manipulation",
        "ASME Journal of Dynamic Systems, Measurement, and Control 107", 1985,
        modules("control.impedance", "control.suitability"),
    ),
    Citation(
        "raibert1981", "M. H. Raibert, J. J. Craig", "Hybrid position/force control of manipulators",
        "ASME Journal of Dynamic Systems, Measurement, and Control 103", 1981, modules("control.hybrid"),
    ),
    Citation(
        "slotine1987", "J.-J. E. Slotine, W. Li", "On the adaptive control of robot manipulators",
        "International Journal of Robotics Research 6(3)", 1987, modules("control.adaptive", "control.sliding_mode"),
    ),
    Citation(
        "spong1992", "M. W. Spong", "On the robust control of robot manipulators",
        "IEEE Transactions on Automatic Control 37", 1992, modules("control.worst_case"),
    ),
    Citation(
        "mayne2000", "D. Q. Mayne, J. B. Rawlings, C. V. Rao, P. O. M. Scokaert",
        "Constrained model predictive control: stability and optimality", "Automatica 36", 2000,
        modules("control.receding_horizon"),
    ),
    Citation(
        "spong1987", "M. W. Spong", "Modeling and control of elastic joint robots",
        "ASME Journal of Dynamic Systems, Measurement, and Control 109", 1987,
        modules("control.elastic_arm", "control.elastic_laws"),
    ),
    Citation(
        "tomei1991", "P. Tomei", "A simple PD controller for robots with elastic joints",
        "IEEE Transactions on Automatic Control 36", 1991, modules("control.elastic_laws"),
    ),
    Citation(
        "takegaki1981", "M. Takegaki, S. Arimoto", "A new feedback method for dynamic control of manipulators",
        "ASME Journal of Dynamic Systems, Measurement, and Control 103", 1981,
        modules("control.joint_feedback", "control.lyapunov"),
    ),
    Citation(
        "colgate1997", "J. E. Colgate, G. Schenkel", "Passivity of a class of sampled-data systems",
        "Journal of Robotic Systems 14(1)", 1997, modules("control.impedance", "control.admittance"),
    ),
    Citation(
        "spong2006", "M. W. Spong, S. Hutchinson, M. Vidyasagar", "Robot Modeling and Control", "Wiley", 2006,
        modules("control.lyapunov", "control.computed_torque"),
    ),
    Citation(
        "siciliano2009", "B. Siciliano, L. Sciavicco, L. Villani, G. Oriolo",
        "Robotics: Modelling, Planning and Control", "Springer", 2009,
        modules("control.inertia_gains", "control.estimate_contact_constraint"),
    ),
    Citation(
        "murray1994", "R. M. Murray, Z. Li, S. S. Sastry", "A Mathematical Introduction to Robotic Manipulation",
        "CRC Press", 1994, modules("control.constraint"),
    ),
    Citation(
        "featherstone2008", "R. Featherstone", "Rigid Body Dynamics Algorithms", "Springer", 2008,
        modules("mechanics.quantities.forward_dynamics", "mechanics.quantities.inverse_dynamics"),
    ),
    Citation(
        "morrison1969", "N. Morrison", "Introduction to Sequential Smoothing and Prediction", "McGraw-Hill", 1969,
        modules("control.motion_estimator"),
    ),
)  # fmt: skip
"""Each with the modules that follow it."""
