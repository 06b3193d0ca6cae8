"""Pictures of a grasp: contacts and cones on the body, what is not resisted or still free, and the hull of wrenches.

The motions that a plane grasp leaves, as a moving picture: the body swings along each, never into a finger.

Proposed grasps on their body: the best ones in small pictures, one view for all.
"""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError
from mafsil.figures.space import picture_file
from mafsil.grasp import Closure, Contact, Grasp, GraspedBody, GraspPlan
from mafsil.grasp.displacement import displaced_pose, free_twists
from mafsil.grasp.quality import hull_facets
from mafsil.messages import say
from mafsil.messages.visible import visible

_INK, _BODY, _CONE, _NORMAL = "#39424a", "#e8ecef", "#2f6fd0", "#1d4488"
_YES, _NO, _MARGINAL = "#2e8b57", "#d33f3a", "#d9902a"
MOST_TRIANGLES = 6000
_LIGHT = np.array([0.4, -0.5, 0.77])
_COLOURS = {"yes": _YES, "no": _NO, "marginal": _MARGINAL}


def save_grasp(
    grasp: Grasp,
    path: str | PathLike[str],
    *,
    closure: Closure | None = None,
    outline: Floats | None = None,
    body: GraspedBody | None = None,
) -> None:
    """Draw a grasp into a file.

    Args:
        grasp: in the plane or in space.
        path: .png, .svg or .pdf.
        closure: verdict to show; asked for if None.
        outline: (k, 2) corners of a plane body.
        body: of triangles, in space.
    """
    path = picture_file(path)
    import matplotlib

    found = grasp.closure() if closure is None else closure
    with matplotlib.rc_context({"svg.hashsalt": "mafsil", "font.size": 9, "text.color": _INK}):
        figure = draw_grasp(grasp, found, outline, body)
        undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(path.suffix.lower(), {})
        figure.savefig(path, dpi=150, bbox_inches="tight", pad_inches=0.08, metadata=undated)


