"""Every public function that wants a robot takes a Robot, a Mechanism, a library name or a path; pictures take text."""

import numpy as np
import pytest

import mafsil as mf
from mafsil import control, derivation, figures, performance
from mafsil.errors import InputError
from mafsil.figures.velocity_ellipses import save_planar_ellipses
from mafsil.identification import read_log
from mafsil.model import library, screws, urdf
from mafsil.model.dh_from_axes import dh_from_mechanism
from mafsil.model.local_exponentials import local_screws

Q2, Q6 = [0.3, 0.4], [0.1, -1.0, 1.2, 0.2, 0.5, 0.3]
T6 = mf.load("ur5e").forward_kinematics(Q6)


@pytest.fixture(scope="module")
def forms(tmp_path_factory):
    from mafsil.model import table

    path = tmp_path_factory.mktemp("forms") / "planar2r.toml"
    table.write(library.load("planar2r"), path)
    return ["planar2r", library.load("planar2r"), mf.load("planar2r"), path, str(path)]


CALLS = {
    "singular_values": lambda r: performance.singular_values(r, Q2, task="planar_position"),
    "velocity_ellipsoid": lambda r: performance.velocity_ellipsoid(r, Q2, "planar").lengths,
    "is_singular": lambda r: performance.is_singular(r, Q2, task="planar_position"),
    "joint_torque": lambda r: performance.joint_torque(r, Q2, np.ones(6)),
    "tool_jacobian": lambda r: performance.tool_jacobian(r, Q2),
    "analytic_jacobian": lambda r: performance.analytic_jacobian(r, Q2),
    "natural_task": performance.natural_task,
    "joint_twists": lambda r: performance.joint_twists(r, Q2, Q2),
    "generic_rank": performance.generic_rank,
    "inverse_kinematics": lambda r: mf.inverse_kinematics(r, mf.load("planar2r").forward_kinematics(Q2)).q,
    "solve_ik": lambda r: mf.solve_ik(r, mf.load("planar2r").forward_kinematics(Q2), Q2).q,
    "derive_fk": lambda r: len(derivation.derive_fk(r).steps),
    "screws": lambda r: screws(r).S_s,
    "local_screws": lambda r: local_screws(r)[2],
    "dh": lambda r: [row.a for row in dh_from_mechanism(r).rows],
    "check_dh": lambda r: bool(derivation.check_dh(dh_from_mechanism(library.load("planar2r")).rows, r)),
    "check_screws": lambda r: bool(derivation.check_screws(screws(library.load("planar2r")).S_s, r)),
    "computed_torque": lambda r: control.computed_torque(r) is not None,
    "Plant": lambda r: mf.simulation.Plant(r).robot.n,
}


@pytest.mark.parametrize("name", CALLS)
def test_all_forms_of_a_robot_give_the_same(name, forms):
    results = [CALLS[name](form) for form in forms]
    for result in results[1:]:
        if isinstance(result, str):
            assert result == results[0]
        else:
            np.testing.assert_allclose(result, results[0], atol=1e-12)


@pytest.mark.parametrize("wrong", [None, 7, np.eye(4), mf.Robot])
@pytest.mark.parametrize(
    "name", ["singular_values", "inverse_kinematics", "solve_ik", "derive_fk", "screws", "check_dh"]
)
def test_what_is_no_robot_is_said(name, wrong):
    with pytest.raises(InputError) as caught:
        CALLS[name](wrong)
    assert caught.value.key == "robot.source"


def test_pictures_take_text_and_name_wrong_endings(tmp_path):
    arm = mf.load("planar2r")
    figures.plot_mechanism(arm, str(tmp_path / "a.png"))
    figures.plot_configurations("planar2r", [Q2], str(tmp_path / "b.svg"))
    save_planar_ellipses(arm.mechanism, [Q2], str(tmp_path / "c.pdf"))
    assert all((tmp_path / name).stat().st_size > 1000 for name in ("a.png", "b.svg", "c.pdf"))
    with pytest.raises(InputError) as caught:
        figures.plot_mechanism(arm, str(tmp_path / "a.html"))
    assert caught.value.key == "pictures.ending"
    assert ".svg" in caught.value.message("ar")
    with pytest.raises(InputError) as caught:
        figures.plot_frames({"a": np.eye(4)}, 3)
    assert caught.value.key == "input.kind"


def test_other_doors_take_them_too(tmp_path):
    assert "<robot" in urdf.write("ur5e")
    assert mf.export("ur5e", "forward_kinematics").name
    log = tmp_path / "log.csv"
    log.write_text("t,q1,q2,tau1,tau2\n0,0,0,0,0\n0.01,0,0,0,0\n0.02,0,0,0,0\n")
    assert read_log(log, "planar2r").q.shape == (3, 2)
    assert len(mf.inverse_kinematics("ur5e", T6).q) == 8
