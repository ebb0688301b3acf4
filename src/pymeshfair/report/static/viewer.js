"use strict";
/* Shows one or two meshes side by side from one camera, with WebGL2 alone. Reads the scenes of pymeshfair.report.scene. */

const VERTEX_SHADER = `#version 300 es
precision highp float;
in vec3 place; in vec2 direction; in float level;
uniform mat3 turn; uniform vec3 focus; uniform vec2 scale; uniform float depth, dot_size; uniform vec2 spread;
out vec3 seen; out vec3 normal; out float share;
void main() {
  seen = turn * (place / 32767.5 - 1.0 - focus);
  vec2 flat_ = direction / 2047.5 - 1.0;
  vec3 n = vec3(flat_, 1.0 - abs(flat_.x) - abs(flat_.y));
  if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
  normal = turn * normalize(n);
  share = clamp(spread.x + spread.y * level / 255.0, 0.0, 1.0);
  gl_Position = vec4(seen.xy * scale, -seen.z * depth, 1.0);
  gl_PointSize = dot_size;
}`;

const FRAGMENT_SHADER = `#version 300 es
precision highp float;
in vec3 seen; in vec3 normal; in float share;
uniform int style;      // 0 clay, 1 colours of numbers, 2 reflection lines
uniform int kind;       // 0 triangles, 1 dots with normals, 2 dots and lines without
uniform float depth, stripes;
uniform sampler2D colors;
out vec4 color;
const vec3 LIGHT = normalize(vec3(-0.38, 0.48, 0.79));
void main() {
  vec3 base = style == 1 ? texture(colors, vec2((share * 255.0 + 0.5) / 256.0, 0.5)).rgb : vec3(0.72, 0.745, 0.78);
  if (kind == 2) {
    float near = clamp(0.5 + 0.5 * seen.z * depth, 0.0, 1.0);
    color = vec4(base * (style == 1 ? 1.0 : 0.8) * (0.55 + 0.45 * near), 1.0);
    return;
  }
  vec3 n = kind == 1 ? normal * (normal.z < 0.0 ? -1.0 : 1.0) : normalize(cross(dFdx(seen), dFdy(seen)));
  if (style == 2 && kind == 0) {
    vec3 m = normalize(normal);
    if (m.z < 0.0) m = -m;
    vec3 r = 2.0 * m.z * m - vec3(0.0, 0.0, 1.0);
    float bright = 0.5 + 0.5 * clamp(cos(round(stripes) * atan(r.x, r.z)) / 0.25, -1.0, 1.0);
    color = vec4(vec3(0.08 + 0.84 * bright), 1.0);
    return;
  }
  if (kind == 0 && !gl_FrontFacing) base = mix(vec3(0.55, 0.36, 0.30), base, 0.45);
  vec3 light = style == 1 ? vec3(0.45, 0.58, 0.06) : vec3(0.20, 0.85, 0.32);
  float shine = pow(max(dot(n, normalize(LIGHT + vec3(0.0, 0.0, 1.0))), 0.0), 40.0);
  color = vec4((light.x + light.y * max(dot(n, LIGHT), 0.0)) * base + light.z * shine * (1.0 - 0.5 * base), 1.0);
}`;

