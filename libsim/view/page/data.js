// @ts-check
'use strict';
// What the page is given: bytes, numbers, poses over time.

/** @type {string[]} */
const errors = [];
/** @param {unknown} what */
function fail(what) {
  errors.push(String(what));
  document.documentElement.dataset.errors = String(errors.length);
}
window.addEventListener('error', e => fail(e.message));
window.addEventListener('unhandledrejection', e => fail(e.reason));
document.documentElement.dataset.errors = '0';

/**
 * Element with attributes (`onclick` and the like are listeners) and children.
 * @param {string} tag
 * @param {Record<string, any>} [attributes]
 * @param {...any} children
 * @returns {any}
 */
function h(tag, attributes, ...children) {
  const e = document.createElement(tag);
  for (const [k, v] of Object.entries(attributes || {})) {
    if (k.startsWith('on')) e.addEventListener(k.slice(2), v);
    else if (k === 'class') e.className = v;
    else if (v !== null && v !== undefined && v !== false) e.setAttribute(k, v === true ? '' : v);
  }
  for (const c of children.flat(Infinity)) if (c !== null && c !== undefined && c !== false) e.append(c);
  return e;
}

/**
 * Digits without a tail of zeros; a dash for no number.
 * @param {number | null | undefined} v
 * @param {number} [digits]
 */
function text(v, digits = 4) {
  if (v === null || v === undefined || !isFinite(v)) return '\u2013';
  if (v === 0) return '0';
  const a = Math.abs(v);
  return a >= 1e6 || a < 1e-4 ? v.toExponential(digits - 1) : String(Number(v.toPrecision(digits)));
}

/** A length in mm, cm or m, whichever has the fewest digits. @param {number} m */
const lengthText = m => Math.abs(m) < 0.1 ? `${text(m * 1e3, 3)} mm` : `${text(m, 3)} m`;

/** @param {Packed} base64 @returns {Promise<Uint8Array>} */
async function unpack(base64) {
  if (typeof DecompressionStream === 'undefined') throw new Error('this browser cannot inflate: use one of 2023 or later');
  const bytes = Uint8Array.from(atob(base64), c => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}
/** @param {Packed | null} p */
const floats = async p => (p ? new Float32Array((await unpack(p)).buffer) : new Float32Array());
/** @param {Packed | null} p */
const words = async p => (p ? new Uint32Array((await unpack(p)).buffer) : new Uint32Array());
/** @param {Packed | null} p */
const doubles = async p => (p ? new Float64Array((await unpack(p)).buffer) : new Float64Array());

/** Of a coordinate: the sphere is not in this frame. */
const ABSENT = 65535;

/**
 * Positions of a frame: six planes of bytes, low and high byte of x, y and z, of the difference from the frame before
 * modulo 65536. A sphere that is not there has x = ABSENT.
 * @param {Uint8Array} bytes @param {Uint16Array | null} last
 */
function positionsOf(bytes, last) {
  const n = bytes.length / 6, now = new Uint16Array(3 * n);
  for (let axis = 0; axis < 3; ++axis)
    for (let i = 0; i < n; ++i)
      now[3 * i + axis] = (last ? last[3 * i + axis] : 0) + bytes[2 * axis * n + i] + 256 * bytes[(2 * axis + 1) * n + i];
  return now;
}

/** Index of the last time that is not after t, and the share of the way to the next. @param {ArrayLike<number>} times @param {number} t */
function bracket(times, t) {
  let low = 0, high = times.length - 1;
  if (high <= 0 || t <= times[0]) return { at: 0, share: 0 };
  if (t >= times[high]) return { at: high, share: 0 };
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle; else high = middle;
  }
  return { at: low, share: (t - times[low]) / (times[low + 1] - times[low]) };
}

