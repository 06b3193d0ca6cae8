"""`mafsil info`: versions, processor, cache, self-test of the compiled kernels."""

from __future__ import annotations

import os
import platform
import shutil
import sys
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.cli.answer import Answer, Toned
from mafsil.cli.export import checks as export_checks
from mafsil.cli.status_line import Progress
from mafsil.cli.table import details, table
from mafsil.messages import language, say

if TYPE_CHECKING:
    from mafsil.kernels.audit import AuditReport

NEEDED = ("mafsil", "numpy", "scipy", "llvmlite", "msgspec")
OPTIONAL = ("matplotlib",)
ORACLES = ("pin", "mujoco-core", "example-robot-data")
_TOLERANCE = 1e-11
_WORST_ULP = 64.0


def info(export_check: bool = False, build: bool = False) -> Answer:
    """Look at everything mafsil stands on, and compile and check a small robot.

    Args:
        export_check: compile exported C too, with the C compiler of this computer, and run its test vectors.
        build: first compile the loops that know no robot, on all cores, so that no first question waits for them.
    """
    built = _built() if build else []
    packages = {name: _version(name) for name in (*NEEDED, *OPTIONAL, *ORACLES)}
    machine = _machine()
    cache = _cache()
    settings = _settings()
    checks = _checks() + (export_checks() if export_check else [])
    missing = [name for name in NEEDED if packages[name] is None]
    failed = [check["name"] for check in checks if not check["ok"]]
    data = {"packages": packages, "machine": machine, "settings": settings, "cache": cache, "checks": checks}
    data |= {"built": built, "missing": missing, "ok": not missing and not failed}
    lines = [say("cli.info_packages"), *table(("", ""), [(k, v or say("cli.absent")) for k, v in packages.items()])[1:]]
    lines += ["", say("cli.info_machine"), *details(machine)]
    lines += ["", say("cli.info_settings"), *details(settings)]
    lines += ["", say("cli.info_cache")]
    lines += [
        f"  {say(f'cli.cache_{key}')}: {say('cli.cache_memory') if value is None else value}"
        for key, value in cache.items()
    ]
    if built:
        lines += ["", say("cli.info_built"), *(f"  {one['name']}: {one['seconds']:.1f} s" for one in built)]
    lines += [
        "",
        say("cli.info_checks"),
        *(
            Toned(f"  {'ok ' if c['ok'] else '!! '} {c['name']}: {c['detail']}", "good" if c["ok"] else "bad")
            for c in checks
        ),
    ]
    refusal = None
    if missing or failed:
        refusal = say("cli.info_sick", what=", ".join([*missing, *failed]))
    else:
        lines += ["", Toned(say("cli.info_healthy"), "good")]
    return Answer(data, tuple(lines), refusal)


