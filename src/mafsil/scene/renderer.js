// A small WebGL 2 renderer: lit triangles, one shadow map with soft edges, a grid floor that fades with distance.
//
// A picture is made in three passes:
//   1. the depth of all bodies as the sun sees them, into the shadow map;
//   2. the floor, with grid and shadows, which covers nothing (it writes no depth);
//   3. the bodies: opaque ones first, then translucent ones over them.
// Colours are premultiplied by their opacity, so that the page's background shows through. z points up, lengths are metres.

import { Matrix, Vector } from "./matrix.js";

// Every program shares this vertex shader: places in the world, in the sun's picture and on the screen, the same to the
// last bit in all of them.
const VERTEX_SHADER = `#version 300 es
layout(location=0) in vec3 position;
layout(location=1) in vec3 normal;
uniform mat4 model, camera, light;
out vec3 world, facing;
out vec4 shade;
invariant gl_Position;
void main() {
  vec4 place = model * vec4(position, 1.);
  world = place.xyz;
  facing = mat3(model) * normal;
  shade = light * place;
  gl_Position = camera * place;
}`;

// Share of the sun that reaches a place: the mean of comparisons with the shadow map around it, which softens edges; 25
// of them, or a single one for machines that draw without a graphics processor.
const SUNLIT_SHARE = `
uniform highp sampler2DShadow shadows;
uniform float texel;
float sunlitShare(vec4 shade, float bias) {
  vec3 place = shade.xyz / shade.w * .5 + .5;
  if (any(lessThan(place.xy, vec2(0.))) || any(greaterThan(place, vec3(1.)))) return 1.;
  float sum = 0.;
  for (int i = -SPREAD; i <= SPREAD; i++)
    for (int j = -SPREAD; j <= SPREAD; j++)
      sum += texture(shadows, vec3(place.xy + vec2(i, j) * texel * 1.3, place.z - bias));
  return sum / float((2 * SPREAD + 1) * (2 * SPREAD + 1));
}`;

// Bodies: light of the sky (grey from below, bluish from above), the sun, a weak second light from behind, gloss.
const BODY_SHADER = `#version 300 es
precision highp float;
in vec3 world, facing;
in vec4 shade;
out vec4 pixel;
uniform vec4 colour;
uniform vec3 eye, sun;
uniform float gloss;${SUNLIT_SHARE}
void main() {
  vec3 normal = normalize(facing), toEye = normalize(eye - world), halfway = normalize(sun + toEye);
  float facesEye = dot(normal, toEye); // of a silhouette it is hardly below zero, of an inner side far
  if (facesEye < 0.) normal = facesEye < -.3 ? -normal : normalize(normal - facesEye * toEye);
  float share = sunlitShare(shade, .0016);
  vec3 sky = mix(vec3(.36, .35, .36), vec3(.74, .77, .82), normal.z * .5 + .5);
  vec3 sunlight = vec3(1., .97, .92) * max(dot(normal, sun), 0.) * share;
  float behind = max(dot(normal, normalize(vec3(-.6, .5, .2))), 0.);
  vec3 linear = pow(colour.rgb, vec3(2.2)) * (sky * .62 + sunlight * .92 + .10 * behind);
  float highlight = pow(max(dot(normal, halfway), 0.), 48.) * share;
  float edge = pow(1. - max(dot(normal, toEye), 0.), 4.);
  linear += gloss * (vec3(highlight) * .35 + edge * .10);
  pixel = vec4(pow(linear, vec3(1. / 2.2)) * colour.a, colour.a);
}`;

// Ghosts on machines without a graphics processor, where every pixel of a dozen bodies one over the other counts: the same
// light of sky and sun, without shadow, gloss and powers.
const GHOST_SHADER = `#version 300 es
precision mediump float;
in vec3 facing;
out vec4 pixel;
uniform vec4 colour;
uniform vec3 sun;
void main() {
  vec3 normal = normalize(facing);
  float bright = .62 + .1 * normal.z + .3 * abs(dot(normal, sun));
  pixel = vec4(colour.rgb * bright * colour.a, colour.a);
}`;

// The floor: lines one pixel wide at every pitch, stronger at every fifth; all fades out between 0.35 and 1 of the reach.
const FLOOR_SHADER = `#version 300 es
precision highp float;
in vec3 world, facing;
in vec4 shade;
out vec4 pixel;
uniform vec4 colour, lines;
uniform vec3 eye, middle;
uniform float pitch, reach;${SUNLIT_SHARE}
float gridLine(float spacing) {
  vec2 place = world.xy / spacing;
  vec2 pixels = abs(fract(place - .5) - .5) / fwidth(place);
  return 1. - min(min(pixels.x, pixels.y), 1.);
}
void main() {
  float fade = 1. - smoothstep(.35, 1., length(world.xy - middle.xy) / reach);
  float line = max(gridLine(pitch) * .38, gridLine(pitch * 5.) * .8);
  vec3 shown = mix(colour.rgb, lines.rgb, line * fade) * mix(.74, 1., sunlitShare(shade, .0012));
  pixel = vec4(shown, 1.) * fade;
}`;

