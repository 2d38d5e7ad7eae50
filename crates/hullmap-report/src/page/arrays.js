// Decodes arrays of numbers in the page's text.

function bytesOf(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** Little-endian 16-bit numbers, on machines of either byte order. */
function wordsOf(text) {
  const bytes = bytesOf(text);
  const words = new Uint16Array(bytes.length / 2);
  for (let i = 0; i < words.length; i++) words[i] = bytes[2 * i] | (bytes[2 * i + 1] << 8);
  return words;
}

/** Run-length encoding: pairs of a count and a difference, seven bits per byte. */
function runsOf(text, length) {
  const bytes = bytesOf(text);
  const numbers = new Uint32Array(length);
  let at = 0, filled = 0, value = 0;
  const next = () => {
    let number = 0, factor = 1, byte;
    do {
      byte = bytes[at++];
      number += (byte & 127) * factor;
      factor *= 128;
    } while (byte & 128);
    return number;
  };
  while (at < bytes.length) {
    const count = next();
    const change = next();
    value += change % 2 ? -(change + 1) / 2 : change / 2;
    numbers.fill(value, filled, filled + count);
    filled += count;
  }
  return numbers;
}

/** A mesh with its corners in source units. */
function meshOf(shown) {
  const scaled = wordsOf(shown.points);
  const points = new Float32Array(scaled.length);
  for (let i = 0; i < scaled.length; i++) points[i] = shown.low[i % 3] + (scaled[i] / 65535) * shown.size[i % 3];
  const place = shown.numbers.length ? new Map(shown.numbers.map((number, at) => [number, at])) : null;
  return {
    points,
    triangles: wordsOf(shown.triangles),
    edges: wordsOf(shown.edges),
    low: shown.low,
    size: shown.size,
    shown: shown.shown,
    whole: shown.whole,
    corners: shown.corners,
    /** Decimal places that 16-bit coordinates resolve. */
    digits: Math.min(Math.max(Math.ceil(-Math.log10(Math.max(...shown.size, 1e-30) / 32768)), 0), 20),
    /** Position of vertex `number`; null if it is not on the page. */
    vertex(number) {
      const at = place ? place.get(number) : number;
      return at === undefined || 3 * at >= points.length ? null : [...points.subarray(3 * at, 3 * at + 3)];
    },
    /** Vertex index of corner `at`. */
    number: (at) => (shown.numbers.length ? shown.numbers[at] : at),
  };
}

// Colours.

/** OKLCH to sRGB bytes; hue in turns. */
function oklch(lightness, chroma, hue) {
  const a = chroma * Math.cos(2 * Math.PI * hue), b = chroma * Math.sin(2 * Math.PI * hue);
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const linear = [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
  return linear.map((x) => {
    const c = Math.min(Math.max(x, 0), 1);
    return Math.round(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));
  });
}

/** A colour for a vertex or hull: consecutive indices have distant hues. */
function colourOf(number) {
  const hue = (number * 0.61803398875) % 1;
  const step = (number * 0.7548776662) % 1;
  return oklch(0.64 + 0.24 * step, 0.05 + 0.06 * ((number * 0.5698402909) % 1), hue);
}

/** A colour scale from 0 to 1: pale to deep. */
function scaleColour(share) {
  return oklch(0.93 - 0.55 * share, 0.05 + 0.09 * Math.min(share * 2, 2 - 1.2 * share), 0.72 - 0.12 * share);
}

function cssColour(name) {
  const text = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  return [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16));
}

function grouped(number) {
  return String(number).replace(/\B(?=(\d{3})+(?!\d))/g, "\u202f");
}

function short(number) {
  const text = number === 0 ? "0" : Number(number.toPrecision(4)).toString();
  return text.replace("-", "−");
}