def draw_grasp(grasp: Grasp, closure: Closure, outline: Floats | None = None, body: GraspedBody | None = None) -> Any:
    """A matplotlib figure: the contacts with their cones; in the plane also the hull of the wrenches.

    Args:
        grasp: in the plane or in space.
        closure: its verdict.
        outline: (k, 2) corners of a plane body.
        body: of triangles, in space.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.5, 4.8) if grasp.dimension == 2 else (6.5, 6.0))
    FigureCanvasAgg(figure)
    if grasp.dimension == 2:
        left: Any = figure.add_axes((0.04, 0.05, 0.47, 0.85))
        _plane(left, grasp, closure, outline)
        right: Any = figure.add_axes((0.53, 0.05, 0.4, 0.85), projection="3d")
        _hull(right, grasp.matrix(), closure)
    else:
        axes: Any = figure.add_axes((0.0, 0.0, 1.0, 0.93), projection="3d")
        if body is not None:
            draw_body(axes, body)
        draw_contacts(axes, grasp)
        frame_space(axes, np.array([c.point for c in grasp.contacts]) if body is None else body.corners.reshape(-1, 3))
    verdict = say(f"grasp.verdict_{closure.verdict}")
    sentence = f"{grasp.name}: {verdict}" if grasp.name else verdict
    flat = all(c.curvature_given for c in grasp.contacts)
    if flat and not closure.force_closure and grasp.second_order().immobile:
        sentence += "; " + say("grasp.second_order_short")
    figure.suptitle(visible(sentence), color=_COLOURS[closure.verdict], fontsize=11)
    return figure


def _size(grasp: Grasp, outline: Floats | None = None) -> float:
    points = np.array([c.point for c in grasp.contacts])
    if outline is not None:
        points = np.vstack([points, outline])
    return float(np.ptp(points, axis=0).max()) or 1.0


def _plane(axes: Any, grasp: Grasp, closure: Closure, outline: Floats | None) -> None:
    size = _size(grasp, outline)
    if outline is not None:
        axes.fill(*outline.T, facecolor=_BODY, edgecolor=_INK, linewidth=1.2)
    for k, contact in enumerate(grasp.contacts):
        reach = 0.28 * size
        if contact.mu:
            edges = np.array([contact.normal + s * contact.mu * contact.tangents[0] for s in (-1, 1)])
            edges = edges / np.linalg.norm(edges, axis=1, keepdims=True) * reach
            axes.fill(*np.array([contact.point, *(contact.point + edges)]).T, color=_CONE, alpha=0.25, linewidth=0)
            for edge in edges:
                axes.plot(*np.array([contact.point, contact.point + edge]).T, color=_CONE, linewidth=0.9)
        tail = contact.point - 0.16 * size * contact.normal
        axes.annotate("", contact.point, tail, arrowprops={"arrowstyle": "-|>", "color": _NORMAL, "lw": 1.6})
        axes.plot(*contact.point, "o", color=_NORMAL, markersize=4)
        axes.text(*(tail - 0.05 * size * contact.normal), str(k), ha="center", va="center")
    for twist in _shown_motions(grasp, closure):
        _free_motion(axes, grasp, twist, size, outline)
    if closure.certificate is not None:
        _draw_unresisted_wrench(axes, closure.certificate, size)
    axes.plot(0, 0, "+", color=_INK)
    axes.set_aspect("equal")
    axes.margins(0.12)
    axes.axis("off")


def _shown_motions(grasp: Grasp, closure: Closure) -> list[Floats]:
    """Friction may stop what the normals let pass: motions are shown only where forces do not close."""
    return [] if closure.force_closure else [twist for twist, _ in free_twists(grasp)][:3]


def _free_motion(axes: Any, grasp: Grasp, twist: Floats, size: float, outline: Floats | None) -> None:
    """The body (or its contact points) a little later along a motion that leaves every finger outside."""
    corners = np.array([c.point for c in grasp.contacts]) if outline is None else outline
    for step in (0.06 * size, 0.03 * size):
        pose = displaced_pose(grasp, twist, step)
        if pose is not None:
            axes.fill(
                *(corners @ pose[:2, :2].T + pose[:2, 2]).T,
                facecolor="none",
                edgecolor=_YES,
                linewidth=0.9,
                linestyle="--",
            )


def _draw_unresisted_wrench(axes: Any, wrench: Floats, size: float) -> None:
    """The external wrench that nothing resists: an arrow for the force, a turning arrow for the moment."""
    moment, force = float(wrench[0]), wrench[1:]
    if np.linalg.norm(force) > 1e-9:
        tip = 0.45 * size * force / np.linalg.norm(force)
        axes.annotate("", tip, (0, 0), arrowprops={"arrowstyle": "-|>", "color": _NO, "lw": 2.2})
    if abs(moment) > 1e-9:
        angles = np.linspace(0.2, 5.0, 40)[:: 1 if moment > 0 else -1]
        circle = 0.16 * size * np.column_stack([np.cos(angles), np.sin(angles)])
        axes.plot(*circle[:-2].T, color=_NO, linewidth=2.0)
        axes.annotate("", circle[-1], circle[-3], arrowprops={"arrowstyle": "-|>", "color": _NO, "lw": 2.0})


def _hull(axes: Any, A: Floats, closure: Closure) -> None:
    """Wrenches (f_x, f_y, m) of unit push, their hull, and the origin with its ball."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    points = A[[1, 2, 0]].T
    axes.scatter(*points.T, color=_CONE, s=18)
    if hull_facets(A) is not None:
        from scipy.spatial import ConvexHull

        faces = [points[simplex] for simplex in ConvexHull(points).simplices]
        axes.add_collection3d(Poly3DCollection(faces, facecolor=_CONE, edgecolor=_NORMAL, alpha=0.12, linewidth=0.6))
    else:
        axes.plot(*np.vstack([points, points[:1]]).T, color=_NORMAL, linewidth=0.8)
    axes.scatter(0, 0, 0, color=_COLOURS[closure.verdict], s=40)
    if closure.margin > 0:
        u, v = np.mgrid[0 : 2 * np.pi : 24j, 0 : np.pi : 12j]
        ball = closure.margin * np.array([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
        axes.plot_wireframe(*ball, color=_YES, linewidth=0.4)
    flat = np.ptp(points, axis=0) < 0.1 * np.ptp(points, axis=0).max()
    for setter, is_flat, middle in zip(
        (axes.set_xlim, axes.set_ylim, axes.set_zlim), flat, points.mean(axis=0), strict=True
    ):
        if is_flat:  # or its scale would be a heap of numbers
            half = 0.25 * float(np.ptp(points, axis=0).max())
            setter(middle - half, middle + half)
    axes.set_aspect("equal")
    axes.set_xlabel("f_x")
    axes.set_ylabel("f_y")
    axes.set_zlabel("m")


def draw_body(axes: Any, body: GraspedBody) -> None:
    """Triangles, translucent and shaded; the largest of them if there are many thousands.

    Args:
        axes: three-dimensional.
        body: to draw.
    """
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    largest = np.argsort(-body.areas)[:MOST_TRIANGLES]
    bright = 0.62 + 0.33 * np.clip(body.normals[largest] @ -_LIGHT, -1, 1)
    colours = np.column_stack([0.92 * bright, 0.96 * bright, bright, np.full(len(bright), 0.45)])
    axes.add_collection3d(Poly3DCollection(list(body.corners[largest]), facecolors=colours, linewidth=0))


def draw_contacts(axes: Any, grasp: Grasp, labels: bool = True, scale: float | None = None) -> None:
    """Contacts in space with their cones.

    Args:
        axes: three-dimensional.
        grasp: in space.
        labels: write the numbers of the contacts.
        scale: length of the cones and normals [m]; a share of the grasp's size if None.
    """
    size = _size(grasp) if scale is None else 4 * scale
    for k, contact in enumerate(grasp.contacts):
        _cone(axes, contact, 0.25 * size)
        tail = contact.point - 0.2 * size * contact.normal
        axes.plot(*np.array([tail, contact.point]).T, color=_NORMAL, linewidth=1.8)
        axes.scatter(*contact.point, color=_NORMAL, s=16)
        if labels:
            axes.text(*tail, str(k))


def frame_space(axes: Any, points: Floats) -> None:
    """Equal axes around points.

    Args:
        axes: three-dimensional.
        points: (k, 3).
    """
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    half = 0.55 * (float(np.ptp(points, axis=0).max()) or 1.0)
    axes.set_xlim(middle[0] - half, middle[0] + half)
    axes.set_ylim(middle[1] - half, middle[1] + half)
    axes.set_zlim(middle[2] - half, middle[2] + half)
    axes.set_box_aspect((1, 1, 1), zoom=1.15)
    axes.set_xlabel("x")
    axes.set_ylabel("y")
    axes.set_zlabel("z")


def _cone(axes: Any, contact: Contact, height: float) -> None:
    if not contact.mu:
        return
    angle, along = np.meshgrid(np.linspace(0, 2 * np.pi, 33), [0.0, height])
    a, b = contact.tangents
    surface = [
        contact.point[i] + along * (contact.normal[i] + contact.mu * (np.cos(angle) * a[i] + np.sin(angle) * b[i]))
        for i in range(3)
    ]
    axes.plot_surface(*surface, color=_CONE, alpha=0.3, linewidth=0)


FRAMES = 24
"""Of one motion."""
REACH = 0.08
"""How far the body is moved, as a share of its size."""
_MOVED = "#2e8b57"


def save_free_motions(grasp: Grasp, path: str | PathLike[str], *, outline: Floats | None = None) -> None:
    """Write a moving picture.

    Args:
        grasp: in the plane, with some motion that neither its normals nor curvature forbid.
        path: .gif.
        outline: (k, 2) corners of the body; the contact points if None.

    Raises:
        InputError: a grasp in space, or one that leaves no motion that can be shown.
    """
    path = picture_file(path, (".gif",))
    if grasp.dimension != 2:
        raise InputError("grasp.motion_in_plane")
    paths = free_twists(grasp)
    if not paths:
        raise InputError("grasp.motion_blocked", finding=grasp.second_order().explain())
    from matplotlib.animation import FuncAnimation, PillowWriter

    corners = np.array([c.point for c in grasp.contacts]) if outline is None else outline
    figure = draw_grasp(grasp, grasp.closure(margins=False), outline)
    displaced_pose: Any = figure.axes[0].fill(*corners.T, facecolor="none", edgecolor=_MOVED, linewidth=2.0)[0]
    places = [_place(grasp, corners, y, t) for y, both in paths for t in _swing(both)]

    def show(frame: int) -> tuple[Any, ...]:
        displaced_pose.set_xy(places[frame])
        return (displaced_pose,)

    FuncAnimation(figure, show, frames=len(places), blit=False).save(path, writer=PillowWriter(fps=16), dpi=80)


def _swing(both_ways: bool) -> Floats:
    """Shares of the reach over one motion: to and fro; a one-way motion never goes behind its start."""
    t = np.sin(2 * np.pi * np.arange(FRAMES) / FRAMES)
    return t if both_ways else np.abs(t)


def _place(grasp: Grasp, corners: Floats, twist: Floats, share: float) -> Floats:
    """Corners moved along a plane twist by a share of the reach; at rest where a finger would be inside."""
    size = float(np.ptp(corners, axis=0).max()) or 1.0
    pose = displaced_pose(grasp, np.sign(share) * twist, abs(share) * REACH * size)
    return corners if pose is None else corners @ pose[:2, :2].T + pose[:2, 2]


SHOWN = 6


def save_plan(plan: GraspPlan, path: str | PathLike[str]) -> None:
    """Draw the best proposals into a file.

    Args:
        plan: with at least one grasp.
        path: .png, .svg or .pdf.
    """
    path = picture_file(path)
    import matplotlib

    with matplotlib.rc_context({"svg.hashsalt": "mafsil", "font.size": 8}):
        figure = draw_plan(plan)
        undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(path.suffix.lower(), {})
        figure.savefig(path, dpi=130, metadata=undated)


def draw_plan(plan: GraspPlan) -> Any:
    """A matplotlib figure with the best proposals.

    Args:
        plan: with at least one grasp.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    shown = plan.grasps[:SHOWN]
    columns = min(3, len(shown))
    rows = -(-len(shown) // columns)
    figure = Figure(figsize=(3.4 * columns, 3.4 * rows + 0.3))
    FigureCanvasAgg(figure)
    for k, proposal in enumerate(shown):
        axes: Any = figure.add_subplot(rows, columns, k + 1, projection="3d")
        draw_body(axes, plan.body)
        draw_contacts(axes, proposal.grasp, labels=False, scale=0.2 * plan.body.size)
        frame_space(axes, np.asarray(plan.body.corners).reshape(-1, 3))
        axes.set_axis_off()
        axes.set_title(visible(f"{k + 1}: {say('grasp.epsilon_head')} {proposal.epsilon:.3g}"))
    figure.tight_layout()
    return figure