const BEHIND = [1, 200]; // of ghosts, in units of slope and of depth: some millimetres, as much as round bodies are flattened by

const DEPTH_SHADER = `#version 300 es
precision mediump float;
void main() {}`;

const UP = [0, 0, 1];
const SUN = Vector.unit([0.45, -0.55, 1.0]);
// How well is drawn: by a graphics processor, or by a machine without one.
const FULL = { spread: 2, shadowMap: 2048, ratio: (screen) => Math.min(screen, 2) };
const LIGHT = { spread: 0, shadowMap: 512, ratio: () => 0.5 };
const AT_REST = { spread: 1, shadowMap: 1024, ratio: (screen) => Math.max(1.5, Math.min(1.5 * screen, 2)) };
const FIELD_OF_VIEW = 0.62; // radians
const CONTEXT = { antialias: true, alpha: true, premultipliedAlpha: true, preserveDrawingBuffer: true };
const FLOAT_BYTES = 4, INDEX_BYTES = 4;

/** Whether a canvas would be drawn without a graphics processor; it cannot be drawn with other settings afterwards. */
export function drawsBySoftware(canvas) {
  const gl = canvas.getContext("webgl2", CONTEXT), known = gl?.getExtension("WEBGL_debug_renderer_info");
  return known ? /swiftshader|llvmpipe|software|basic render/i.test(gl.getParameter(known.UNMASKED_RENDERER_WEBGL)) : false;
}

export class Renderer {
  // Throws where the browser has no WebGL 2. light: draw with little effort.
  constructor(canvas, { light = false } = {}) {
    const gl = canvas.getContext("webgl2", { ...CONTEXT, antialias: !light });
    if (!gl) throw new Error("no WebGL 2");
    this.gl = gl;
    this.light = light;
    this.canvas = canvas;
    this.shown = null; // size in CSS pixels, where somebody watches it; asking the browser makes it lay out the page
    this.made = new Map();
    this.take(light ? LIGHT : FULL);
  }

  // Little effort while something moves, full effort at rest, on machines where that is not the same.
  refine(still) {
    if (this.light) this.take(still ? AT_REST : LIGHT);
  }

  // Draw as well as this from now on, with programs and a shadow map that are made once.
  take(quality) {
    this.quality = quality;
    if (!this.made.has(quality)) this.made.set(quality, this.makePrograms());
    Object.assign(this, this.made.get(quality));
  }

  makePrograms() {
    const [bodyProgram, floorProgram, depthProgram] = [BODY_SHADER, FLOOR_SHADER, DEPTH_SHADER].map((text) => this.compile(VERTEX_SHADER, text));
    return {
      bodyProgram, floorProgram, depthProgram, ghostProgram: this.light ? this.compile(VERTEX_SHADER, GHOST_SHADER) : bodyProgram,
      ...this.makeShadowMap()
    };
  }

