"""Real kernels for the reliability harness, with references; described by module-level functions, so they pickle."""

from __future__ import annotations

from functools import partial

import numpy as np

from mafsil.kernels import Kernel, Port, Signature, compile, small_batch

small_batch.SINGLY = 0  # so that all parts of the code are made, as of kernels that are asked for thousands of rows


def lengths(links: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(0.2, 1.0, links)


def planar_arm(links: int, seed: int):
    """Tip pose (4, 4), Jacobian of the tip (2, n) and reach of a planar chain."""
    import mafsil.expression as ex

    q, shift = ex.symbol("q", links), ex.symbol("shift")
    angle, x, y = ex.Expression(0), shift, ex.Expression(0)
    for joint, length in enumerate(lengths(links, seed)):
        angle += q[joint]
        x += length * ex.cos(angle)
        y += length * ex.sin(angle)
    c, s = ex.cos(angle), ex.sin(angle)
    pose = ex.vertcat(c, -s, 0, x, s, c, 0, y, 0, 0, 1, 0, 0, 0, 0, 1)
    jacobian = ex.jacobian(ex.vertcat(x, y), q)
    reach = ex.sqrt(x * x + y * y)
    rows = ex.reshape(jacobian.T, 2 * links, 1)
    return ex.Function("planar_arm", [q, shift], [pose, rows, reach], ["q", "shift"], ["T", "J", "reach"])


def kernel(links: int = 3, seed: int = 0, features: str | None = None, version: str = "") -> Kernel:
    from mafsil.kernels import target

    return compile(
        Signature(
            "planar_arm",
            (Port("q", (links,)), Port("shift")),
            (Port("T", (4, 4)), Port("J", (2, links)), Port("reach")),
        ),
        partial(planar_arm, links, seed),
        key=f"planar arm {links} {seed}",
        doc="Tip pose, Jacobian and reach of a planar arm.",
        fingerprints=(version,),
        recipe=(kernel, (links, seed, features, version)),
        target=None if features is None else target.host(features),
    )


def keys(k: Kernel) -> tuple[str, list[str]]:
    """Keys under which a kernel is cached: of its tape, and of the parts of its code; all are made."""
    from mafsil.kernels import image, warm
    from mafsil.kernels.cache import Store

    warm([k])
    order = k.order(Store(None))
    return order.key, [order.object_key(part, k.image.hash) for part in image.FROM_PYTHON]


def reference(links: int, seed: int, q: np.ndarray, shift: np.ndarray | float):
    """The same three quantities, row by row in NumPy."""
    size = lengths(links, seed)
    angles = np.cumsum(q, axis=-1)
    x = shift + (size * np.cos(angles)).sum(axis=-1)
    y = (size * np.sin(angles)).sum(axis=-1)
    pose = np.zeros((*q.shape[:-1], 4, 4))
    c, s = np.cos(angles[..., -1]), np.sin(angles[..., -1])
    pose[..., 0, 0], pose[..., 0, 1], pose[..., 0, 3] = c, -s, x
    pose[..., 1, 0], pose[..., 1, 1], pose[..., 1, 3] = s, c, y
    pose[..., 2, 2] = pose[..., 3, 3] = 1.0
    dx = -np.cumsum((size * np.sin(angles))[..., ::-1], axis=-1)[..., ::-1]
    dy = np.cumsum((size * np.cos(angles))[..., ::-1], axis=-1)[..., ::-1]
    return pose, np.stack([dx, dy], axis=-2), np.hypot(x, y)


def states(links: int, rows: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    return random.uniform(-3.0, 3.0, (rows, links)), random.uniform(-1.0, 1.0, rows)


def wrong(links: int, seed: int, k: Kernel, rows: int = 64) -> bool:
    """Whether a kernel's answers are not those of the reference."""
    q, shift = states(links, rows)
    return not all(
        np.allclose(a, b, rtol=1e-12, atol=1e-13)
        for a, b in zip(k(q, shift), reference(links, seed, q, shift), strict=True)
    )


def bits(answer: object) -> bytes:
    """All bits of an answer."""
    parts = answer if isinstance(answer, tuple) else (answer,)
    return b"".join(np.ascontiguousarray(part).tobytes() for part in parts)


def answer(k: Kernel, args: tuple[object, ...]) -> bytes:
    """Bits of a call, for worker processes."""
    return bits(k(*args))