/** Poses of bodies and of surfaces on a given path, between the samples linearly. */
class Poses {
  /** @param {Motion} motion @param {Float32Array} bodies @param {Float32Array} paths @param {number} count of bodies */
  constructor(motion, bodies, paths, count) {
    this.count = count;
    this.times = motion.times;
    this.bodies = bodies;
    this.paths = paths;
    this.pathCount = motion.paths.length;
  }
  /** @param {Motion} motion @param {Float32Array} bodies @param {Float32Array} paths */
  take(motion, bodies, paths) {
    this.times = motion.times;
    this.bodies = bodies;
    this.paths = paths;
    this.pathCount = motion.paths.length;
  }
  get end() { return this.times.length ? this.times[this.times.length - 1] : 0; }
  get begin() { return this.times.length ? this.times[0] : 0; }
  /** x, y, angle of a body. @param {number} body @param {number} t @returns {V3} */
  body(body, t) {
    const { at, share } = bracket(this.times, t), stride = 3 * this.count, i = at * stride + 3 * body;
    /** @param {number} k */
    const value = k => {
      const a = this.bodies[i + k];
      return share > 0 ? a + share * (this.bodies[i + stride + k] - a) : a;
    };
    return body === 0 || this.bodies.length === 0 ? [0, 0, 0] : [value(0), value(1), value(2)];
  }
  /** World place of a point of a body. @param {number} body @param {V2} p @param {number} t @returns {V2} */
  point(body, p, t) {
    const [x, y, angle] = this.body(body, t), c = Math.cos(angle), s = Math.sin(angle);
    return [x + c * p[0] - s * p[1], y + s * p[0] + c * p[1]];
  }
  /** @param {number} path @param {number} t */
  path(path, t) {
    const { at, share } = bracket(this.times, t), stride = 7 * this.pathCount, i = at * stride + 7 * path;
    const p = this.paths;
    const place = new THREE.Vector3(p[i], p[i + 1], p[i + 2]);
    const turn = new THREE.Quaternion(p[i + 4], p[i + 5], p[i + 6], p[i + 3]);
    if (share > 0) {
      const j = i + stride;
      place.lerp(new THREE.Vector3(p[j], p[j + 1], p[j + 2]), share);
      turn.slerp(new THREE.Quaternion(p[j + 4], p[j + 5], p[j + 6], p[j + 3]), share);
    }
    return { place, turn };
  }
}

// Colours that readers with any colour vision tell apart, after Okabe and Ito (2008).
const palette = ['#8a949e', '#2f7fc1', '#e07b39', '#2f9e77', '#c277b0', '#c9a227', '#5bb4e0', '#8d6e52', '#7b7be0', '#93a33a'];
/** @param {number} i */
const colourOf = i => i === 0 ? palette[0] : palette[1 + (i - 1) % (palette.length - 1)];

/** Stops of the colour scales, r g b. @type {Record<string, number[][]>} */
const SCALES = {
  speed: [[222, 218, 205], [148, 190, 190], [54, 140, 160], [38, 88, 150], [120, 40, 130], [200, 30, 60]],
  displacement: [[222, 218, 205], [240, 205, 120], [230, 140, 60], [190, 60, 40], [110, 20, 50]],
  depth: [[86, 56, 36], [140, 96, 60], [190, 150, 100], [226, 205, 160]],
  force: [[226, 226, 226], [150, 180, 210], [60, 110, 180], [90, 40, 140], [210, 30, 60]],
};
/** Colour at x in [0, 1]. @param {number[][]} stops @param {number} x */
function mixed(stops, x) {
  const at = Math.min(0.999999, Math.max(0, x)) * (stops.length - 1), k = Math.floor(at), f = at - k;
  return stops[k].map((v, c) => Math.round(v + f * (stops[k + 1][c] - v)));
}
/** @param {string} by */
const gradientOf = by => `linear-gradient(90deg,${(SCALES[by] || SCALES.depth).map(c => `rgb(${c.join(',')})`).join(',')})`;