  // A program and the locations of its uniforms, by name.
  compile(vertexText, fragmentText) {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertexText], [gl.FRAGMENT_SHADER, fragmentText]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text.replaceAll("SPREAD", String(this.quality.spread)));
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    const locations = {};
    const count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS);
    for (let i = 0; i < count; i++) {
      const name = gl.getActiveUniform(program, i).name;
      locations[name] = gl.getUniformLocation(program, name);
    }
    return { program, locations };
  }

  // A depth texture that compares when it is read, and the framebuffer that draws into it.
  makeShadowMap() {
    const gl = this.gl;
    const shadowMap = gl.createTexture(), shadowTarget = gl.createFramebuffer();
    gl.bindTexture(gl.TEXTURE_2D, shadowMap);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, this.quality.shadowMap, this.quality.shadowMap);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    gl.bindFramebuffer(gl.FRAMEBUFFER, shadowTarget);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, shadowMap, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return { shadowMap, shadowTarget };
  }

  // Triangles on the graphics processor. vertices: position and normal, six numbers each; indices: three a triangle.
  mesh({ vertices, indices }) {
    const gl = this.gl;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(vertices), gl.STATIC_DRAW);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(indices), gl.STATIC_DRAW);
    for (const [attribute, firstNumber] of [[0, 0], [1, 3]]) {
      gl.enableVertexAttribArray(attribute);
      gl.vertexAttribPointer(attribute, 3, gl.FLOAT, false, 6 * FLOAT_BYTES, firstNumber * FLOAT_BYTES);
    }
    gl.bindVertexArray(null);
    return { array, count: indices.length };
  }

  // Hand values to the program in use: matrices, colours, points and numbers, told apart by their length.
  setUniforms(program, values) {
    const gl = this.gl;
    for (const [name, value] of Object.entries(values)) {
      const location = program.locations[name];
      if (!location) continue; // the shader does not use it
      if (value.length === 16) gl.uniformMatrix4fv(location, false, value);
      else if (value.length === 4) gl.uniform4fv(location, value);
      else if (value.length === 3) gl.uniform3fv(location, value);
      else gl.uniform1f(location, value);
    }
  }

  // item: {mesh, model, colour}, and if wanted gloss, and the range {first, count} of its indices.
  draw(program, item) {
    const gl = this.gl;
    this.setUniforms(program, { model: item.model, colour: item.colour, gloss: item.gloss ?? 1 });
    gl.bindVertexArray(item.mesh.array);
    gl.drawElements(gl.TRIANGLES, item.count ?? item.mesh.count, gl.UNSIGNED_INT, (item.first || 0) * INDEX_BYTES);
  }

  // One picture. items: as for draw, with `shadow` where they throw one;
  // view: {eye, target, centre, size, ground, floor, lines, pitch}.
  render(items, view) {
    const { width, height } = this.fitCanvas();
    const light = this.lightMatrix(view);
    const camera = this.cameraMatrix(view, width / Math.max(height, 1));
    this.drawShadowMap(items, light);
    this.clearScreen(width, height);
    const shared = { camera, light, eye: view.eye, sun: SUN, texel: 1 / this.quality.shadowMap };
    this.drawFloor(view, shared);
    this.drawBodies(items, shared);
  }

  // Give the canvas as many pixels as the quality asks for.
  fitCanvas() {
    const canvas = this.canvas;
    const ratio = this.quality.ratio(window.devicePixelRatio || 1);
    const shown = this.shown ?? { width: canvas.clientWidth, height: canvas.clientHeight };
    const width = Math.round(shown.width * ratio), height = Math.round(shown.height * ratio);
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    return { width, height };
  }

  // From the world to the sun's picture of it.
  lightMatrix({ centre, size }) {
    const place = Vector.plus(centre, SUN, size * 3);
    return Matrix.multiply(Matrix.orthographic(size * 1.25, 0.1, size * 6), Matrix.lookAt(place, centre, UP));
  }

  // From the world to the screen.
  cameraMatrix({ eye, target, size }, aspect) {
    const lens = Matrix.perspective(FIELD_OF_VIEW, aspect, size * 0.02, size * 40);
    return Matrix.multiply(lens, Matrix.lookAt(eye, target, UP));
  }

  // 1. What the sun sees, as depths.
  drawShadowMap(items, light) {
    const gl = this.gl;
    gl.enable(gl.DEPTH_TEST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowTarget);
    gl.viewport(0, 0, this.quality.shadowMap, this.quality.shadowMap);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.depthProgram.program);
    this.setUniforms(this.depthProgram, { camera: light, light });
    for (const item of items) if (item.shadow) this.draw(this.depthProgram, item);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  clearScreen(width, height) {
    const gl = this.gl;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.bindTexture(gl.TEXTURE_2D, this.shadowMap);
  }

  // 2. The floor, which writes no depth: bodies below it stay visible.
  drawFloor(view, shared) {
    const gl = this.gl;
    const { lines, pitch, centre, size } = view;
    gl.useProgram(this.floorProgram.program);
    this.setUniforms(this.floorProgram, { ...shared, lines, pitch, reach: size * 4.2, middle: centre });
    gl.depthMask(false);
    this.draw(this.floorProgram, { ...view.ground, colour: view.floor });
    gl.depthMask(true);
  }

  // 3. The bodies: opaque ones, then ghosts, of which only the nearest surface shows, then translucent ones, which write
  // no depth; at last what lies over all of them.
  drawBodies(all, shared) {
    const gl = this.gl, items = all.filter((item) => !item.over), over = all.filter((item) => item.over);
    const opaque = items.filter((item) => item.colour[3] >= 1);
    const ghosts = items.filter((item) => item.ghost), rest = items.filter((item) => item.colour[3] < 1 && !item.ghost);
    gl.useProgram(this.bodyProgram.program);
    this.setUniforms(this.bodyProgram, shared);
    for (const item of opaque) this.draw(this.bodyProgram, item);
    gl.enable(gl.POLYGON_OFFSET_FILL); // where a ghost lies in an opaque body, the body is seen
    gl.polygonOffset(...BEHIND);
    gl.colorMask(false, false, false, false);
    gl.useProgram(this.depthProgram.program);
    this.setUniforms(this.depthProgram, shared);
    for (const item of ghosts) this.draw(this.depthProgram, item);
    gl.useProgram(this.ghostProgram.program);
    this.setUniforms(this.ghostProgram, shared);
    gl.colorMask(true, true, true, true);
    gl.depthFunc(gl.LEQUAL);
    for (const item of ghosts) this.draw(this.ghostProgram, item);
    gl.useProgram(this.bodyProgram.program);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.depthFunc(gl.LESS);
    gl.depthMask(false);
    for (const item of rest) this.draw(this.bodyProgram, item);
    gl.depthMask(true);
    if (over.length) gl.clear(gl.DEPTH_BUFFER_BIT);
    for (const item of over) this.draw(this.bodyProgram, item);
  }
}
