"""Local dimension: linkages of known mobility with shaky parts of any size, and what the exactness of parts does."""

from itertools import product

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.mobility import Linkage, finite_mobility, joint, library, trace_motion
from mafsil.mobility.finite import FiniteStatus
from mafsil.solvers.local_dimension import local_set, multiplicity
from mafsil.solvers.null_ways import FINEST
from tests.budget import within
from tests.mobility.known_dimensions import MOVING, SHAKY, Part, hung, linkage
from tests.mobility.mechanisms import scissors
from tests.reliability.local_dimensions import SCALES, TABLE, beside_four_bar, miura
from tests.reliability.shaky_parts import work
from tests.sizes import few, size

SOME_SCALES = (1e-3, 0.1, 1.0, 1e3)
PAIRED = ("pendulum", "four bars", "three cranks", "kite", "Bricard, line", "Dixon 1")


def require(part: Part, joints) -> None:
    """The mobility of a part, or a doubt that holds it."""
    found = finite_mobility(linkage(joints))
    if found.status is FiniteStatus.IN_DOUBT:
        assert found.mobility <= part[1] <= found.at_most
    else:
        assert found.mobility == part[1], found.explain("en")


@pytest.mark.capability("02-51")
@pytest.mark.parametrize("name", few(TABLE, 14))
def test_mechanisms_of_known_dimension(name):
    assert len(TABLE) >= 90
    part = TABLE[name]()
    require(part, part[0])
    for scale, bridged in size([(1e-3, False), (1e3, False), (1.0, True)], list(product(SCALES, (False, True)))):
        beside, dimension = beside_four_bar(part, scale, bridged)
        require((part[0], dimension), list(beside.joints))


@pytest.mark.capability("02-51")
def test_many_bodies_take_a_moment():
    sheet = linkage(miura(6, 6)[0])
    for many in (scissors(30), sheet):
        assert within(0.6, lambda many=many: mf.mobility(many)).mobility == 1


@pytest.mark.capability("02-51")
@pytest.mark.parametrize("shaky", SHAKY)
@pytest.mark.parametrize("name", PAIRED)
def test_shaky_parts_of_any_size_beside_a_mechanism_add_nothing(name, shaky):
    for scale in SOME_SCALES:
        part = MOVING[name](1.0)
        require(part, part[0] + hung(SHAKY[shaky](scale), " shaky", shift=(0.3, -0.7, 0.2)))


def test_the_order_with_which_loops_open_is_told():
    for order in (2, 4, 8):
        for scale in SOME_SCALES:
            found = finite_mobility(linkage(SHAKY[f"taut {order}"](scale)[0]))
            assert found.mobility == 0
            assert found.order == pytest.approx(order, abs=0.05)


def test_two_stretched_bars_beside_a_pendulum_are_no_motion_and_proven_so():
    pins = {"A": ("ground", "a", 0), "B": ("a", "b", 0.1), "C": ("b", "ground", 0.2)}
    joints = [joint(name, "R", [a, b], [x, 0]) for name, (a, b, x) in pins.items()]
    found = mf.mobility(Linkage.of([*joints, joint("P", "R", ["ground", "pendulum"], [0, -1])], planar=True))
    assert (found.mobility, found.finite.status, found.finite.proven) == (1, FiniteStatus.SHAKY, True)
    assert "power 2" in found.explain("en")


def test_random_linkages_with_planted_shaky_parts():
    count = work(5, 25)
    assert (count["bad_mobility"], count["linkages"]) == (0, 25)
    assert count["in_doubt"] <= 2


def test_nothing_is_followed_from_a_shaky_start():
    seven_bars = linkage(SHAKY["taut 4"](1.0)[0])
    with pytest.raises(InputError, match="not all continue"):
        trace_motion(seven_bars)


@pytest.mark.parametrize("digits", [3, 4, 6])
def test_a_bennett_linkage_with_typed_digits_moves_with_play(digits):
    drawn = library.bennett(1.0, np.radians(30), 1.5, 1.0)
    joints = [
        joint(
            each.name, each.kind, [each.parent, each.child], np.round(each.point, digits), np.round(each.axis, digits)
        )
        for each in drawn.joints
    ]
    typed = Linkage.of(joints, ground=drawn.ground)
    exact = mf.mobility(typed)
    assert (exact.mobility, len(exact.exactness)) == (0, 1)
    needed = exact.exactness[0].length
    assert 0 < needed < 5 * 10.0**-digits
    assert f"{needed:.2g} m" in exact.explain("en")
    loose, tight = mf.mobility(typed, play=1.01 * needed), mf.mobility(typed, play=0.99 * needed)
    assert (loose.mobility, tight.mobility) == (1, 0)
    assert loose
    assert not tight


def germ(power):
    """y - x^2 = 0, y^power = 0: one solution of multiplicity 2 power."""

    def equations(x):
        F = np.stack([x[:, 1] - x[:, 0] ** 2, x[:, 1] ** power], axis=1)
        J = np.zeros((len(x), 2, 2), dtype=x.dtype)
        J[:, 0, 0], J[:, 0, 1], J[:, 1, 1] = -2 * x[:, 0], 1, power * x[:, 1] ** (power - 1)
        return F, J

    return equations


def test_multiplicities_of_germs():
    for power in (1, 2, 3, 4):
        for kind in (np.float64, np.complex128):
            assert multiplicity(germ(power), np.zeros(2, dtype=kind), 1e-7, FINEST) == 2 * power


def test_real_and_complex_solutions_differ():
    def equations(x):
        F = (x[:, :1] ** 2 + x[:, 1:] ** 2) * (1 + x[:, :1])
        J = np.stack([2 * x[:, 0] * (1 + x[:, 0]) + F[:, 0] / (1 + x[:, 0]), 2 * x[:, 1] * (1 + x[:, 0])], axis=1)
        return F, J[:, None]

    angles = np.linspace(0, np.pi, 7)[:-1]
    real = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    assert local_set(equations, np.zeros(2), real).dimension == 0
    mixed = np.array([[1, 0.9j], [1, -0.8j]]) / np.sqrt(2)
    assert local_set(equations, np.zeros(2, dtype=np.complex128), mixed).dimension == 1
