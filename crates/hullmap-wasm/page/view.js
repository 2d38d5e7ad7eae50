// A 3D view: matrices, a camera, and a small WebGL2 renderer.

// Matrices are in column order, as WebGL takes them. Vectors are arrays of three.

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const plus = (a, b, factor = 1) => a.map((c, axis) => c + factor * b[axis]);
const IDENTITY = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);

/** Quaternion x y z w of rotations about x, then y, then z, in degrees. */
function quaternionOf([x, y, z]) {
  const half = (angle) => (angle * Math.PI) / 360;
  const [sx, sy, sz] = [x, y, z].map((angle) => Math.sin(half(angle)));
  const [cx, cy, cz] = [x, y, z].map((angle) => Math.cos(half(angle)));
  return [
    sx * cy * cz - cx * sy * sz,
    cx * sy * cz + sx * cy * sz,
    cx * cy * sz - sx * sy * cz,
    cx * cy * cz + sx * sy * sz,
  ];
}

/** Matrix of a pose: translation and unit quaternion. */
function matrixOf([tx, ty, tz, x, y, z, w]) {
  return new Float32Array([
    1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0,
    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0,
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0,
    tx, ty, tz, 1,
  ]);
}

const transform = (m, p) => [0, 1, 2].map((row) => m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row]);

/** Where the viewer stands; z is up. Angles in radians. */
class Camera {
  constructor() {
    [this.centre, this.radius] = [[0, 0, 0], 1];
    this.reset();
  }

  reset() {
    [this.yaw, this.pitch, this.zoom] = [-0.9, 0.45, 1];
  }

  turn(yaw, pitch) {
    this.yaw += yaw;
    this.pitch = Math.min(Math.max(this.pitch + pitch, -1.55), 1.55);
  }

  grow(factor) {
    this.zoom = Math.min(Math.max(this.zoom * factor, 0.2), 30);
  }

  /** Right, up and towards the viewer, in the world. */
  get axes() {
    const [sy, cy, sp, cp] = [Math.sin(this.yaw), Math.cos(this.yaw), Math.sin(this.pitch), Math.cos(this.pitch)];
    return [[-sy, cy, 0], [-cy * sp, -sy * sp, cp], [cy * cp, sy * cp, sp]];
  }

  get away() {
    return (2.5 * this.radius) / this.zoom;
  }

  get eye() {
    return plus(this.centre, this.axes[2], this.away);
  }

  get toView() {
    const [eye, axes] = [this.eye, this.axes];
    return new Float32Array([0, 1, 2].flatMap((axis) => [...axes.map((row) => row[axis]), 0]).concat(axes.map((row) => -dot(row, eye)), 1));
  }

  /** Half the height of the picture at distance 1. */
  lens(aspect) {
    return 0.36 * Math.max(1, 1 / aspect);
  }

  toClip(aspect) {
    const lens = 1 / this.lens(aspect);
    const near = this.away / 50, far = this.away + 20 * this.radius;
    const depth = near - far;
    return new Float32Array([lens / aspect, 0, 0, 0, 0, lens, 0, 0, 0, 0, (far + near) / depth, -1, 0, 0, (2 * far * near) / depth, 0]);
  }

  /** Direction from the eye through a point of the picture, each coordinate −1 to 1. */
  ray([x, y], aspect) {
    const [right, up, back] = this.axes, lens = this.lens(aspect);
    return plus(plus(back.map((c) => -c), right, x * lens * aspect), up, y * lens);
  }
}

/** Distance along a ray to the nearest triangle of a mesh under a pose; infinite without a hit. */
function rayTo(mesh, matrix, from, along) {
  const points = [];
  for (let i = 0; i < mesh.points.length; i += 3) points.push(transform(matrix, mesh.points.subarray(i, i + 3)));
  let nearest = Infinity;
  for (let i = 0; i < mesh.triangles.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((corner) => points[mesh.triangles[i + corner]]);
    const [u, v] = [plus(b, a, -1), plus(c, a, -1)];
    const p = cross(along, v), volume = dot(u, p);
    if (volume === 0) continue;
    const s = plus(from, a, -1), share = dot(s, p) / volume;
    const q = cross(s, u), other = dot(along, q) / volume, t = dot(v, q) / volume;
    if (share >= 0 && other >= 0 && share + other <= 1 && t > 0) nearest = Math.min(nearest, t);
  }
  return nearest;
}

