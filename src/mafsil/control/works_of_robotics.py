"""Works of robotics and its mathematics that stand behind more than control: textbooks, and papers on one question."""

from __future__ import annotations

from mafsil.control.cited_work import Citation, modules

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
        modules("solvers.tableaus"),
    ),
    Citation(
        "kaw2008", "A. K. Kaw, E. E. Kalu", "Numerical Methods with Applications", "University of South Florida", 2008,
        modules("ik.newton"),
    ),
    Citation(
        "sommese2004", "A. J. Sommese, J. Verschelde, C. W. Wampler",
        "Advances in polynomial continuation for solving problems in kinematics",
        "ASME Journal of Mechanical Design 126(2)", 2004, modules("parallel.platform_paths"),
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
        modules("control.computed_torque"),
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
        modules("one_joint.joint_arm"),
    ),
    Citation(
        "kurfess2005", "T. R. Kurfess", "Robotics and Automation Handbook", "CRC Press", 2005,
        modules("one_joint.sensors", "one_joint.motor"),
    ),
    Citation(
        "siciliano2008", "B. Siciliano, O. Khatib", "Springer Handbook of Robotics", "Springer", 2008,
        modules("control.task_space", "control.hybrid"),
    ),
    Citation(
        "angeles2007", "J. Angeles", "Fundamentals of Robotic Mechanical Systems", "Springer", 2007,
        modules("performance.dexterity.isotropy"),
    ),
    Citation(
        "tsai1999", "L.-W. Tsai", "Robot Analysis: The Mechanics of Serial and Parallel Manipulators", "Wiley", 1999,
        modules("parallel.stewart"),
    ),
    Citation(
        "dombre2007", "E. Dombre, W. Khalil", "Robot Manipulators: Modeling, Performance Analysis and Control",
        "ISTE", 2007, modules("mechanics.regrouping"),
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
        2005, modules("control.joint_feedback", "control.lyapunov"),
    ),
    Citation(
        "ahmed2011", "M. R. Ahmed",
        "Compliance control of robot manipulator for safe physical human robot interaction", "Örebro University", 2011,
        modules("control.impedance"),
    ),
)  # fmt: skip
"""Each with the modules whose matter it treats."""
