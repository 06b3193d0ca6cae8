// A small WebGL 2 renderer: lit meshes, one shadow map with soft edges, a fading grid floor.
const LIT_VERTEX = `#version 300 es
layout(location=0) in vec3 position; layout(location=1) in vec3 normal;
uniform mat4 model, camera, light; out vec3 world, facing; out vec4 shade;
void main() { vec4 p = model * vec4(position, 1.); world = p.xyz; facing = mat3(model) * normal; shade = light * p; gl_Position = camera * p; }`;
const SHADOW = `
uniform highp sampler2DShadow shadows; uniform float texel;
float lit(vec4 shade, float bias) {
  vec3 p = shade.xyz / shade.w * .5 + .5; float sum = 0.;
  if (p.x < 0. || p.x > 1. || p.y < 0. || p.y > 1. || p.z > 1.) return 1.;
  for (int i = -2; i <= 2; i++) for (int j = -2; j <= 2; j++) sum += texture(shadows, vec3(p.xy + vec2(i, j) * texel * 1.3, p.z - bias));
  return sum / 25.;
}`;
const LIT_FRAGMENT = `#version 300 es
precision highp float; in vec3 world, facing; in vec4 shade; out vec4 pixel;
uniform vec4 colour; uniform vec3 eye, sun; uniform float gloss;${SHADOW}
void main() {
  vec3 n = normalize(facing), v = normalize(eye - world), h = normalize(sun + v);
  if (dot(n, v) < 0.) n = -n;
  float direct = max(dot(n, sun), 0.), open = lit(shade, .0016);
  vec3 sky = mix(vec3(.36, .35, .36), vec3(.74, .77, .82), n.z * .5 + .5);
  float edge = pow(1. - max(dot(n, v), 0.), 4.);
  vec3 base = pow(colour.rgb, vec3(2.2));
  vec3 sum = base * (sky * .62 + vec3(1., .97, .92) * direct * open * .92 + .10 * max(dot(n, normalize(vec3(-.6, .5, .2))), 0.));
  sum += gloss * (vec3(pow(max(dot(n, h), 0.), 48.)) * open * .35 + edge * .10);
  pixel = vec4(pow(sum, vec3(1. / 2.2)) * colour.a, colour.a);
}`;
const FLOOR_FRAGMENT = `#version 300 es
precision highp float; in vec3 world, facing; in vec4 shade; out vec4 pixel;
uniform vec4 colour, lines; uniform vec3 eye, middle; uniform float pitch, reach;${SHADOW}
float grid(float step_) { vec2 q = world.xy / step_, w = fwidth(q); vec2 d = abs(fract(q - .5) - .5) / w; return 1. - min(min(d.x, d.y), 1.); }
void main() {
  float away = length(world.xy - middle.xy) / reach, fade = 1. - smoothstep(.35, 1., away);
  float g = max(grid(pitch) * .38, grid(pitch * 5.) * .8);
  vec3 c = mix(colour.rgb, lines.rgb, g * fade) * mix(.74, 1., lit(shade, .0012));
  pixel = vec4(c, 1.) * fade;
}`;
const DEPTH_FRAGMENT = `#version 300 es
precision mediump float; void main() {}`;

class Renderer {
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: true, preserveDrawingBuffer: true });
    if (!gl) throw new Error("no WebGL 2");
    this.gl = gl;
    this.canvas = canvas;
    this.lit = this.program(LIT_VERTEX, LIT_FRAGMENT);
    this.floor = this.program(LIT_VERTEX, FLOOR_FRAGMENT);
    this.depth = this.program(LIT_VERTEX, DEPTH_FRAGMENT);
    this.makeShadowMap(2048);
  }
  program(vertex, fragment) {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text); gl.compileShader(shader); gl.attachShader(program, shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    }
    gl.linkProgram(program);
    const places = {}, count = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS);
    for (let i = 0; i < count; i++) { const name = gl.getActiveUniform(program, i).name; places[name] = gl.getUniformLocation(program, name); }
    return { program, places };
  }
  makeShadowMap(size) {
    const gl = this.gl;
    this.shadowSize = size;
    this.shadowMap = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.shadowMap);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, size, size);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.LINEAR);
    this.shadowTarget = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowTarget);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.shadowMap, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }
  mesh({ vertices, indices }) {
    const gl = this.gl, array = gl.createVertexArray();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(vertices), gl.STATIC_DRAW);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(indices), gl.STATIC_DRAW);
    for (const [place, offset] of [[0, 0], [1, 12]]) { gl.enableVertexAttribArray(place); gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 24, offset); }
    gl.bindVertexArray(null);
    return { array, count: indices.length };
  }
  set(program, values) {
    const gl = this.gl;
    for (const [name, value] of Object.entries(values)) {
      const place = program.places[name];
      if (!place) continue;
      if (value.length === 16) gl.uniformMatrix4fv(place, false, value);
      else if (value.length === 4) gl.uniform4fv(place, value);
      else if (value.length === 3) gl.uniform3fv(place, value);
      else gl.uniform1f(place, value);
    }
  }
  draw(program, item) {
    const gl = this.gl, first = item.first || 0, count = item.count ?? item.mesh.count;
    this.set(program, { model: item.model, colour: item.colour, gloss: item.gloss ?? 1 });
    gl.bindVertexArray(item.mesh.array);
    gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, first * 4);
  }
  // items: {mesh, model, colour, shadow, first, count}; view: {eye, target, centre, size, floor, lines, pitch, ground}
  render(items, view) {
    const gl = this.gl, ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.round(this.canvas.clientWidth * ratio), height = Math.round(this.canvas.clientHeight * ratio);
    if (this.canvas.width !== width || this.canvas.height !== height) { this.canvas.width = width; this.canvas.height = height; }
    const sun = Vector.unit([0.45, -0.55, 1.0]);
    const light = Matrix.multiply(Matrix.orthographic(view.size * 1.25, 0.1, view.size * 6),
      Matrix.lookAt(Vector.plus(view.centre, sun, view.size * 3), view.centre, [0, 0, 1]));
    const camera = Matrix.multiply(Matrix.perspective(0.62, width / Math.max(height, 1), view.size * 0.02, view.size * 40),
      Matrix.lookAt(view.eye, view.target, [0, 0, 1]));
    gl.enable(gl.DEPTH_TEST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.shadowTarget);
    gl.viewport(0, 0, this.shadowSize, this.shadowSize);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.depth.program);
    this.set(this.depth, { camera: light, light });
    for (const item of items) if (item.shadow) this.draw(this.depth, item);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.bindTexture(gl.TEXTURE_2D, this.shadowMap);
    const shared = { camera, light, eye: view.eye, sun, texel: 1 / this.shadowSize };
    gl.useProgram(this.floor.program);
    this.set(this.floor, { ...shared, lines: view.lines, pitch: view.pitch, reach: view.size * 4.2, middle: view.centre });
    gl.depthMask(false);
    this.draw(this.floor, { ...view.ground, colour: view.floor });
    gl.depthMask(true);
    gl.useProgram(this.lit.program);
    this.set(this.lit, shared);
    for (const item of items) if (item.colour[3] >= 1) this.draw(this.lit, item);
    gl.depthMask(false);
    for (const item of items) if (item.colour[3] < 1) this.draw(this.lit, item);
    gl.depthMask(true);
  }
}
