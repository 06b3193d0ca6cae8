// Drawing without WebGL: every body is the hull of its projected corners, the far ones first.

const MOST_CORNERS = 90;
const GRID = 2; // times the scene's size that the floor reaches to each side

export class FlatRenderer {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    if (!this.context) throw new Error("no 2D canvas");
  }

  /** Corners of a mesh, of many only some. vertices: position and normal, six numbers each. */
  mesh({ vertices }) {
    const count = vertices.length / 6, step = Math.max(1, Math.floor(count / MOST_CORNERS)), corners = [];
    for (let i = 0; i < count; i += step) corners.push([vertices[6 * i], vertices[6 * i + 1], vertices[6 * i + 2]]);
    return { corners };
  }

  /** One picture; items and view as for `Renderer.render`, the camera in view.camera. Ghosts lie behind the others. */
  render(items, view) {
    const { camera } = view;
    const { canvas, context } = this, ratio = Math.min(window.devicePixelRatio || 1, 2);
    const { width, height } = this.shown ?? { width: canvas.clientWidth, height: canvas.clientHeight };
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.lineJoin = "round";
    if (view.ground) this.grid(view, width, height);
    const drawn = items.filter((item) => !item.floor).map((item) => outline(item, camera, width, height));
    drawn.sort((a, b) => Number(a.over) - Number(b.over) || Number(b.ghost) - Number(a.ghost) || b.depth - a.depth);
    for (const { points, colour } of drawn) {
      context.beginPath();
      points.forEach(({ x, y }, k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
      context.closePath();
      const [r, g, b] = colour.map((part) => Math.round(255 * part));
      context.fillStyle = `rgb(${r} ${g} ${b} / ${colour[3]})`;
      context.strokeStyle = `rgb(${r * 0.55} ${g * 0.55} ${b * 0.55} / ${colour[3]})`;
      context.fill();
      context.stroke();
    }
  }

  /** Lines of the floor about the scene, in front of the eye. */
  grid({ camera, ground, pitch, lines, centre, size, eye, target }, width, height) {
    const { context } = this, z = ground.model[14], reach = Math.ceil((GRID * size) / pitch);
    const near = 0.05 * size, ahead = target.map((x, k) => x - eye[k]), long = Math.hypot(...ahead);
    const depth = (p) => p.reduce((sum, x, k) => sum + (x - eye[k]) * ahead[k], 0) / long;
    const [x0, y0] = centre.slice(0, 2).map((x) => Math.round(x / pitch) * pitch);
    context.strokeStyle = `rgb(${lines.slice(0, 3).map((part) => Math.round(255 * part)).join(" ")})`;
    context.lineWidth = 1;
    context.beginPath();
    for (let k = -reach; k <= reach; k++) for (const across of [false, true]) {
      const ends = [-reach, reach].map((s) => (across ? [x0 + s * pitch, y0 + k * pitch, z] : [x0 + k * pitch, y0 + s * pitch, z]));
      const [a, b] = ends.map(depth);
      if (Math.max(a, b) < near) continue;
      const cut = (from, to, d, e) => (d >= near ? from : from.map((x, i) => x + ((to[i] - x) * (near - d)) / (e - d)));
      const [p, q] = [cut(ends[0], ends[1], a, b), cut(ends[1], ends[0], b, a)].map((point) => camera.project(point, width, height));
      context.moveTo(p.x, p.y);
      context.lineTo(q.x, q.y);
    }
    context.stroke();
  }
}

function outline({ mesh, model: m, colour, ghost = false, over = false }, camera, width, height) {
  const points = camera.projected(mesh.corners.map(([x, y, z]) => [0, 1, 2].map((r) => m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r])), width, height);
  return { points: hull(points), colour, ghost, over, depth: points.reduce((sum, point) => sum + point.depth, 0) / points.length };
}

/** Convex hull of points in the plane. Reference: Andrew, Another efficient algorithm for convex hulls, 1979. */
function hull(points) {
  const sorted = [...points].sort((a, b) => a.x - b.x || a.y - b.y);
  const half = (list) => {
    const chain = [];
    for (const p of list) {
      while (chain.length > 1 && turn(chain.at(-2), chain.at(-1), p) <= 0) chain.pop();
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

const turn = (a, b, c) => (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