const SHADERS = {
  // The flat triangle's normal, from screen-space derivatives. Both sides are lit.
  triangles: [
    `#version 300 es
    in vec3 corner; uniform mat4 model; uniform mat4 toView; uniform mat4 toClip; out vec3 seen;
    void main() { vec4 at = toView * model * vec4(corner, 1.0); seen = at.xyz; gl_Position = toClip * at; }`,
    `#version 300 es
    precision highp float; in vec3 seen; uniform vec3 colour; uniform float opacity; out vec4 shown;
    void main() {
      vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
      normal *= sign(normal.z + 1e-9);
      float lit = 0.42 + 0.5 * max(dot(normal, normalize(vec3(-0.36, 0.6, 0.71))), 0.0) + 0.14 * normal.z;
      shown = vec4(colour * min(lit, 1.06) * opacity, opacity);
    }`,
  ],
  lines: [
    `#version 300 es
    in vec3 corner; uniform mat4 model; uniform mat4 toView; uniform mat4 toClip; uniform float forward; uniform float size;
    void main() {
      gl_Position = toClip * toView * model * vec4(corner, 1.0);
      gl_Position.z -= forward * gl_Position.w;
      gl_PointSize = size;
    }`,
    `#version 300 es
    precision highp float; uniform vec3 colour; uniform float opacity; uniform bool round; out vec4 shown;
    void main() {
      if (round && length(gl_PointCoord - 0.5) > 0.5) discard;
      shown = vec4(colour * opacity, opacity);
    }`,
  ],
};

/** A canvas that draws meshes. */
class View extends Surface {
  constructor(canvas, gl) {
    super(canvas, gl);
    gl.polygonOffset(1, 2);
    this.triangleProgram = new Program(gl, SHADERS.triangles);
    this.lineProgram = new Program(gl, SHADERS.lines);
    // Buffers of each mesh, and one for what changes with every frame.
    this.uploads = new Map();
    this.scratch = gl.createBuffer();
    this.camera = null;
  }

  /** Clears the picture, which is then seen by this camera. */
  begin(camera) {
    this.camera = camera;
    this.clear();
  }

  /**
   * Translucent triangles show their front sides only, and hide nothing. Opaque ones are moved back
   * a little: the faces of a hull lie in the faces of its mesh, and would show through in patches.
   */
  triangles(mesh, look) {
    if (!mesh.triangles.length) return;
    const { gl } = this, upload = this.uploaded(mesh), isClear = (look.opacity ?? 1) < 1;
    this.use(this.triangleProgram, look);
    this.bindCorners(upload.points);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, upload.triangles);
    gl.depthMask(!isClear);
    gl.enable(isClear ? gl.CULL_FACE : gl.POLYGON_OFFSET_FILL);
    gl.drawElements(gl.TRIANGLES, mesh.triangles.length, gl.UNSIGNED_INT, 0);
    gl.disable(isClear ? gl.CULL_FACE : gl.POLYGON_OFFSET_FILL);
    gl.depthMask(true);
  }

  edges(mesh, look) {
    if (!mesh.edges.length) return;
    const { gl } = this, upload = this.uploaded(mesh);
    this.useLines(look);
    this.bindCorners(upload.points);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, upload.edges);
    gl.drawElements(gl.LINES, mesh.edges.length, gl.UNSIGNED_INT, 0);
  }

  cloud(mesh, look) {
    this.useLines(look);
    this.bindCorners(this.uploaded(mesh).points);
    this.gl.drawArrays(this.gl.POINTS, 0, mesh.points.length / 3);
  }

  /** Points or lines that change with every frame. */
  loose(kind, points, look) {
    if (!points.length) return;
    const { gl } = this;
    this.useLines(look);
    this.bindCorners(this.scratch);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(points.flat()), gl.STREAM_DRAW);
    gl.drawArrays(kind === "lines" ? gl.LINES : gl.POINTS, 0, points.length);
  }

  /** Deletes the buffers of a mesh. */
  forget(mesh) {
    for (const buffer of Object.values(this.uploads.get(mesh) || {})) if (buffer) this.gl.deleteBuffer(buffer);
    this.uploads.delete(mesh);
  }

  /** Waits until everything is drawn, for measurements. */
  finish() {
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  /** Buffers of a mesh. */
  uploaded(mesh) {
    if (!this.uploads.has(mesh)) {
      this.uploads.set(mesh, {
        points: this.corners(mesh.points),
        triangles: mesh.triangles && this.indices(mesh.triangles),
        edges: mesh.edges && this.indices(mesh.edges),
      });
    }
    return this.uploads.get(mesh);
  }

  use(program, { model = IDENTITY, colour, opacity = 1 }) {
    const { gl, camera } = this;
    program.use();
    gl.uniformMatrix4fv(program.location("model"), false, model);
    gl.uniformMatrix4fv(program.location("toView"), false, camera.toView);
    gl.uniformMatrix4fv(program.location("toClip"), false, camera.toClip(this.aspect));
    gl.uniform3f(program.location("colour"), ...colour.map((c) => c / 255));
    gl.uniform1f(program.location("opacity"), opacity);
  }

  useLines(look) {
    const { gl, lineProgram } = this;
    this.use(lineProgram, look);
    gl.uniform1f(lineProgram.location("forward"), look.forward ?? 0.0004);
    gl.uniform1f(lineProgram.location("size"), (look.size ?? 1) * Math.max(1, devicePixelRatio || 1));
    gl.uniform1i(lineProgram.location("round"), look.size ? 1 : 0);
  }
}

/** Null where there is no WebGL2. */
function openView(canvas) {
  const gl = Surface.context(canvas);
  return gl && new View(canvas, gl);
}
