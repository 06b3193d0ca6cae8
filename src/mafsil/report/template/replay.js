// The robot's motion in 3D: poses of links over time, tip path, target frames, a camera that orbits.
const unpack = text => new Float32Array(Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer);
// More targets than this are drawn as thin sticks, three meshes in all, however many there are.
const FEW_TARGETS = 12;
const AXES = [[0.83, 0.24, 0.22, 1], [0.25, 0.62, 0.32, 1], [0.22, 0.44, 0.84, 1]];

class Replay {
  constructor(canvas, scene) {
    this.canvas = canvas;
    this.scene = scene;
    this.renderer = new Renderer(canvas);
    this.poses = unpack(scene.poses);
    this.tips = unpack(scene.tips);
    this.reference = unpack(scene.reference);
    this.showPath = this.showFrames = true;
    this.size = scene.size;
    this.build();
    this.listen();
    this.home();
  }
  build() {
    const meshes = new Map(), s = this.size;
    const mesh = (kind, size) => {
      const key = kind + size.join();
      if (!meshes.has(key)) meshes.set(key, this.renderer.mesh(Shapes.of(kind, size)));
      return meshes.get(key);
    };
    const surfaces = this.scene.surfaces.map(surface => this.renderer.mesh(Shapes.surface(surface)));
    this.parts = [];
    this.scene.bodies.forEach((body, link) => body.shapes.forEach(shape =>
      this.parts.push({ link, mesh: shape.kind === "surface" ? surfaces[shape.surface] : mesh(shape.kind, shape.size), local: Matrix.pose(...shape.pose), colour: shape.colour })));
    this.shaft = this.renderer.mesh(Shapes.cylinder(s * 0.0042, s * 0.085));
    this.head = this.renderer.mesh(Shapes.cone(s * 0.0105, s * 0.03));
    this.ball = this.renderer.mesh(Shapes.of("sphere", [s * 0.0085]));
    const places = this.scene.targets.map(target => Matrix.pose(...target.pose));
    this.few = places.length <= FEW_TARGETS ? places : [];
    this.many = places.length <= FEW_TARGETS ? [] : [0, 1, 2].map(axis => ({ colour: [...AXES[axis].slice(0, 3), 0.62],
      mesh: this.renderer.mesh(Shapes.sticks(places.map(T => [Array.from(T.slice(12, 15)), Array.from(T.slice(4 * axis, 4 * axis + 3))]), s * 0.035, s * 0.0016)) }));
    const points = [];
    for (let i = 0; i < this.scene.frames; i++) points.push(Array.from(this.tips.subarray(7 * i, 7 * i + 3)));
    this.path = this.renderer.mesh(Shapes.tube(points, s * 0.0032));
    const wide = s * 9;
    this.ground = { mesh: this.renderer.mesh({ vertices: [[-1, -1], [1, -1], [1, 1], [-1, 1]].flatMap(([x, y]) => [x * wide, y * wide, 0, 0, 0, 1]), indices: [0, 1, 2, 0, 2, 3] }), model: Matrix.pose(0, 0, this.scene.floor, 1, 0, 0, 0) };
  }
  home() {
    this.target = [...this.scene.centre];
    this.azimuth = -0.95; this.elevation = 0.36; this.distance = this.size * (this.canvas.clientWidth < 600 ? 3.9 : 3.05);
    this.changed();
  }
  // Pose `index` of a row of `count`, at a fractional frame: positions linear, quaternions normalised linear.
  between(rows, count, index, frame) {
    const last = this.scene.frames - 1, i = Math.min(Math.floor(frame), last), j = Math.min(i + 1, last), f = frame - i;
    const a = rows.subarray((i * count + index) * 7, (i * count + index) * 7 + 7), b = rows.subarray((j * count + index) * 7, (j * count + index) * 7 + 7);
    const sign = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6] < 0 ? -1 : 1, out = new Array(7);
    for (let k = 0; k < 7; k++) out[k] = a[k] * (1 - f) + (k > 2 ? sign : 1) * b[k] * f;
    const norm = Math.hypot(out[3], out[4], out[5], out[6]);
    for (let k = 3; k < 7; k++) out[k] /= norm;
    return Matrix.pose(...out);
  }
  triad(pose, scale, alpha, shadow) {
    const turns = [[0.7071, 0, 0.7071, 0], [0.7071, -0.7071, 0, 0], [1, 0, 0, 0]], grow = Matrix.pose(0, 0, 0, 1, 0, 0, 0), items = [];
    for (let k of [0, 5, 10]) grow[k] = scale;
    const frame = Matrix.multiply(pose, grow);
    turns.forEach((turn, axis) => {
      const colour = [...AXES[axis].slice(0, 3), alpha], along = Matrix.multiply(frame, Matrix.pose(0, 0, 0, ...turn));
      items.push({ mesh: this.shaft, model: Matrix.multiply(along, Matrix.pose(0, 0, this.size * 0.0425, 1, 0, 0, 0)), colour, shadow });
      items.push({ mesh: this.head, model: Matrix.multiply(along, Matrix.pose(0, 0, this.size * 0.085, 1, 0, 0, 0)), colour, shadow });
    });
    return items;
  }
  items(frame) {
    const count = this.scene.bodies.length, poses = this.scene.bodies.map((_, k) => this.between(this.poses, count, k, frame));
    const list = this.parts.map(part => ({ mesh: part.mesh, model: Matrix.multiply(poses[part.link], part.local), colour: part.colour, shadow: true }));
    const identity = Matrix.pose(0, 0, 0, 1, 0, 0, 0), tip = this.between(this.tips, 1, 0, frame), accent = this.colour("--accent");
    if (this.showPath) {
      const step = 6 * 8, past = Math.min(Math.floor(frame), this.scene.frames - 1) * step, rest = this.path.count - past;
      if (past > 0) list.push({ mesh: this.path, model: identity, colour: accent, count: past, gloss: 0 });
      if (rest > 0) list.push({ mesh: this.path, model: identity, colour: [...accent.slice(0, 3), 0.32], first: past, count: rest, gloss: 0 });
      const aim = this.between(this.reference, 1, 0, frame);
      list.push({ mesh: this.ball, model: aim, colour: accent, gloss: 0 });
    }
    if (this.showFrames) {
      list.push(...this.triad(tip, 1, 1, true), ...this.triad(identity, 1.15, 1, true));
      for (const place of this.few) list.push(...this.triad(place, 0.75, 0.62, false));
      for (const axis of this.many) list.push({ ...axis, model: identity, shadow: false });
    }
    return list;
  }
  colour(name) {
    const text = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
    return [1, 3, 5].map(i => parseInt(text.slice(i, i + 2), 16) / 255).concat(1);
  }
  show(frame) { this.frame = frame; this.changed(); }
  changed() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.paint(); });
  }
  paint() {
    const c = Math.cos(this.elevation), away = [c * Math.cos(this.azimuth), c * Math.sin(this.azimuth), Math.sin(this.elevation)];
    const eye = Vector.plus(this.target, away, this.distance), pitch = Math.pow(10, Math.floor(Math.log10(this.size * 0.35)));
    this.renderer.render(this.items(this.frame || 0), {
      eye, target: this.target, centre: this.scene.centre, size: this.size, ground: this.ground, pitch,
      floor: this.colour("--floor"), lines: this.colour("--grid") });
  }
  turn(dx, dy) {
    this.azimuth -= dx * 0.008;
    this.elevation = Math.max(-0.25, Math.min(1.54, this.elevation + dy * 0.008));
    this.changed();
  }
  slide(dx, dy) {
    const step = this.distance * 0.0011, side = [-Math.sin(this.azimuth), Math.cos(this.azimuth), 0];
    this.target = Vector.plus(Vector.plus(this.target, side, -dx * step), [0, 0, 1], dy * step);
    this.changed();
  }
  zoom(factor) {
    this.distance = Math.max(this.size * 0.35, Math.min(this.size * 12, this.distance * factor));
    this.changed();
  }
  listen() {
    const canvas = this.canvas, held = new Map();
    let gap = 0;
    canvas.addEventListener("pointerdown", e => { held.set(e.pointerId, e); canvas.setPointerCapture(e.pointerId); gap = 0; });
    const release = e => held.delete(e.pointerId);
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointermove", e => {
      const before = held.get(e.pointerId);
      if (!before) return;
      const dx = e.clientX - before.clientX, dy = e.clientY - before.clientY;
      held.set(e.pointerId, e);
      if (held.size === 2) {
        const [a, b] = [...held.values()], now = Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
        if (gap) this.zoom(gap / now);
        gap = now;
        this.slide(dx / 2, dy / 2);
      } else if (e.buttons & 2 || e.shiftKey) this.slide(dx, dy);
      else this.turn(dx, dy);
    });
    canvas.addEventListener("wheel", e => { e.preventDefault(); this.zoom(Math.exp(Math.max(-60, Math.min(60, e.deltaY)) * 0.003)); }, { passive: false });
    canvas.addEventListener("contextmenu", e => e.preventDefault());
    canvas.addEventListener("dblclick", () => this.home());
    canvas.addEventListener("keydown", e => {
      const turns = { ArrowLeft: [-14, 0], ArrowRight: [14, 0], ArrowUp: [0, 14], ArrowDown: [0, -14] };
      if (turns[e.key]) { e.preventDefault(); this.turn(...turns[e.key]); }
      if (e.key === "+" || e.key === "=") this.zoom(0.88);
      if (e.key === "-") this.zoom(1.14);
    });
    new ResizeObserver(() => this.changed()).observe(canvas);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.changed());
  }
}
