// Two pictures that turn together.

const TRIANGLE_SHADER = [
  `#version 300 es
  in vec3 corner; uniform mat4 toView; uniform mat4 toClip; out vec3 seen;
  void main() { vec4 at = toView * vec4(corner, 1.0); seen = at.xyz; gl_Position = toClip * at; }`,
  // The normal of the flat triangle comes from screen-space derivatives. Both sides are lit.
  `#version 300 es
  precision highp float; in vec3 seen; uniform vec3 colour; out vec4 shown;
  void main() {
    vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
    normal *= sign(normal.z + 1e-9);
    float lit = 0.42 + 0.5 * max(dot(normal, normalize(vec3(-0.36, 0.6, 0.71))), 0.0) + 0.14 * normal.z;
    shown = vec4(colour * min(lit, 1.06), 1.0);
  }`,
];

const LINE_SHADER = [
  `#version 300 es
  in vec3 corner; in vec3 tint; uniform mat4 toView; uniform mat4 toClip; uniform float forward; uniform float dot_size;
  out vec3 colour;
  void main() {
    gl_Position = toClip * toView * vec4(corner, 1.0);
    gl_Position.z -= forward * gl_Position.w;
    gl_PointSize = dot_size;
    colour = tint;
  }`,
  `#version 300 es
  precision highp float; in vec3 colour; uniform float opacity; uniform bool round; out vec4 shown;
  void main() {
    if (round && length(gl_PointCoord - 0.5) > 0.5) discard;
    shown = vec4(colour * opacity, opacity);
  }`,
];

/** A canvas that draws layers of triangles, lines and dots. */
class View extends Surface {
  constructor(canvas, gl) {
    super(canvas, gl);
    this.triangleProgram = new Program(gl, TRIANGLE_SHADER);
    this.lineProgram = new Program(gl, LINE_SHADER);
    // Buffers of each shape.
    this.uploads = new Map();
  }

  triangles(shape, camera, colour) {
    const { gl, triangleProgram } = this, upload = this.uploaded(shape);
    this.use(triangleProgram, camera);
    gl.uniform3f(triangleProgram.location("colour"), ...colour.map((c) => c / 255));
    this.bindCorners(upload.points);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, upload.triangles);
    gl.drawElements(gl.TRIANGLES, shape.triangles.length, gl.UNSIGNED_SHORT, 0);
  }

  edges(shape, camera, look) {
    const { gl } = this, upload = this.uploaded(shape);
    this.useLines(camera, look);
    this.bindCorners(upload.points);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, upload.edges);
    gl.drawElements(gl.LINES, shape.edges.length, gl.UNSIGNED_SHORT, 0);
  }

  /** The corners of a shape. Without a colour, each has its own. */
  dots(shape, camera, look) {
    const upload = this.uploaded(shape);
    this.useLines(camera, { round: true, forward: 0.0012, ...look });
    this.bindCorners(upload.points);
    if (!look.colour) {
      upload.tints ||= this.corners(tintsOf(shape));
      this.bindTints(upload.tints);
    }
    this.gl.drawArrays(this.gl.POINTS, 0, shape.points.length / 3);
  }

  /** A dot that nothing hides. */
  spot(camera, at, colour) {
    const { gl } = this, point = this.corners(new Float32Array(at));
    this.useLines(camera, { colour, forward: 0.5, size: 11, round: true });
    this.bindCorners(point);
    gl.drawArrays(gl.POINTS, 0, 1);
    gl.deleteBuffer(point);
  }

  /** A ray with a dot: a direction and its support vertex. */
  mark(camera, from, to, vertex, colour) {
    const { gl } = this, points = this.corners(new Float32Array([...from, ...to, ...vertex]));
    this.useLines(camera, { colour, forward: 0.002 });
    this.bindCorners(points);
    gl.drawArrays(gl.LINES, 0, 2);
    this.useLines(camera, { colour, forward: 0.5, size: 9, round: true });
    gl.drawArrays(gl.POINTS, 2, 1);
    gl.deleteBuffer(points);
  }

  /** Deletes the buffers of all shapes. */
  forget() {
    for (const upload of this.uploads.values()) {
      for (const buffer of Object.values(upload)) if (buffer) this.gl.deleteBuffer(buffer);
    }
    this.uploads.clear();
  }

  /** Buffers of a shape. */
  uploaded(shape) {
    if (!this.uploads.has(shape)) {
      this.uploads.set(shape, {
        points: this.corners(shape.points),
        triangles: this.indices(shape.triangles),
        edges: this.indices(shape.edges),
        tints: null,
      });
    }
    return this.uploads.get(shape);
  }

  use(program, camera) {
    program.use();
    this.gl.uniformMatrix4fv(program.location("toView"), false, camera.toView);
    this.gl.uniformMatrix4fv(program.location("toClip"), false, camera.toClip(this.aspect));
  }

  useLines(camera, { colour, opacity = 1, forward = 0.0006, size = 1, round = false }) {
    const { gl, lineProgram } = this;
    this.use(lineProgram, camera);
    gl.uniform1f(lineProgram.location("forward"), forward);
    gl.uniform1f(lineProgram.location("dot_size"), size * Math.max(1, devicePixelRatio));
    gl.uniform1f(lineProgram.location("opacity"), opacity);
    gl.uniform1i(lineProgram.location("round"), round ? 1 : 0);
    if (colour) {
      gl.disableVertexAttribArray(1);
      gl.vertexAttrib3f(1, ...colour.map((c) => c / 255));
    }
  }

  bindTints(buffer) {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 3, gl.UNSIGNED_BYTE, true, 0, 0);
  }
}

