// The motion of body B from one pose to another: when it first meets A, and a slider through it.

/** Rotations about x, then y, then z, in degrees, of a unit quaternion x y z w. */
function anglesOf([x, y, z, w]) {
  const degrees = (angle) => (angle * 180) / Math.PI;
  const sine = Math.min(Math.max(2 * (w * y - x * z), -1), 1);
  return [
    degrees(Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))),
    degrees(Math.asin(sine)),
    degrees(Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))),
  ];
}

/** The section of the page about the motion. `move` is called with the pose that the slider shows. */
class MotionSection {
  constructor({ get, digits, move }) {
    Object.assign(this, { get, digits, found: null, start: null, end: null, pair: null });
    this.slider = get("time");
    const go = () => this.start && move([...wasm_bindgen.interpolatePoses(this.start, this.end, this.slider.valueAsNumber)]);
    this.slider.addEventListener("input", go);
    get("to-contact").addEventListener("click", () => {
      // Up to the lower bound, so that the bodies are still apart.
      if (this.found && this.found.hit) this.slider.value = String(this.found.tLower);
      go();
    });
  }

  /** Takes a pose as the start or the end of the motion. */
  take(which, numbers) {
    this[which] = numbers;
    this.slider.value = which === "start" ? "0" : "1";
    this.solve();
  }

  /** A first motion for two bodies: past or through A, while B turns by two thirds of a half turn. */
  begin(pair, a, b) {
    const reach = 1.15 * (a.radius + b.radius), height = 0.35 * a.radius;
    const at = (x, turn) => new Float64Array([...plus(plus(a.centre, [x, 0, height]), b.centre, -1), ...quaternionOf(turn)]);
    [this.pair, this.start, this.end] = [pair, at(reach, [0, 0, 0]), at(-reach, [40, 0, 120])];
    this.slider.value = "0";
    this.solve();
  }

  solve() {
    const { get, digits } = this;
    const mark = get("impact"), place = get("motion-answer");
    this.pair.forget();
    const found = (this.found = this.pair.castMotion(this.start, this.end));
    const { hit, status, t, tLower, tUpper, iterations } = found;
    mark.hidden = !hit;
    get("to-contact").disabled = !hit;
    if (hit) {
      const end = Math.min(tUpper, 1);
      // At least two pixels wide.
      [mark.style.left, mark.style.width] = [`${100 * tLower}%`, `max(2px, ${100 * (end - tLower)}%)`];
    }
    const width = (tUpper - tLower).toExponential(1).replace("-", "−");
    const until = Number.isFinite(tUpper) ? `to ${digits(tUpper, 9)}, width ${width}` : "on";
    if (!hit) place.textContent = `B does not meet A at any time from 0 to 1. ${iterations} distance queries.`;
    else if (status === "overlapping") place.textContent = "The bodies overlap at the start.";
    else place.textContent = `First contact at t = ${digits(t, 6)}. Interval ${digits(tLower, 9)} ${until}. ${iterations} distance queries.`;
    place.dataset.answer = JSON.stringify({ start: [...this.start], end: [...this.end], hit, status, t, tLower, tUpper: hit ? Math.min(tUpper, 2) : null });
  }

  /** Draws B, its points and its normal at the contact. */
  draw(view, shape, size, { ghost, colour }) {
    const { found } = this;
    if (!found || !found.hit) return;
    const model = matrixOf(wasm_bindgen.interpolatePoses(this.start, this.end, found.tLower));
    view.edges(shape, { model, colour: ghost, opacity: 0.25 });
    const near = { colour, forward: 1 }, from = [...found.pointA];
    view.loose("lines", [from, plus(from, found.normal, 2 * size)], near);
    view.loose("points", [from, [...found.pointB]], { ...near, size: 9 });
  }
}
