// A canvas that is drawn on with WebGL2: its programs and buffers. Reports and the page of the npm
// package draw different things on it.

/** A vertex and a fragment shader. */
class Program {
  constructor(gl, [vertex, fragment]) {
    this.gl = gl;
    this.linked = gl.createProgram();
    this.locations = new Map();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(this.linked, shader);
    }
    gl.bindAttribLocation(this.linked, 0, "corner");
    gl.bindAttribLocation(this.linked, 1, "tint");
    gl.linkProgram(this.linked);
  }

  use() {
    this.gl.useProgram(this.linked);
  }

  /** Location of a uniform. */
  location(name) {
    if (!this.locations.has(name)) this.locations.set(name, this.gl.getUniformLocation(this.linked, name));
    return this.locations.get(name);
  }
}

/** A canvas with depth and opacity. */
class Surface {
  /** `null` where there is no WebGL2. */
  static context(canvas) {
    return canvas.getContext("webgl2", { antialias: true, alpha: true, preserveDrawingBuffer: true });
  }

  constructor(canvas, gl) {
    this.canvas = canvas;
    this.gl = gl;
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.enableVertexAttribArray(0);
  }

  get aspect() {
    return this.canvas.width / this.canvas.height;
  }

  /** An empty picture, as large as the canvas is on the screen. */
  clear() {
    const { canvas, gl } = this;
    const scale = Math.min(devicePixelRatio || 1, 2);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((x) => Math.max(1, Math.round(x * scale)));
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  /** A new buffer of corners or tints. */
  corners(data) {
    return this.buffer(this.gl.ARRAY_BUFFER, data);
  }

  /** A new buffer of indices of corners. */
  indices(data) {
    return this.buffer(this.gl.ELEMENT_ARRAY_BUFFER, data);
  }

  buffer(kind, data) {
    const made = this.gl.createBuffer();
    this.gl.bindBuffer(kind, made);
    this.gl.bufferData(kind, data, this.gl.STATIC_DRAW);
    return made;
  }

  /** Draws the corners of this buffer from now on. */
  bindCorners(buffer) {
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, buffer);
    this.gl.vertexAttribPointer(0, 3, this.gl.FLOAT, false, 0, 0);
  }

  /** Share of the pixels that anything was drawn on. */
  share() {
    const { canvas, gl } = this;
    const pixels = new Uint8Array(4 * canvas.width * canvas.height);
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    let drawn = 0;
    for (let i = 3; i < pixels.length; i += 4) drawn += pixels[i] > 0 ? 1 : 0;
    return (4 * drawn) / pixels.length;
  }
}