async function inflate(bytes) {
  if (typeof DecompressionStream === "undefined") throw new Error("this browser is too old: it cannot unpack the meshes");
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function bytesOf(base64) {
  const letters = atob(base64.trim());
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

/* The arrays of all meshes, decoded from the differences of their integers. */
async function readScene(header, packed) {
  const body = await inflate(packed);
  let at = 0;
  const meshes = header.meshes.map((mesh) => {
    const arrays = {};
    for (const { name, bits, rows, columns } of mesh.arrays) {
      const size = bits / 8, count = rows * columns;
      const steps = new Uint32Array(count);
      for (let b = 0; b < size; b++) for (let i = 0; i < count; i++) steps[i] |= body[at + b * count + i] << (8 * b);
      at += size * count;
      const Kind = { 8: Uint8Array, 16: Uint16Array, 32: Uint32Array }[bits];
      const array = new Kind(count);
      if (bits === 32) {
        for (let i = 0, sum = 0; i < count; i++) array[i] = sum = (sum + ((steps[i] >>> 1) ^ -(steps[i] & 1))) >>> 0;
      } else {
        for (let c = 0; c < columns; c++)
          for (let i = 0, sum = 0; i < rows; i++) array[i * columns + c] = sum = sum + steps[c * rows + i];
      }
      arrays[name] = { array, rows, columns };
    }
    return { ...mesh, arrays };
  });
  return { ...header, meshes };
}

async function readMessage(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  return readScene(header, new Uint8Array(buffer, 4 + length));
}

/* A parallel projection: azimuth and elevation in degrees, the point in the middle, and the zoom. */
class Camera {
  constructor(up) { this.up = up; this.reset(); }
  reset() { this.azimuth = 0; this.elevation = 0; this.focus = [0, 0, 0]; this.zoom = 1; }
  /* the directions to the right, upwards and to the eye, row by row */
  get rows() {
    const a = this.azimuth * Math.PI / 180, e = this.elevation * Math.PI / 180;
    const eye = [Math.sin(a) * Math.cos(e), Math.sin(e), Math.cos(a) * Math.cos(e)];
    const right = [Math.cos(a), 0, -Math.sin(a)];
    const upwards = [eye[1] * right[2] - eye[2] * right[1], eye[2] * right[0] - eye[0] * right[2], eye[0] * right[1] - eye[1] * right[0]];
    const rows = [right, upwards, eye];
    return this.up === "z" ? rows.map(([x, y, z]) => [x, -z, y]) : rows;
  }
  turn(azimuth, elevation) {
    this.azimuth = ((this.azimuth + azimuth + 180) % 360 + 360) % 360 - 180;
    this.elevation = Math.max(-90, Math.min(90, this.elevation + elevation));
  }
  /* changes the zoom, within limits */
  grow(factor) { this.zoom = Math.max(0.2, Math.min(2000, this.zoom * factor)); }
  move(across, upwards) {
    const [right, up] = this.rows;
    this.focus = this.focus.map((x, k) => x - across * right[k] - upwards * up[k]);
  }
}

class Viewer {
  /* `root` holds a canvas, and elements with the attributes data-scale-bar, data-color-bar and data-status, each of which may be missing. */
  constructor(root) {
    this.root = root;
    this.canvas = root.querySelector("canvas");
    this.gl = this.canvas.getContext("webgl2", { antialias: true, alpha: true, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error("this browser draws no 3D (WebGL2); everything else on the page holds all the same");
    this.camera = new Camera("y");
    this.views = [];        // the meshes in each view, side by side
    this.style = "plain";   // or "reflection", or the name of a coloring
    this.stripes = 8;
    this.meshes = [];
    this.scene = null;
    this.frame = 0;
    this._prepare();
    this._listen();
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  show(scene) {
    this.scene = scene;
    this.camera.up = scene.up;
    if (this.views.length === 0) this.views = scene.meshes.map((_, k) => k);
    this._upload();
    this.draw();
  }

  choose(views) { this.views = views; this.draw(); }
  color(style) { this.style = style; this.draw(); }

  /* moves a place, in the units of the scene, to the middle */
  approach(place, zoom) { this.camera.focus = [...place]; this.camera.zoom = zoom; this.draw(); }

  /* the front vertex at a place of the screen: its place in the units of the scene, its number and its mesh; or null */
  pick(clientX, clientY) {
    const box = this.canvas.getBoundingClientRect(), { stacked, width, height } = this.layout;
    const k = stacked ? Math.floor((clientY - box.top) / height) : Math.floor((clientX - box.left) / width);
    const mesh = this.scene.meshes[this.views[k]];
    if (!mesh) return null;
    const x = (clientX - box.left) - (stacked ? 0 : k * width) - width / 2, y = height / 2 - ((clientY - box.top) - (stacked ? k * height : 0));
    const places = mesh.arrays.positions.array, [right, up, eye] = this.camera.rows, focus = this.camera.focus, pixels = this.pixels;
    let found = null, front = -Infinity;
    for (let i = 0; i < places.length; i += 3) {
      const p = [0, 1, 2].map((c) => places[i + c] / 32767.5 - 1 - focus[c]);
      const dx = (p[0] * right[0] + p[1] * right[1] + p[2] * right[2]) * pixels - x, dy = (p[0] * up[0] + p[1] * up[1] + p[2] * up[2]) * pixels - y;
      const near = p[0] * eye[0] + p[1] * eye[1] + p[2] * eye[2];
      if (dx * dx + dy * dy <= 64 && near > front) {
        front = near;
        found = { mesh, vertex: i / 3 };
      }
    }
    return found;
  }

  _prepare() {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX_SHADER], [gl.FRAGMENT_SHADER, FRAGMENT_SHADER]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    ["place", "direction", "level"].forEach((name, k) => gl.bindAttribLocation(program, k, name));
    gl.linkProgram(program);
    gl.useProgram(program);
    this.at = Object.fromEntries(
      ["turn", "focus", "scale", "depth", "dot_size", "style", "kind", "stripes", "colors", "spread"].map((n) => [n, gl.getUniformLocation(program, n)]));
    this.texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.SCISSOR_TEST);
    gl.frontFace(gl.CCW);
  }

  _upload() {
    const gl = this.gl;
    for (const mesh of this.meshes) {
      Object.values(mesh.buffers).forEach((buffer) => gl.deleteBuffer(buffer));
      gl.deleteVertexArray(mesh.state);
    }
    this.meshes = this.scene.meshes.map((mesh) => {
      const state = gl.createVertexArray(), buffers = {};
      gl.bindVertexArray(state);
      for (const [name, { array }] of Object.entries(mesh.arrays)) {
        const target = name === "elements" ? gl.ELEMENT_ARRAY_BUFFER : gl.ARRAY_BUFFER;
        buffers[name] = gl.createBuffer();
        gl.bindBuffer(target, buffers[name]);
        gl.bufferData(target, array, gl.STATIC_DRAW);
      }
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers.positions);
      gl.enableVertexAttribArray(0);
      gl.vertexAttribPointer(0, 3, gl.UNSIGNED_SHORT, false, 0, 0);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers.normals);
      gl.enableVertexAttribArray(1);
      gl.vertexAttribPointer(1, 2, gl.UNSIGNED_SHORT, false, 0, 0);
      gl.bindVertexArray(null);
      return { state, buffers };
    });
  }

  draw() { this.frame ||= requestAnimationFrame(() => { this.frame = 0; this._draw(); }); }

  /* the size of a view in pixels of the screen, and whether views are below each other */
  get layout() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const count = Math.max(1, this.views.length), stacked = width < 1.1 * height;
    return { stacked, width: stacked ? width : width / count, height: stacked ? height / count : height };
  }

  /* pixels of the screen for half the box of the scene; at first the meshes fill the view */
  get pixels() { const { width, height } = this.layout; return 0.47 * Math.min(width, height) * this.camera.zoom / this.scene.fit; }

  _draw() {
    const gl = this.gl, canvas = this.canvas;
    if (!this.scene || gl.isContextLost()) return;
    const density = Math.min(2, window.devicePixelRatio || 1);
    const width = Math.round(canvas.clientWidth * density), height = Math.round(canvas.clientHeight * density);
    if (!width || !height) return;
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    gl.scissor(0, 0, width, height);
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const { stacked, width: w, height: h } = this.layout;
    const rows = this.camera.rows, coloring = this.scene.colorings[this.style];
    gl.uniformMatrix3fv(this.at.turn, true, rows.flat());
    gl.uniform3fv(this.at.focus, this.camera.focus);
    gl.uniform2f(this.at.scale, 2 * this.pixels / w, 2 * this.pixels / h);
    const far = 2 + Math.hypot(...this.camera.focus);
    gl.uniform1f(this.at.depth, 1 / far);
    gl.uniform1f(this.at.stripes, this.stripes);
    gl.uniform1f(this.at.dot_size, 2.2 * density);
    if (coloring && coloring !== this.loaded) {
      gl.bindTexture(gl.TEXTURE_2D, this.texture);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, new Uint8Array(coloring.colors));
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
      this.loaded = coloring;
    }
    this.views.forEach((number, k) => {
      const left = stacked ? 0 : k * w, bottom = stacked ? canvas.clientHeight - (k + 1) * h : 0;
      const box = [left, bottom, w, h].map((x) => Math.round(x * density));
      gl.viewport(...box);
      gl.scissor(...box);
      if (this.meshes[number]) this._drawMesh(this.meshes[number], this.scene.meshes[number]);
    });
    this._annotate();
  }

  _drawMesh({ state, buffers }, { arrays, lit, limits }) {
    const gl = this.gl, level = buffers[`scalar:${this.style}`];
    gl.bindVertexArray(state);
    if (level) {
      gl.bindBuffer(gl.ARRAY_BUFFER, level);
      gl.enableVertexAttribArray(2);
      gl.vertexAttribPointer(2, 1, gl.UNSIGNED_BYTE, false, 0, 0);
      // A mesh of another scene may have other limits than the colour bar.
      const { low, high } = this.scene.colorings[this.style], [from, to] = limits[this.style], width = high - low || 1;
      gl.uniform2f(this.at.spread, high > low ? (from - low) / width : 0.5, high > low ? (to - from) / width : 0);
    } else gl.disableVertexAttribArray(2);
    gl.uniform1i(this.at.style, level ? 1 : this.style === "reflection" ? 2 : 0);
    const { rows, columns, array } = arrays.elements;
    gl.uniform1i(this.at.kind, rows && columns === 3 ? 0 : rows || !lit ? 2 : 1);
    if (rows) gl.drawElements(columns === 3 ? gl.TRIANGLES : gl.LINES, array.length, gl.UNSIGNED_INT, 0);
    else gl.drawArrays(gl.POINTS, 0, arrays.positions.rows);
    gl.bindVertexArray(null);
  }

  _annotate() {
    const bar = this.root.querySelector("[data-scale-bar]");
    if (bar) {
      const perUnit = this.pixels / this.scene.half, most = 0.25 * this.layout.width / perUnit;
      const power = 10 ** Math.floor(Math.log10(most));
      const length = [5, 2, 1].map((s) => s * power).find((x) => x <= most * (1 + 1e-12));
      bar.style.width = `${length * perUnit}px`;
      bar.textContent = shortNumber(length);
    }
    const legend = this.root.querySelector("[data-color-bar]"), coloring = this.scene.colorings[this.style];
    if (legend && this.labelled !== coloring) {
      this.labelled = coloring;
      legend.hidden = !coloring;
      if (coloring) {
        const stops = [...Array(17).keys()].map((k) => `rgb(${coloring.colors.slice(3 * Math.min(255, 16 * k), 3 * Math.min(255, 16 * k) + 3)})`);
        legend.querySelector("i").style.background = `linear-gradient(to right, ${stops})`;
        legend.querySelector("[data-low]").textContent = shortNumber(coloring.low);
        legend.querySelector("[data-high]").textContent = shortNumber(coloring.high);
        legend.querySelector("[data-label]").textContent = coloring.label;
      }
    }
    this.root.querySelectorAll("[data-view-name]").forEach((name, k) => {
      const mesh = this.scene.meshes[this.views[k]], { stacked, width, height } = this.layout;
      name.hidden = !mesh;
      if (mesh) {
        name.textContent = mesh.name;
        name.style.left = `${stacked ? 0 : k * width}px`;
        name.style.top = `${stacked ? k * height : 0}px`;
      }
    });
    this.root.querySelectorAll("[data-marker]").forEach((ring) => {
      const { place, mesh } = this.scene.markers[Number(ring.dataset.marker)] || { place: null, mesh: -1 };
      const k = this.views.indexOf(mesh), { stacked, width, height } = this.layout;
      ring.hidden = k < 0 || !place;
      if (ring.hidden) return;
      const [x, y] = this.camera.rows.map((row) => row.reduce((sum, r, c) => sum + r * (place[c] - this.camera.focus[c]), 0) * this.pixels);
      ring.hidden = Math.abs(x) > width / 2 || Math.abs(y) > height / 2;
      ring.style.left = `${(stacked ? 0 : k * width) + width / 2 + x}px`;
      ring.style.top = `${(stacked ? k * height : 0) + height / 2 - y}px`;
    });
    this.root.dispatchEvent(new CustomEvent("drawn"));
  }

  /* shows the value under the pointer beside the colour bar */
  _tellValue(event) {
    const told = this.root.querySelector("[data-value]"), coloring = this.scene && this.scene.colorings[this.style];
    if (!told || this.looking) return;
    this.looking = true;
    requestAnimationFrame(() => {
      this.looking = false;
      const found = coloring && this.pick(event.clientX, event.clientY), level = found && found.mesh.arrays[`scalar:${this.style}`];
      if (!level) { told.textContent = ""; return; }
      const [low, high] = found.mesh.limits[this.style], share = level.array[found.vertex] / 255;
      const end = share === 0 ? "at most " : share === 1 ? "at least " : "";
      told.textContent = `here ${end}${shortNumber(low + share * (high - low))}`;
    });
  }

  _listen() {
    const canvas = this.canvas, fingers = new Map();
    const about = (event, factor) => {
      const box = canvas.getBoundingClientRect(), { width, height } = this.layout;
      const x = ((event.clientX - box.left) % width) - width / 2, y = height / 2 - ((event.clientY - box.top) % height);
      const before = this.pixels;
      this.camera.grow(factor);
      const after = this.pixels;
      this.camera.move(x / after - x / before, y / after - y / before);
      this.draw();
    };
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, event);
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = fingers.get(event.pointerId);
      if (!before) { this._tellValue(event); return; }
      const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
      if (fingers.size === 2) {
        const [other] = [...fingers.values()].filter((f) => f.pointerId !== event.pointerId);
        const span = (f) => Math.hypot(f.clientX - other.clientX, f.clientY - other.clientY) || 1;
        about({ clientX: (event.clientX + other.clientX) / 2, clientY: (event.clientY + other.clientY) / 2 }, span(event) / span(before));
        this.camera.move(dx / 2 / this.pixels, -dy / 2 / this.pixels);
      } else if (before.buttons > 1 || event.shiftKey) this.camera.move(dx / this.pixels, -dy / this.pixels);
      else this.camera.turn(-0.4 * dx, 0.4 * dy);
      fingers.set(event.pointerId, event);
      this.draw();
    });
    for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, (event) => fingers.delete(event.pointerId));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => { event.preventDefault(); about(event, Math.exp(-0.0015 * event.deltaY)); }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      if (step && event.shiftKey) this.camera.move(-0.1 * step[0] / this.camera.zoom, -0.1 * step[1] / this.camera.zoom);
      else if (step) this.camera.turn(10 * step[0], 10 * step[1]);
      else if (event.key === "+" || event.key === "=") this.camera.grow(1.25);
      else if (event.key === "-") this.camera.grow(0.8);
      else if (event.key === "0" || event.key === "Home") this.camera.reset();
      else return;
      event.preventDefault();
      this.draw();
      const status = this.root.querySelector("[data-status]");
      if (status) status.textContent = `azimuth ${this.camera.azimuth.toFixed(0)} degrees, elevation ${this.camera.elevation.toFixed(0)}, ${this.camera.zoom.toFixed(2)} times`;
    });
    canvas.addEventListener("dblclick", () => { this.camera.reset(); this.draw(); });
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => { this.meshes = []; this.loaded = null; this._prepare(); if (this.scene) this.show(this.scene); });
  }
}

function shortNumber(x) {
  const size = Math.abs(x);
  return size !== 0 && (size < 1e-3 || size >= 1e5) ? x.toExponential(2) : String(Number(x.toPrecision(3)));
}

/* Radio buttons named "views" (numbers of meshes such as "0 1") and "style" control what a viewer shows. */
function connect(viewer, form) {
  const apply = () => {
    const chosen = new FormData(form);
    if (chosen.has("views")) viewer.choose(chosen.get("views").split(" ").map(Number));
    if (chosen.has("style")) viewer.color(chosen.get("style"));
  };
  form.addEventListener("change", apply);
  form.addEventListener("submit", (event) => event.preventDefault());
  apply();
}
