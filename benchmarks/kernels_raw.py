"""How fast is a compiled kernel, called without any Python around it? Inverse dynamics of a seven-joint arm.

Compares nanoseconds per evaluation on one core with Pinocchio's C++ (`rneaInParallel`, one thread) and with its Python
call, in the same run. The expression is written here, on its own: recursive Newton-Euler with 3-vectors in link frames.

`python benchmarks/kernels_raw.py [--features -avx512f] [--lanes 4]`
"""

from __future__ import annotations

import argparse
import ctypes
import platform
import time
from collections.abc import Callable

import numpy as np

import mafsil.expression as ex
from mafsil.kernels import lower, reduce, tape, target
from mafsil.kernels.layout import Port, Signature

JOINTS = 7
# A Panda-like arm in modified Denavit-Hartenberg parameters: a [m], d [m], alpha / (pi/2); round masses and inertias.
CHAIN = [
    (0.0, 0.333, 0), (0.0, 0.0, -1), (0.0, 0.316, 1), (0.0825, 0.0, 1), (-0.0825, 0.384, -1), (0.0, 0.0, 1),
    (0.088, 0.0, 1),
]  # fmt: skip
MASS = [4.97, 0.65, 3.23, 3.59, 1.23, 1.67, 0.74]
CENTRE = [
    (0.004, 0.002, -0.175), (-0.003, -0.028, 0.003), (0.027, 0.039, -0.066), (-0.053, 0.104, 0.027),
    (-0.012, 0.041, -0.038), (0.060, -0.014, -0.011), (0.010, -0.004, 0.062),
]  # fmt: skip
INERTIA = [
    (0.703, 0.707, 0.0091, -0.0001, 0.0068, 0.0192), (0.0080, 0.0281, 0.0259, -0.0039, 0.0103, 0.0008),
    (0.0372, 0.0361, 0.0108, -0.0047, -0.0114, -0.0128), (0.0259, 0.0195, 0.0283, 0.0078, -0.0013, 0.0087),
    (0.0355, 0.0294, 0.0086, -0.0021, -0.0040, 0.0003), (0.0020, 0.0043, 0.0054, 0.0001, -0.0012, -0.0003),
    (0.0125, 0.0100, 0.0048, -0.0004, -0.0012, -0.0007),
]  # fmt: skip
GRAVITY = 9.81


def expression() -> ex.Function:
    """Inverse dynamics tau(q, qd, qdd) as an SX function of three columns."""
    q, qd, qdd = (ex.symbol(name, JOINTS) for name in ("q", "qd", "qdd"))
    z = ex.Expression([0, 0, 1])
    omega, alpha, acceleration = ex.zeros(3), ex.zeros(3), ex.Expression([0, 0, GRAVITY])
    poses: list[tuple[ex.Expression, ex.Expression]] = []
    forces: list[tuple[ex.Expression, ex.Expression]] = []
    for i in range(JOINTS):
        R, p = _pose(i, q[i])
        acceleration = R.T @ (acceleration + ex.cross(alpha, p) + ex.cross(omega, ex.cross(omega, p)))
        omega, alpha = R.T @ omega, R.T @ alpha
        alpha = alpha + ex.cross(omega, z * qd[i]) + z * qdd[i]
        omega = omega + z * qd[i]
        h, m = ex.Expression(MASS[i] * np.array(CENTRE[i])), MASS[i]
        I = _inertia_at_joint(i)
        force = m * acceleration + ex.cross(alpha, h) + ex.cross(omega, ex.cross(omega, h))
        moment = I @ alpha + ex.cross(omega, I @ omega) + ex.cross(h, acceleration)
        poses.append((R, p))
        forces.append((force, moment))
    tau = ex.zeros(JOINTS)
    f, n = ex.zeros(3), ex.zeros(3)
    for i in reversed(range(JOINTS)):
        if i + 1 < JOINTS:
            R, p = poses[i + 1]
            f = R @ f
            n = R @ n + ex.cross(p, f)
        f, n = f + forces[i][0], n + forces[i][1]
        tau[i] = n[2]
    return ex.Function("inverse_dynamics", [q, qd, qdd], ex.cse([tau]))


def _pose(i: int, angle: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
    """Pose of joint frame i in frame i - 1; the right angles of the chain are exact."""
    a, d, turn = CHAIN[i]
    c, s, ca_, sa = ex.cos(angle), ex.sin(angle), float(turn == 0), float(turn)
    R = ex.vertcat(ex.horzcat(c, -s, 0), ex.horzcat(s * ca_, c * ca_, -sa), ex.horzcat(s * sa, c * sa, ca_))
    return R, ex.Expression([a, -sa * d, ca_ * d])


def _inertia_at_joint(i: int) -> ex.Expression:
    c = np.array(CENTRE[i])
    return ex.Expression(_inertia(i) + MASS[i] * (c @ c * np.eye(3) - np.outer(c, c)))


def _inertia(i: int) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = INERTIA[i]
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def pinocchio_model() -> object:
    """The same arm for Pinocchio."""
    import pinocchio as pin

    model, parent = pin.Model(), 0
    for i, (a, d, turn) in enumerate(CHAIN):
        c, s = float(turn == 0), float(turn)
        R = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
        place = pin.SE3(R, np.array([a, -s * d, c * d]))
        parent = model.addJoint(parent, pin.JointModelRZ(), place, f"joint{i}")
        model.appendBodyToJoint(parent, pin.Inertia(MASS[i], np.array(CENTRE[i]), _inertia(i)), pin.SE3.Identity())
    model.gravity.linear = np.array([0, 0, -GRAVITY])
    return model


def best(run: Callable[[], object], repeats: int = 15) -> float:
    """Shortest of several runs [s]."""
    times: list[float] = []
    for _ in range(repeats):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return min(times)


def batch_runner(address: int, arrays: list[np.ndarray], result: np.ndarray) -> Callable[[], object]:
    """A call of the batch entry on C-contiguous arrays."""
    entry = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4)(address)
    every = [*arrays, result]
    args = (ctypes.c_void_p * len(every))(*(x.ctypes.data for x in every))
    dims = (ctypes.c_ssize_t * 2)(len(result), JOINTS)
    steps = (ctypes.c_ssize_t * (2 * len(every)))(*(x.strides[0] for x in every), *([8] * len(every)))
    return lambda: (entry(args, dims, steps, None), args, dims, steps)


