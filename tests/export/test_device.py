"""Batches on a device: the launch arithmetic on a stand-in driver, and on a real device where there is one."""

from __future__ import annotations

import contextlib
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil.errors import InputError, KernelError
from mafsil.kernels.device import array, batch, driver
from mafsil.kernels.device.array import DeviceArray, device_array
from mafsil.kernels.device.batch import DeviceEvaluator, source
from mafsil.kernels.device.driver import Driver
from mafsil.kernels.ptx.program import GridProgram, device_program
from tests.export.fake_driver import FakeLibrary, emulated

ROBOT, SMALL = mf.load("panda"), mf.load("puma560")
rng = np.random.default_rng(5)


def _program(quantity: str) -> GridProgram:
    kernel = ROBOT.kernel(quantity)
    return device_program(kernel.signature, kernel.build)


@pytest.fixture
def library(monkeypatch: pytest.MonkeyPatch) -> FakeLibrary:
    """A computer with two stand-in devices."""
    return installed(monkeypatch, FakeLibrary(devices=2))


def installed(monkeypatch: pytest.MonkeyPatch, library: FakeLibrary) -> FakeLibrary:
    found = Driver(library)
    monkeypatch.setattr(array, "driver", lambda: found)
    monkeypatch.setattr(batch, "driver", lambda: found)
    return library


class Foreign:
    """An array of somebody else's: only the interface."""

    def __init__(self, inner: DeviceArray, **changes: Any) -> None:
        self.inner = inner
        self.changes = changes

    @property
    def __cuda_array_interface__(self) -> dict[str, Any]:
        details = {**self.inner.__cuda_array_interface__, **self.changes}
        return {key: value for key, value in details.items() if value != "absent"}


def evaluator(library: FakeLibrary, quantity: str, robot: mf.Robot = ROBOT) -> DeviceEvaluator:
    kernel = robot.kernel(quantity)
    library.learn(kernel)
    return DeviceEvaluator(kernel.signature, lambda: emulated(kernel)[1])


