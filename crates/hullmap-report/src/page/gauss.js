// The unfolded cube map. Its unit is one face: the cross is 4 wide and 3 high.

const COLUMNS = 4, ROWS = 3;

class GaussView {
  constructor(canvas, faces, onPoint) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.faces = faces;
    this.onPoint = onPoint;
    this.colourBy = "vertex";
    this.showsCells = true;
    this.point = null;
    this.reset();
    this.steer();
  }

  reset() {
    this.zoom = 1;
    this.middle = [COLUMNS / 2, ROWS / 2];
  }

  /** Shows another map, or no map. */
  show(map) {
    this.point = null;
    this.reset();
    this.map = map;
    if (!map) return;
    if (!map.read) {
      const pixels = 6 * map.resolution ** 2;
      map.read = { vertices: runsOf(map.vertices, pixels), leaves: runsOf(map.leaves, pixels) };
      map.read.paths = this.paths(map);
    }
    this.paint();
  }

  /** Borders of the cells, one path per depth, in units of faces. */
  paths(map) {
    const ends = wordsOf(map.lines);
    const depths = runsOf(map.line_depths, ends.length / 4);
    const paths = new Map();
    let length = 0;
    for (let number = 0; number < 6; number++) {
      const [column, row] = this.faces[number].place;
      for (let line = map.line_starts[number]; line < map.line_starts[number + 1]; line++) {
        const [x0, y0, x1, y1] = ends.subarray(4 * line, 4 * line + 4);
        if (!paths.has(depths[line])) paths.set(depths[line], new Path2D());
        const path = paths.get(depths[line]);
        path.moveTo(column + x0 / 65535, row + 1 - y0 / 65535);
        path.lineTo(column + x1 / 65535, row + 1 - y1 / 65535);
        length += Math.hypot(x1 - x0, y1 - y0) / 65535;
      }
    }
    return { all: [...paths].sort(([a], [b]) => b - a), length };
  }

  /** Values that leaves are coloured by, with minimum and maximum. */
  scale() {
    const key = this.colourBy;
    const values = this.map.table.map((leaf) => leaf[key]);
    const low = Math.min(...values), high = Math.max(...values);
    return { values, low, high };
  }

  paint() {
    const { resolution, read } = this.map;
    const image = this.context.createImageData(COLUMNS * resolution, ROWS * resolution);
    const scale = this.colourBy === "vertex" ? null : this.scale();
    const colours = new Map();
    const colour = (pixel) => {
      const key = scale ? read.leaves[pixel] : read.vertices[pixel];
      if (!colours.has(key)) {
        const range = scale ? Math.max(scale.high - scale.low, 1) : 1;
        colours.set(key, scale ? scaleColour((scale.values[key] - scale.low) / range) : colourOf(key));
      }
      return colours.get(key);
    };
    this.faces.forEach(({ place: [column, row] }, number) => {
      for (let y = 0; y < resolution; y++) {
        for (let x = 0; x < resolution; x++) {
          const at = 4 * ((row * resolution + y) * image.width + column * resolution + x);
          const [red, green, blue] = colour((number * resolution + y) * resolution + x);
          image.data[at] = red;
          image.data[at + 1] = green;
          image.data[at + 2] = blue;
          image.data[at + 3] = 255;
        }
      }
    });
    this.picture = document.createElement("canvas");
    [this.picture.width, this.picture.height] = [image.width, image.height];
    this.picture.getContext("2d").putImageData(image, 0, 0);
    this.highlight = null;
  }

  /** Width of a face in pixels, and the top left corner of the cross. */
  place() {
    const { width, height } = this.canvas;
    const size = Math.min(width / COLUMNS, height / ROWS) * 0.97 * this.zoom;
    return { size, left: width / 2 - this.middle[0] * size, top: height / 2 - this.middle[1] * size };
  }

  draw() {
    const { canvas, context } = this;
    const scale = Math.min(devicePixelRatio || 1, 2);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((x) => Math.max(1, Math.round(x * scale)));
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, width, height);
    const soft = `rgb(${cssColour("--soft")})`;
    if (!this.map) {
      context.fillStyle = soft;
      context.font = `${15 * scale}px system-ui, sans-serif`;
      context.textAlign = "center";
      context.fillText("The map of this hull is not on the page.", width / 2, height / 2);
      return;
    }
    const { size, left, top } = this.place();
    context.setTransform(size, 0, 0, size, left, top);
    context.imageSmoothingEnabled = size * 1.5 < this.map.resolution;
    context.drawImage(this.picture, 0, 0, COLUMNS, ROWS);
    if (this.highlight) context.drawImage(this.highlight, 0, 0, COLUMNS, ROWS);
    if (this.showsCells) {
      // Dense lines are drawn paler, so that they darken the map by about a fifth.
      const pixel = scale / size;
      const cover = (this.map.read.paths.length * pixel) / 6;
      const opacity = Math.min(0.75, Math.max(0.05, 0.2 / cover));
      context.strokeStyle = `rgb(${cssColour("--cell").join(" ")} / ${opacity})`;
      for (const [depth, path] of this.map.read.paths.all) {
        context.lineWidth = pixel * (depth === 0 ? 1.1 : 0.8);
        context.stroke(path);
      }
    }
    this.faces.forEach(({ place: [column, row], name }) => {
      context.setTransform(1, 0, 0, 1, 0, 0);
      const [x, y] = [left + column * size, top + row * size];
      context.strokeStyle = soft;
      context.lineWidth = scale;
      context.strokeRect(x, y, size, size);
      context.font = `600 ${12 * scale}px system-ui, sans-serif`;
      context.textAlign = "left";
      context.textBaseline = "top";
      const [textX, textY] = [Math.max(x, 0) + 5 * scale, Math.max(y, 0) + 5 * scale];
      if (textX > x + size - 20 * scale || textY > y + size - 15 * scale) return;
      context.fillStyle = "rgb(255 255 255 / 0.8)";
      context.fillRect(textX - 3 * scale, textY - 3 * scale, context.measureText(name).width + 6 * scale, 17 * scale);
      context.fillStyle = "#222";
      context.fillText(name, textX, textY);
    });
    if (this.point) {
      const { face, x, y } = this.point;
      const [column, row] = this.faces[face].place;
      const [px, py] = [left + (column + x) * size, top + (row + y) * size];
      for (const [colour, line] of [["#fff", 4], ["#000", 1.6]]) {
        context.strokeStyle = colour;
        context.lineWidth = line * scale;
        context.beginPath();
        context.arc(px, py, 6 * scale, 0, 2 * Math.PI);
        context.stroke();
      }
    }
  }

  /** Share of pixels that were drawn, and the number of colours. */
  share() {
    // Read a copy: after reading the canvas itself, browsers draw it more slowly.
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [this.canvas.width, this.canvas.height];
    const context = copy.getContext("2d", { willReadFrequently: true });
    context.drawImage(this.canvas, 0, 0);
    const { data } = context.getImageData(0, 0, copy.width, copy.height);
    let drawn = 0;
    const colours = new Set();
    for (let i = 0; i < data.length; i += 4) {
      if (data[i + 3] === 0) continue;
      drawn++;
      colours.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
    }
    return { drawn: (4 * drawn) / data.length, colours: colours.size };
  }

  /** Face and point on it at a point of the cross; null outside. */
  find(column, row) {
    const face = this.faces.findIndex(({ place }) => place[0] === Math.floor(column) && place[1] === Math.floor(row));
    return face < 0 ? null : { face, x: column - Math.floor(column), y: row - Math.floor(row) };
  }

  /** Direction, vertex and leaf at a point of a face. */
  read({ face, x, y }) {
    const { resolution, read, table } = this.map;
    const [column, row] = [x, y].map((c) => Math.min(Math.floor(c * resolution), resolution - 1));
    const pixel = (face * resolution + row) * resolution + column;
    const { middle, right, up } = this.faces[face];
    const at = (c) => ((c + 0.5) / resolution) * 2 - 1;
    const dir = middle.map((c, axis) => c + at(column) * right[axis] - at(row) * up[axis]);
    const length = Math.hypot(...dir);
    return { dir: dir.map((c) => c / length), vertex: read.vertices[pixel], leaf: table[read.leaves[pixel]] };
  }

  choose(point) {
    this.point = point;
    if (point && this.map) {
      const found = this.read(point);
      this.lighten(found.vertex);
      this.onPoint(found);
    } else {
      this.highlight = null;
      this.onPoint(null);
    }
    this.draw();
  }

  /** Highlights the directions of one vertex. */
  lighten(vertex) {
    const { resolution, read } = this.map;
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [COLUMNS * resolution, ROWS * resolution];
    const context = canvas.getContext("2d");
    const image = context.createImageData(canvas.width, canvas.height);
    this.faces.forEach(({ place: [column, row] }, number) => {
      for (let y = 0; y < resolution; y++) {
        for (let x = 0; x < resolution; x++) {
          if (read.vertices[(number * resolution + y) * resolution + x] !== vertex) continue;
          const at = 4 * ((row * resolution + y) * canvas.width + column * resolution + x);
          image.data.set([255, 255, 255, 150], at);
        }
      }
    });
    context.putImageData(image, 0, 0);
    this.highlight = canvas;
  }

  grow(factor, [x, y] = [this.canvas.width / 2, this.canvas.height / 2]) {
    const { size, left, top } = this.place();
    const under = [(x - left) / size, (y - top) / size];
    this.zoom = Math.min(Math.max(this.zoom * factor, 1), 64);
    if (this.zoom === 1) {
      this.reset();
    } else {
      const now = this.place();
      const shift = [left + under[0] * size - (now.left + under[0] * now.size), top + under[1] * size - (now.top + under[1] * now.size)];
      this.middle = this.middle.map((c, axis) => c - shift[axis] / now.size);
    }
    // One finger scrolls the page while the whole map is visible, and moves the map otherwise.
    this.canvas.style.touchAction = this.zoom > 1 ? "none" : "pan-y";
    this.draw();
  }

  steer() {
    const { canvas } = this;
    canvas.style.touchAction = "pan-y";
    let drag = null;
    const pixels = (event) => {
      const box = canvas.getBoundingClientRect();
      return [((event.clientX - box.left) / box.width) * canvas.width, ((event.clientY - box.top) / box.height) * canvas.height];
    };
    const pointAt = (event) => {
      if (!this.map) return;
      const { size, left, top } = this.place();
      const [x, y] = pixels(event);
      this.choose(this.find((x - left) / size, (y - top) / size));
    };
    canvas.addEventListener("pointerdown", (event) => {
      drag = pixels(event);
      canvas.setPointerCapture(event.pointerId);
      pointAt(event);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (drag && this.zoom > 1 && event.buttons) {
        const now = pixels(event);
        const { size } = this.place();
        this.middle = this.middle.map((c, axis) => c - (now[axis] - drag[axis]) / size);
        drag = now;
      }
      pointAt(event);
    });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => (drag = null));
    canvas.addEventListener("pointerleave", (event) => {
      if (event.pointerType === "mouse" && document.activeElement !== canvas) this.choose(null);
    });
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas && !event.ctrlKey) return;
      event.preventDefault();
      this.grow(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.002)), pixels(event));
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      if (!this.map || event.altKey || event.metaKey || event.ctrlKey) return;
      const step = (event.shiftKey ? 10 : 1) / this.map.resolution;
      const move = (right, down) => {
        const { face, x, y } = this.point || { face: 2, x: 0.5, y: 0.5 };
        const [column, row] = this.faces[face].place;
        const found = this.find(column + x + right * step, row + y + down * step);
        if (found) this.choose(found);
      };
      const keys = {
        ArrowLeft: () => move(-1, 0),
        ArrowRight: () => move(1, 0),
        ArrowUp: () => move(0, -1),
        ArrowDown: () => move(0, 1),
        "+": () => this.grow(1.3),
        "=": () => this.grow(1.3),
        "-": () => this.grow(1 / 1.3),
        Home: () => (this.reset(), this.grow(1)),
        Escape: () => this.choose(null),
      };
      if (keys[event.key]) {
        event.preventDefault();
        keys[event.key]();
      }
    });
  }
}