/** A colour for each vertex of a shape. */
function tintsOf(shape) {
  const tints = new Uint8Array(shape.points.length);
  for (let at = 0; 3 * at < tints.length; at++) tints.set(colourOf(shape.number(at)), 3 * at);
  return tints;
}

/** Null where there is no WebGL2. */
function openView(canvas) {
  const gl = Surface.context(canvas);
  return gl && new View(canvas, gl);
}

/** Where the viewer stands. Angles in radians; `zoom` 1 shows the whole. */
class Camera {
  /** `pitch` is the angle from which it looks down at first. */
  constructor(up, pitch = 0.42) {
    this.middle = [0, 0, 0];
    this.radius = 1;
    this.up = up;
    this.first = pitch;
    this.reset();
  }

  reset() {
    [this.yaw, this.pitch, this.zoom, this.goal] = [-0.62, this.first, 1, null];
  }

  /** Looks from the side of a point, and at it. */
  approach(at) {
    this.goal = at;
    const away = at.map((c, axis) => c - this.middle[axis]);
    const [x, y, z] = this.up === "z" ? away : [away[0], -away[2], away[1]];
    const length = Math.hypot(x, y, z) || 1;
    [this.yaw, this.pitch] = [Math.atan2(x, -y), Math.asin(z / length)];
    this.zoom = 3;
  }

  turn(right, down) {
    this.yaw += right;
    this.pitch = Math.min(Math.max(this.pitch + down, -Math.PI / 2), Math.PI / 2);
  }

  grow(factor) {
    this.zoom = Math.min(Math.max(this.zoom * factor, 0.3), 40);
  }

  get centre() {
    return this.goal || this.middle;
  }

  look({ centre, radius }) {
    this.middle = centre;
    this.radius = radius > 0 ? radius : 1;
  }

  /** Columns of the matrix from source units to the viewer: right, up, towards. */
  get toView() {
    const [sy, cy, sp, cp] = [Math.sin(this.yaw), Math.cos(this.yaw), Math.sin(this.pitch), Math.cos(this.pitch)];
    // With z up, then with its axes renamed for y up.
    const rows = [[cy, sy, 0], [-sy * sp, cy * sp, cp], [sy * cp, -cy * cp, sp]]
      .map(([x, y, z]) => (this.up === "z" ? [x, y, z] : [x, z, -y]))
      .map((row) => row.map((c) => c / this.radius));
    const shift = rows.map((row) => -row.reduce((sum, c, axis) => sum + c * this.centre[axis], 0));
    shift[2] -= this.away;
    return new Float32Array([0, 1, 2].flatMap((axis) => [...rows.map((row) => row[axis]), 0]).concat(shift, 1));
  }

  /** Distance to the centre, in radii. */
  get away() {
    return 1 + 3.1 / this.zoom;
  }