def _built() -> list[dict[str, Any]]:
    """Compiles the loops on all cores, and shows how far it is: it takes minutes."""
    from mafsil.cli.build import Built, build

    with Progress(always=True) as bar:

        def done(one: Built, share: float) -> None:
            if not bar.terminal:
                print(f"  {100 * share:3.0f} %  {one.name}", file=sys.stderr, flush=True)
            bar.update(share)

        bar.enter("info_building")
        return build(done)


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _machine() -> dict[str, Any]:
    details: dict[str, Any] = {
        "python": sys.version.split()[0],
        "system": platform.platform(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
    }
    from mafsil.kernels import target

    host = target.host()
    return details | {"processor": host.cpu, "lanes": host.lanes, "fma": host.fma, "triple": host.triple}


STORED = (".kernel", ".tape", ".sources", ".loop", ".arrays", ".bundle")
"""Endings of what is kept."""


def _cache() -> dict[str, Any]:
    """Where compiled code is kept, how much of each kind, and how large."""
    from mafsil.kernels import cache

    directory = cache.default().directory
    if directory is None:
        return {"place": None}
    sizes: dict[str, list[int]] = {suffix: [] for suffix in STORED}
    for item in directory.iterdir() if directory.is_dir() else ():
        if item.suffix in sizes:
            with suppress(OSError):  # another process may be sweeping
                sizes[item.suffix].append(item.stat().st_size)
    parts = {f"{kind[1:]}s".replace("ss", "s"): len(found) for kind, found in sizes.items()}
    return {
        "place": str(directory),
        "entries": sum(parts.values()),
        **parts,
        "size": f"{sum(map(sum, sizes.values())) / 1e6:.1f} MB",
        "free": f"{_free(directory) / 1e9:.1f} GB",
    }


def _free(directory: Path) -> int:
    """Bytes free on the disk of a directory that may not exist yet."""
    place = next(parent for parent in (directory, *directory.parents) if parent.exists())
    return shutil.disk_usage(place).free


def _settings() -> dict[str, Any]:
    """Where this mafsil comes from, and what surrounds it: what a support person asks first."""
    variables = {name: value for name, value in sorted(os.environ.items()) if name.startswith("MAFSIL_")}
    return {
        "mafsil": str(Path(__file__).parents[1]),
        "interpreter": sys.executable,
        "language": language(),
        "encoding": sys.stdout.encoding,
        "directory": os.getcwd(),
    } | variables


def _checks() -> list[dict[str, Any]]:
    """Each check compiles what it needs; one that fails does not stop the others."""
    checks = [_check("double_pendulum", _double_pendulum), _check("newton_euler_agrees", _newton_euler_agrees)]
    return checks + ([_audit()] if find_spec("mpmath") else [])


def _check(name: str, test: Any) -> dict[str, Any]:
    try:
        error = float(test())
    except Exception as failure:
        return {"name": say(f"cli.check_{name}"), "ok": False, "detail": f"{type(failure).__name__}: {failure}"}
    detail = say("cli.check_error", error=f"{error:.1e}", limit=f"{_TOLERANCE:.0e}")
    return {"name": say(f"cli.check_{name}"), "ok": bool(error <= _TOLERANCE), "detail": detail}


def _audit() -> dict[str, Any]:
    """A freshly compiled kernel, bit for bit and digit for digit."""
    from mafsil.kernels.audit import audit
    from mafsil.mechanics.catalogue import quantity
    from mafsil.robot.trace import signature, trace

    name = say("cli.check_audit")
    try:
        mechanism, row = _pendulum().mechanism, quantity("inverse_dynamics")
        samples = np.random.default_rng(3).uniform(-3, 3, (3, 64, 2))
        found = audit(trace(mechanism, row, None), signature(mechanism, row), list(samples), exact_rows=8)
    except Exception as failure:
        return {"name": name, "ok": False, "detail": f"{type(failure).__name__}: {failure}"}
    return {"name": name, "ok": found.worst_ulp < _WORST_ULP and found.batch_equals_single, "detail": _audited(found)}


def _audited(found: AuditReport) -> str:
    exact, plain = found.worst_ulp, found.worst_ulp_numpy
    return say("cli.check_audit_found", ulp=exact, exact_rows=found.exact_rows, plain=plain, rows=found.rows)


def _double_pendulum() -> float:
    """Compiled gravity torque of two point masses against the formula of the textbook."""
    arm = _pendulum()
    q = np.random.default_rng(1).uniform(-3, 3, (37, 2))
    first, both = np.sin(q[:, 0]), np.sin(q[:, 0] + q[:, 1])
    expected = np.stack([9.81 * (3.0 * first * 0.7 + 2.0 * both * 0.5), 9.81 * 2.0 * both * 0.5], axis=1)
    return float(np.abs(np.asarray(arm.gravity_torque(q)) - expected).max() / (9.81 * 3.1))


def _newton_euler_agrees() -> float:
    """M qdd + c + g against inverse dynamics, single calls against a batch."""
    arm = _pendulum()
    rng = np.random.default_rng(2)
    q, qd, qdd = rng.uniform(-3, 3, (3, 37, 2))
    M = np.asarray(arm.mass_matrix(q))
    sum_: Floats = (M @ qdd[..., None])[..., 0] + arm.velocity_torque(q, qd) + arm.gravity_torque(q)
    batch = np.asarray(arm.inverse_dynamics(q, qd, qdd))
    single = np.stack([arm.inverse_dynamics(*row) for row in zip(q, qd, qdd, strict=True)])
    return float(max(np.abs(sum_ - batch).max(), np.abs(single - batch).max()) / np.abs(batch).max())


def _pendulum() -> Any:
    """Two hanging point masses, 1 kg at 0.7 m and 2 kg 0.5 m further, turning about y."""
    from mafsil.model import Inertial, Joint, JointKind, Link, Mechanism
    from mafsil.robot import Robot

    def hung(length: float) -> Floats:
        T = np.eye(4)
        T[2, 3] = -length
        return T

    links = [
        Link("base"),
        Link("upper", Inertial(1.0, np.array([0.0, 0.0, -0.7]))),
        Link("lower", Inertial(2.0, np.array([0.0, 0.0, -0.5]))),
    ]
    y = np.array([0.0, 1.0, 0.0])
    joints = [
        Joint("shoulder", JointKind.REVOLUTE, "base", "upper", axis=y),
        Joint("elbow", JointKind.REVOLUTE, "upper", "lower", T_pj=hung(0.7), axis=y),
    ]
    return Robot(Mechanism.assemble("double pendulum", links, joints))