def single_time(address: int, arrays: list[np.ndarray], result: np.ndarray) -> float:
    """Seconds of one single evaluation, by a compiled loop over it."""
    ports = [x.ctypes.data for x in (*arrays, result)]
    count = 20000
    pointers = ", ".join(f"ptr inttoptr (i64 {p} to ptr)" for p in ports)
    kinds = ", ".join(["ptr"] * len(ports))
    ir = f"""define void @repeat() {{
entry:
  br label %next
next:
  %i = phi i64 [ 0, %entry ], [ %j, %next ]
  call void ({kinds}) inttoptr (i64 {address} to ptr)({pointers})
  %j = add i64 %i, 1
  %more = icmp ult i64 %j, {count}
  br i1 %more, label %next, label %done
done:
  ret void
}}"""
    code = target.load(target.compile(ir, target.host()), ("repeat",))
    run = ctypes.CFUNCTYPE(None)(code.addresses["repeat"])
    return best(run) / count


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--features", default="")
    parser.add_argument("--lanes", type=int)
    parser.add_argument("--rows", type=int, default=4096)
    options = parser.parse_args()
    machine = target.host(options.features, options.lanes)
    signature = Signature(
        "inverse_dynamics", tuple(Port(n, (JOINTS,)) for n in ("q", "qd", "qdd")), (Port("tau", (JOINTS,)),)
    )
    clock = time.perf_counter
    start = clock()
    function = expression()
    traced = clock()
    raw = tape.read(function)
    reduced = reduce.reduce(raw)
    small = clock()
    ir = lower.lower(reduced, signature, machine)
    lowered = clock()
    object_code = target.compile(ir, machine)
    compiled = clock()
    code = target.load(object_code)
    loaded = clock()
    print(f"{platform.machine()} {machine.cpu}, {machine.lanes} lanes, fma {machine.fma}")
    print(f"operations: {raw.operations} traced, {reduced.operations} after reduction {reduced.counts()}")
    print(
        f"trace {traced - start:.3f} s, read + reduce {small - traced:.3f} s, lower {lowered - small:.3f} s, "
        f"compile {compiled - lowered:.3f} s, load {loaded - compiled:.4f} s, object {len(object_code)} B"
    )
    rng = np.random.default_rng(0)
    arrays = [rng.uniform(-2.5, 2.5, (options.rows, JOINTS)) for _ in range(3)]
    result = np.full((options.rows, JOINTS), np.nan)
    run = batch_runner(code.batch, arrays, result)
    run()
    checked = list(zip(*(x[:100] for x in arrays), strict=True))
    reference = np.array([np.array(function(*row)).ravel() for row in checked])
    error = np.abs(result[:100] - reference).max() / np.abs(reference).max()
    print(f"worst difference from the expression in plain Python: {error:.1e} of the largest torque")
    batch = best(run, 200) / options.rows
    single = single_time(code.single, arrays, result[:1].copy())
    print(f"batch {batch * 1e9:.1f} ns per evaluation and core; single {single * 1e9:.0f} ns")
    _against_pinocchio(arrays, reference, batch, single)


def _against_pinocchio(arrays: list[np.ndarray], reference: np.ndarray, batch: float, single: float) -> None:
    import pinocchio as pin

    model = pinocchio_model()
    data = model.createData()
    q, v, a = arrays
    own = np.array([pin.rnea(model, data, *rows) for rows in zip(q[:100], v[:100], a[:100], strict=True)])
    print(f"worst difference from Pinocchio: {np.abs(own - reference).max() / np.abs(reference).max():.1e}")
    rows = list(zip(q[:1000], v[:1000], a[:1000], strict=True))
    call = best(lambda: [pin.rnea(model, data, *row) for row in rows]) / len(rows)
    ratios = f"{call / batch:.0f} x batch, {call / single:.1f} x single"
    print(f"Pinocchio {pin.__version__}: Python call {call * 1e9:.0f} ns ({ratios})")
    try:
        pool = pin.ModelPool(model, 1)
        columns = [np.asfortranarray(x.T) for x in arrays]
        result = np.zeros_like(columns[0], order="F")
        core = best(lambda: pin.rneaInParallel(1, pool, *columns, result), 50) / len(q)
        print(f"Pinocchio C++ rneaInParallel, one thread: {core * 1e9:.0f} ns ({core / batch:.1f} x batch)")
    except (AttributeError, TypeError) as error:
        print(f"rneaInParallel is not in this wheel ({error})")


if __name__ == "__main__":
    main()