@pytest.mark.parametrize("rows", [1, 2, 31, 32, 33, 127, 128, 129, 255, 256, 257, 1000])
def test_rows_of_every_tail_have_the_bits_of_the_processor(library: FakeLibrary, rows: int) -> None:
    evaluate = evaluator(library, "inverse_dynamics")
    q, qd, qdd = rng.uniform(-3, 3, (3, rows, 7))
    q[0, 0], q[-1, 3] = 1e9, -1e300
    found = evaluate(*map(device_array, (q, qd, qdd)))
    assert np.array_equal(found.numpy(), ROBOT.inverse_dynamics(q, qd, qdd))
    assert library.launches[-1]["blocks"] == -(-rows // 128)
    assert library.intact()


@pytest.mark.parametrize(
    "quantity", ["forward_kinematics", "mass_matrix", "potential_energy", "christoffel_symbols", "jacobian_body"]
)
def test_rows_of_every_size(library: FakeLibrary, quantity: str) -> None:
    """Even rows, single numbers, and rows too long for shared memory."""
    evaluate = evaluator(library, quantity, SMALL)
    q = rng.uniform(-3, 3, (70, 6))
    assert np.array_equal(evaluate(device_array(q)).numpy(), getattr(SMALL, quantity)(q))
    assert np.array_equal(evaluate(device_array(q[0])).numpy(), getattr(SMALL, quantity)(q[0]))
    assert library.intact()


def split(own: tuple[int, ...], whole: tuple[int, ...]) -> bool:
    """The axes along which an argument does not repeat are not neighbours (axes of length 1 do not count)."""
    own = (1,) * (len(whole) - len(own)) + own
    kept = [a == b for a, b in zip(own, whole, strict=True) if b != 1]
    return "TFT" in re.sub("(.)\\1+", "\\1", "".join("FT"[k] for k in kept))


SHAPES = st.lists(st.integers(1, 4), min_size=0, max_size=3)


@settings(deadline=None, max_examples=60)
@given(SHAPES, st.data())
def test_broadcast_is_that_of_numpy_or_refused(batch_shape: list[int], data: st.DataObject) -> None:
    library = FakeLibrary()
    with pytest.MonkeyPatch.context() as monkeypatch:
        installed(monkeypatch, library)
        evaluate = evaluator(library, "velocity_torque")
        operands: list[np.ndarray[Any, Any]] = []
        for _ in range(2):
            own = [data.draw(st.sampled_from([1, size])) for size in batch_shape]
            own = own[data.draw(st.integers(0, len(own))) :]
            operands.append(rng.uniform(-3, 3, (*own, 7)))
        whole = np.broadcast_shapes(*(x.shape[:-1] for x in operands))
        found = None
        with contextlib.suppress(InputError):
            found = evaluate(*map(device_array, operands))
        if found is None:
            assert any(split(x.shape[:-1], whole) for x in operands)
        else:
            assert np.array_equal(found.numpy(), ROBOT.velocity_torque(*operands))
        assert library.intact()


def test_sources_of_broadcast_rows() -> None:
    assert source((3, 4), (3, 4), "q") == (1, 0)
    assert source((), (3, 4), "q") == (1, 1)
    assert source((1, 4), (3, 4), "q") == (1, 4)
    assert source((3, 1), (3, 4), "q") == (4, 3)
    assert source((3, 1), (3, 1), "q") == (1, 0)
    with pytest.raises(InputError, match=r"cupy\.broadcast_to"):
        source((2, 1, 3), (2, 5, 3), "q")


def test_robot_takes_arrays_on_the_device(library: FakeLibrary) -> None:
    library.learn(ROBOT.kernel("mass_matrix"))
    q = rng.uniform(-3, 3, (5, 7))
    found = ROBOT.mass_matrix(mf.kernels.device_array(q))
    assert isinstance(found, mf.kernels.DeviceArray)
    assert found.__cuda_array_interface__["shape"] == (5, 7, 7)
    assert found.__cuda_array_interface__["typestr"] == "<f8"
    assert np.array_equal(found.numpy(), ROBOT.mass_matrix(q))
    assert np.array_equal(ROBOT.mass_matrix(q=Foreign(mf.kernels.device_array(q))).numpy(), ROBOT.mass_matrix(q))
    assert np.array_equal(
        ROBOT.kernel("mass_matrix").on_device(mf.kernels.device_array(q)).numpy(), ROBOT.mass_matrix(q)
    )


def test_frames_and_optional_inputs(library: FakeLibrary) -> None:
    frame = ROBOT.mechanism.link_names[3]
    library.learn(ROBOT.kernel("jacobian_body", frame))
    library.learn(ROBOT.kernel("inverse_dynamics", None, ("tip_wrench",)))
    q, wrench = rng.uniform(-3, 3, (5, 7)), rng.uniform(-3, 3, 6)
    on = device_array(q)
    assert np.array_equal(ROBOT.jacobian_body(on, frame=frame).numpy(), ROBOT.jacobian_body(q, frame=frame))
    loaded = ROBOT.inverse_dynamics(on, on, on, tip_wrench=device_array(wrench))
    assert np.array_equal(loaded.numpy(), ROBOT.inverse_dynamics(q, q, q, tip_wrench=wrench))


def test_a_single_state_and_an_empty_batch(library: FakeLibrary) -> None:
    evaluate = evaluator(library, "potential_energy")
    q = rng.uniform(-3, 3, 7)
    found = evaluate(device_array(q))
    assert found.shape == ()
    assert found.numpy() == ROBOT.potential_energy(q)
    count = len(library.launches)
    assert evaluate(device_array(np.zeros((0, 7)))).numpy().shape == (0,)
    assert len(library.launches) == count
    with pytest.raises(TypeError):
        len(found)


def test_nan_stays_in_its_row(library: FakeLibrary) -> None:
    evaluate = evaluator(library, "gravity_torque")
    q = rng.uniform(-3, 3, (200, 7))
    clean = evaluate(device_array(q)).numpy()
    q[77] = np.nan
    dirty = evaluate(device_array(q)).numpy()
    assert np.isnan(dirty[77]).any()
    assert np.array_equal(np.delete(dirty, 77, 0), np.delete(clean, 77, 0))


def test_results_into_given_arrays(library: FakeLibrary) -> None:
    evaluate = evaluator(library, "gravity_torque")
    q = rng.uniform(-3, 3, (9, 7))
    on, out = device_array(q), device_array(np.zeros((9, 7)))
    assert evaluate(on, out=out) is out
    assert np.array_equal(out.numpy(), ROBOT.gravity_torque(q))
    foreign = Foreign(device_array(np.zeros((9, 7))), stream=5)
    assert evaluate(on, out=(foreign,)) is foreign
    assert library.waits[-1] == 1
    with pytest.raises(InputError, match="array of its own"):
        evaluate(on, out=on)
    with pytest.raises(InputError, match="read-only"):
        evaluate(on, out=Foreign(out, data=(out.__cuda_array_interface__["data"][0], True)))
    with pytest.raises(InputError, match=r"\(9, 7\)"):
        evaluate(on, out=device_array(np.zeros((8, 7))))
    with pytest.raises(InputError):
        evaluate(on, out=(out, out))
    with pytest.raises(InputError, match="out does not"):
        evaluate(on, out=np.zeros((9, 7)))


def test_streams_follow_the_arguments(library: FakeLibrary) -> None:
    evaluate = evaluator(library, "velocity_torque")
    x = device_array(rng.uniform(-3, 3, (9, 7)))
    result = evaluate(Foreign(x, stream=7), Foreign(x, stream=None))
    assert library.launches[-1]["stream"] == 7
    assert result.__cuda_array_interface__["stream"] == 7
    evaluate(Foreign(x, stream=7), Foreign(x, stream=9))
    assert library.launches[-1]["stream"] == 9
    assert library.waits[-1] == 7
    evaluate(x, x)
    assert library.launches[-1]["stream"] == 1


def test_all_arguments_on_one_device(library: FakeLibrary) -> None:
    evaluate = evaluator(library, "velocity_torque")
    q = rng.uniform(-3, 3, (9, 7))
    here, there = device_array(q), device_array(q, device=1)
    with pytest.raises(InputError, match="device 1, the others on device 0"):
        evaluate(here, there)
    found = evaluate(there, there)
    assert library.launches[-1]["device"] == 1
    assert found.device.ordinal == 1
    with pytest.raises(InputError, match="out lies on device 0"):
        evaluate(there, there, out=device_array(q))
    with pytest.raises(InputError, match="there are 2"):
        device_array(q, device=2)


def test_wrong_arrays_are_refused_by_name(library: FakeLibrary) -> None:
    q = rng.uniform(-3, 3, (9, 7))
    x = device_array(q)
    refused = [
        ({"typestr": "<f4"}, "x.double"),
        ({"strides": (112, 8)}, "contiguous"),
        ({"mask": x}, "masked"),
        ({"version": "absent"}, "lacks version"),
        ({"shape": (9, 6)}, r"expected|\(\*batch, 7\)"),
    ]
    for changes, sentence in refused:
        with pytest.raises(InputError, match=sentence):
            ROBOT.gravity_torque(Foreign(x, **changes))
    assert not library.launches
    with pytest.raises(InputError, match="nothing is copied unasked"):
        ROBOT.velocity_torque(x, q)
    with pytest.raises(InputError, match="threads"):
        ROBOT.gravity_torque(x, threads=2)
    with pytest.raises(InputError, match=r"call \.numpy\(\)"):
        np.asarray(x)
    with pytest.raises(InputError):
        device_array(["a"])
    with pytest.raises(InputError):
        ROBOT.velocity_torque(x, device_array(q[:4]))


def test_strides_that_do_not_matter(library: FakeLibrary) -> None:
    evaluate = evaluator(library, "gravity_torque")
    x = device_array(rng.uniform(-3, 3, (1, 7)))
    assert evaluate(Foreign(x, strides=(8, 8))).shape == (1, 7)
    assert evaluate(Foreign(device_array(np.zeros((0, 7))), strides=(3, 5))).shape == (0, 7)


def test_memory_goes_back(library: FakeLibrary) -> None:
    x = device_array(np.zeros((4, 7)))
    assert x.nbytes == 224
    assert x.ndim == 2
    assert len(x) == 4
    assert "Stand-in" in repr(x)
    assert "sm_90" in repr(x.device)
    before = library.freed
    del x
    assert library.freed == before + 1
    assert device_array(np.zeros((0, 7))).numpy().shape == (0, 7)


def test_too_much_for_the_device(monkeypatch: pytest.MonkeyPatch) -> None:
    installed(monkeypatch, FakeLibrary(room=100))
    with pytest.raises(KernelError, match="no memory for 800 bytes"):
        device_array(np.zeros(100))


def test_no_device(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(KernelError, match="finds no device"):
        Driver(FakeLibrary(devices=0))
    monkeypatch.setattr(driver.__wrapped__.__globals__["ctypes"], "CDLL", _missing)
    with pytest.raises(KernelError, match="no NVIDIA driver"):
        driver.__wrapped__()
    with pytest.raises(KernelError, match="refused cuModuleGetFunction: CUDA_ERROR_INVALID_VALUE"):
        Driver(FakeLibrary()).device().module(_program("gravity_torque").text, "nobody")


def _missing(_name: str) -> None:
    raise OSError


def test_on_a_real_device() -> None:
    try:
        found = driver()
    except KernelError as reason:
        pytest.skip(str(reason))
    assert found.count
    q, qd, qdd = rng.uniform(-3, 3, (3, 100_003, 7))
    on = [mf.kernels.device_array(x) for x in (q, qd, qdd)]
    assert np.array_equal(ROBOT.inverse_dynamics(*on).numpy(), ROBOT.inverse_dynamics(q, qd, qdd))
    J = ROBOT.jacobian_body(on[0])
    assert np.array_equal(J.numpy(), ROBOT.jacobian_body(q))
