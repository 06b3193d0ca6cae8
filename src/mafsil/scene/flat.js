// Drawing without WebGL: every body is the hull of its projected corners, the far ones first.

const MOST_CORNERS = 90;

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

  /** One picture; items as for `Renderer.render`, the camera in view.camera. */
  render(items, { camera }) {
    const { canvas, context } = this, ratio = Math.min(window.devicePixelRatio || 1, 2);
    const { width, height } = this.shown ?? { width: canvas.clientWidth, height: canvas.clientHeight };
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.lineJoin = "round";
    const drawn = items.filter((item) => !item.floor).map((item) => outline(item, camera, width, height));
    drawn.sort((a, b) => b.depth - a.depth);
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
}

function outline({ mesh, model: m, colour }, camera, width, height) {
  const points = mesh.corners.map(([x, y, z]) => camera.project([0, 1, 2].map((r) => m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r]), width, height));
  return { points: hull(points), colour, depth: points.reduce((sum, point) => sum + point.depth, 0) / points.length };
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