  toClip(aspect) {
    // A lens of 30°, wider where the picture is higher than wide.
    const lens = 1 / Math.tan(0.262) * Math.min(1, aspect);
    const near = Math.max(this.away - 1.8, 0.02), far = this.away + 1.8;
    const depth = near - far;
    return new Float32Array([
      lens / aspect, 0, 0, 0, 0, lens, 0, 0, 0, 0, (far + near) / depth, -1, 0, 0, (2 * far * near) / depth, 0,
    ]);
  }
}

/** The camera for a shape that is moved by an offset, in source units. */
function movedBy(camera, offset) {
  const toView = camera.toView;
  for (let row = 0; row < 3; row++) {
    toView[12 + row] += offset.reduce((sum, c, axis) => sum + toView[4 * axis + row] * c, 0);
  }
  return { toView, toClip: (aspect) => camera.toClip(aspect) };
}

/** Mouse, touch and keys of a picture that turns. */
function steer(canvas, camera, redraw) {
  const touches = new Map();
  let spread = 0;
  const between = () => {
    const [a, b] = [...touches.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    canvas.classList.add("dragging");
    touches.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (touches.size === 2) spread = between();
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = touches.get(event.pointerId);
    if (!before) return;
    const now = { x: event.clientX, y: event.clientY };
    touches.set(event.pointerId, now);
    if (touches.size === 1) {
      camera.turn((before.x - now.x) * 0.01, (now.y - before.y) * 0.01);
    } else if (touches.size === 2 && spread > 0) {
      camera.grow(between() / spread);
      spread = between();
    }
    redraw();
  });
  for (const name of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(name, (event) => {
      touches.delete(event.pointerId);
      if (!touches.size) canvas.classList.remove("dragging");
    });
  }
  canvas.addEventListener("wheel", (event) => {
    // The wheel scrolls the page until the picture is chosen.
    if (document.activeElement !== canvas && !event.ctrlKey) return;
    event.preventDefault();
    camera.grow(Math.exp(-event.deltaY * (event.deltaMode ? 0.03 : 0.001)));
    redraw();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const step = event.shiftKey ? 0.3 : 0.08;
    const keys = {
      ArrowLeft: () => camera.turn(step, 0),
      ArrowRight: () => camera.turn(-step, 0),
      ArrowUp: () => camera.turn(0, -step),
      ArrowDown: () => camera.turn(0, step),
      "+": () => camera.grow(1.15),
      "=": () => camera.grow(1.15),
      "-": () => camera.grow(1 / 1.15),
      Home: () => camera.reset(),
    };
    if (keys[event.key] && !event.altKey && !event.metaKey && !event.ctrlKey) {
      event.preventDefault();
      keys[event.key]();
      redraw();
    }
  });
}

/**
 * Opens views on canvases, which show what `draw` draws: again when the camera moves, or when a
 * control of these ids changes. Views of canvases without WebGL are null.
 */
function openStage(canvases, camera, ids, draw) {
  const get = (id) => document.getElementById(id), root = document.documentElement;
  const views = Object.fromEntries(canvases.map((id) => [id, openView(get(id))]));
  const has3d = Object.values(views).every(Boolean);
  root.classList.toggle("no-webgl", !has3d);
  root.dataset.webgl = has3d;
  const drawNow = () => has3d && draw();
  let waits = false;
  function redraw() {
    if (waits) return;
    waits = true;
    requestAnimationFrame(() => {
      waits = false;
      drawNow();
    });
  }
  const turn = get("turn");
  const label = () => {
    turn.textContent = `Turn (${camera.up} is up)`;
    root.dataset.up = camera.up;
  };
  label();
  turn.addEventListener("click", () => {
    camera.up = camera.up === "z" ? "y" : "z";
    label();
    redraw();
  });
  get("reset").addEventListener("click", () => {
    camera.reset();
    redraw();
  });
  for (const id of ids) get(id).addEventListener("input", redraw);
  if (has3d) {
    for (const { canvas } of Object.values(views)) {
      steer(canvas, camera, redraw);
      new ResizeObserver(redraw).observe(canvas);
    }
  }
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  addEventListener("beforeprint", () => {
    for (const fold of document.querySelectorAll("details")) fold.open = true;
    drawNow();
  });
  /** Stores the drawn share of each canvas where a test can read it. */
  const measure = () => {
    for (const [id, view] of Object.entries(views)) if (view) get(id).dataset.drawn = view.share().toFixed(4);
  };
  return { views, has3d, redraw, drawNow, measure };
}
