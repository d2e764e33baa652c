// @ts-check
'use strict';
// Spheres as impostors: a square facing the camera per sphere, on which the fragment shader draws the sphere with its
// depth. Four vertices each, whatever the zoom; a section plane cuts it as the solid that it is.

const SPHERE_VERTEX = `
attribute vec3 place;
attribute float radius;
attribute float shade;
uniform vec3 low, size;
uniform float scale;
varying vec2 corner;
varying float shadeOf, radiusOf;
varying vec3 centre;
void main() {
  corner = position.xy;
  shadeOf = shade;
  radiusOf = radius * scale;
  if (place.x > 0.999999) radiusOf = 0.0;
  centre = (modelViewMatrix * vec4(low + place * size * (65535.0 / 65534.0), 1.0)).xyz;
  gl_Position = projectionMatrix * vec4(centre + vec3(position.xy * radiusOf, 0.0), 1.0);
}`;
const SPHERE_FRAGMENT = `
precision highp float;
uniform mat4 projectionMatrix;
uniform vec4 cut;        // view axes: what has dot(n, p) > w is cut off
uniform float cutting;
uniform sampler2D colours;
uniform vec3 plain;
uniform float fade;
varying vec2 corner;
varying float shadeOf, radiusOf;
varying vec3 centre;
void main() {
  float r2 = dot(corner, corner);
  if (r2 > 1.0 || radiusOf <= 0.0) discard;
  vec3 normal = vec3(corner, sqrt(1.0 - r2));
  vec3 p = centre + radiusOf * normal;
  float flat_ = 0.0;
  if (cutting > 0.5 && dot(cut.xyz, p) > cut.w) {
    // The ray goes on along -z to the plane: what it meets there inside the sphere is its cut face.
    if (cut.z <= 0.02) discard;
    p.z -= (dot(cut.xyz, p) - cut.w) / cut.z;
    if (distance(p, centre) > radiusOf) discard;
    normal = cut.xyz;
    flat_ = 1.0;
  }
  vec4 clip = projectionMatrix * vec4(p, 1.0);
  gl_FragDepth = 0.5 * clip.z / clip.w + 0.5;
  vec3 base = shadeOf < 0.0 ? plain : texture2D(colours, vec2(clamp(shadeOf, 0.0, 1.0) * (255.0 / 256.0) + 0.5 / 256.0, 0.5)).rgb;
  float light = 0.42 + 0.58 * max(0.0, dot(normal, normalize(vec3(0.35, 0.55, 0.75))));
  gl_FragColor = vec4(base * mix(light, 0.92, flat_ * 0.6), fade);
}`;

const SOIL_COLOUR = '#b9a582', PALE_SOIL = '#ece8df';

/** Frames of a served run that stay in memory; 1,000,000 spheres take 8 MB each. */
const MOST_KEPT = 40;
/** @typedef {{ positions: Uint16Array, speed: Uint8Array | null, force: Uint8Array | null, chains: Float32Array | null, travelled: number }} FrameData */

class Soil {
  /** @param {Spheres} data @param {{ radius: Uint8Array | null, material: Uint8Array | null }} table */
  constructor(data, table) {
    this.data = data;
    this.table = table;
    /** Spheres of the frames that are here. @type {(FrameData | null)[]} */
    this.frames = data.frames.map(() => null);
    /** Gets a frame that is not here; null: all are. @type {((frame: number) => Promise<SphereFrame>) | null} */
    this.reader = null;
    /** Called when a frame that was waited for is shown. */
    this.arrived = () => {};
    this.wanted = 0;
    /** Frames that have come later, oldest first. @type {number[]} */
    this.kept = [];
    this.frame = -1;
    this.colouring = 'plain';
    this.times = data.frames.map(f => f.time);
    this.size = this.sizeOfBox();
    this.radii = new Float32Array(data.count);
    const r = data.radius;
    for (let i = 0; i < data.count; ++i)
      this.radii[i] = table.radius ? r.low + (r.high - r.low) * table.radius[i] / 255 : r.high;
    /** Quantised place of each sphere where it was seen first: depth and displacement count from there. */
    this.first = new Uint16Array(3 * data.count).fill(ABSENT);
    this.shades = new Float32Array(data.count).fill(-1);
    this.top = 1;
    this.place = new THREE.InstancedBufferAttribute(new Uint16Array(3 * data.count), 3, true);
    this.shade = new THREE.InstancedBufferAttribute(this.shades, 1);
    this.colours = new THREE.DataTexture(new Uint8Array(256 * 4), 256, 1);
    this.material = this.shader();
    this.mesh = this.build();
    this.chains = new Chains(this.radii.reduce((sum, r) => sum + r, 0) / Math.max(1, data.count), data.chainTop);
    this.showChains(false);
  }
  /** Opens all frames that the page holds, or fetches the first. @param {Spheres} data @param {((frame: number) => Promise<SphereFrame>) | null} reader */
  static async open(data, reader) {
    const bytes = async (/** @type {Packed | null} */ p) => (p ? unpack(p) : null);
    const soil = new Soil(data, { radius: await bytes(data.radius.bytes), material: await bytes(data.material) });
    soil.reader = reader;
    if (reader) await soil.take(0, await reader(0));
    let last = null;
    for (let k = 0; !reader && k < data.frames.length; ++k) last = soil.put(k, await soil.opened(data.frames[k], last)).positions;
    soil.show(0);
    return soil;
  }
  /** @param {SphereFrame} frame @param {Uint16Array | null} last @returns {Promise<FrameData>} */
  async opened(frame, last) {
    const bytes = async (/** @type {Packed | undefined} */ p) => (p ? unpack(p) : null);
    return { positions: positionsOf(await unpack(frame.position || ''), last), speed: await bytes(frame.speed), force: await bytes(frame.force),
      chains: frame.chains ? await floats(frame.chains) : null, travelled: frame.travelled || 0 };
  }
  /** @param {number} k @param {FrameData} frame */
  put(k, frame) {
    const p = frame.positions, first = this.first;
    for (let i = 0; i < p.length; i += 3)
      if (first[i] === ABSENT && p[i] !== ABSENT) first[i] = p[i], first[i + 1] = p[i + 1], first[i + 2] = p[i + 2];
    this.frames[k] = frame;
    return frame;
  }
  /** A frame that has come later. Its box is that of all so far: where it has grown, what is here has other coordinates.
   * @param {number} k @param {SphereFrame} frame */
  async take(k, frame) {
    const data = this.data, low = frame.low || data.low, high = frame.high || data.high;
    if ([0, 1, 2].some(i => low[i] !== data.low[i] || high[i] !== data.high[i])) {
      Object.assign(data, { low, high, error: frame.error || data.error });
      this.size = this.sizeOfBox();
      this.material.uniforms.low.value.set(...low);
      this.material.uniforms.size.value.set(...this.size);
      this.frames.fill(null);
      this.kept = [];
      this.frame = -1;
      this.first.fill(ABSENT);
      if (k !== 0 && this.reader) await this.take(0, await this.reader(0));
    }
    this.put(k, await this.opened(frame, null));
    this.span = undefined;
    this.kept.push(k);
    // The first is what displacements count from.
    const oldest = this.kept.length > MOST_KEPT ? this.kept.find(f => f !== 0 && f !== k && f !== this.frame) : undefined;
    if (oldest !== undefined) this.frames[oldest] = null, this.kept = this.kept.filter(f => f !== oldest);
  }
  /** Frames that a run has written meanwhile. @param {number[]} times of all */
  extend(times) {
    for (const time of times.slice(this.times.length)) this.data.frames.push({ time }), this.times.push(time), this.frames.push(null);
  }
  sizeOfBox() { return /** @type {V3} */ (this.data.high.map((v, i) => Math.max(v - this.data.low[i], 1e-9))); }
  /** The frame that is shown. @returns {FrameData} */
  get now() { return /** @type {FrameData} */ (this.frames[this.frame]); }
  build() {
    const geometry = new THREE.InstancedBufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0]), 3));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    geometry.setAttribute('place', this.place);
    geometry.setAttribute('shade', this.shade);
    geometry.setAttribute('radius', new THREE.InstancedBufferAttribute(this.radii, 1));
    geometry.instanceCount = this.data.count;
    const mesh = new THREE.Mesh(geometry, this.material);
    mesh.frustumCulled = false;
    return mesh;
  }
  shader() {
    return new THREE.ShaderMaterial({
      vertexShader: SPHERE_VERTEX, fragmentShader: SPHERE_FRAGMENT,
      uniforms: {
        low: { value: new THREE.Vector3(...this.data.low) }, size: { value: new THREE.Vector3(...this.size) },
        scale: { value: 1 }, cut: { value: new THREE.Vector4() }, cutting: { value: 0 }, colours: { value: this.colours },
        plain: { value: new THREE.Vector3() },
        fade: { value: 1 },
      },
    });
  }
  /** @param {number} time */
  showTime(time) {
    const { at, share } = bracket(this.times, time), k = share > 0.5 ? at + 1 : at;
    this.wanted = k;
    if (this.frames[k]) this.show(k);
    else this.load(k).catch(fail);
  }
  /** One frame at a time: of a slider that is drawn the last place counts. @param {number} k */
  async load(k) {
    if (this.loading || !this.reader) return;
    this.loading = true;
    try {
      await this.take(k, await this.reader(k));
    } finally {
      this.loading = false;
    }
    if (this.wanted === k || this.frame < 0) this.show(k), this.arrived();
    if (!this.frames[this.wanted]) await this.load(this.wanted);
  }
  /** @param {number} frame */
  show(frame) {
    if (frame === this.frame) return;
    this.frame = frame;
    document.documentElement.dataset.frame = String(frame);
    this.place.array.set(this.now.positions);
    this.place.needsUpdate = true;
    this.colour(this.colouring);
    this.chains.show(this.now.chains);
  }
  /** Chains are seen before pale spheres. @param {boolean} on */
  showChains(on) {
    this.chains.mesh.visible = on;
    this.material.uniforms.plain.value.set(...[1, 3, 5].map(k => parseInt((on ? PALE_SOIL : SOIL_COLOUR).slice(k, k + 2), 16) / 255));
  }
  get hasChains() { return this.frames.some(f => f && f.chains && f.chains.length > 0); }
  /** Names of what the spheres can be coloured by here. */
  colourings() {
    const out = ['plain', 'depth'];
    if (this.table.material && this.table.material.some((m, i, all) => m !== all[0])) out.push('material');
    if (this.frames.length > 1) out.push('displacement');
    if (this.frames.some(f => f && f.speed)) out.push('speed');
    if (this.frames.some(f => f && f.force)) out.push('force');
    return out;
  }
  /** @param {string} by */
  colour(by) {
    this.colouring = by;
    const n = this.data.count, now = this.now.positions, first = this.first, shades = this.shades;
    this.top = 1;
    if (by === 'plain') shades.fill(-1);
    else if (by === 'depth') for (let i = 0; i < n; ++i) shades[i] = first[3 * i + 1] / 65534;
    else if (by === 'material') this.shadeMaterials();
    else if (by === 'displacement') {
      this.top = this.largestDisplacement();
      for (let i = 0; i < n; ++i) shades[i] = now[3 * i] === ABSENT ? 0 : this.distance(first, now, i) / this.top;
    } else this.shadeBytes(by === 'speed' ? this.now.speed : this.now.force, by === 'speed' ? this.data.speedTop : this.data.forceTop);
    this.paint(by);
    this.shade.needsUpdate = true;
  }
  /** @param {Uint8Array | null} bytes @param {number} top */
  shadeBytes(bytes, top) {
    this.top = top;
    for (let i = 0; i < this.data.count; ++i) this.shades[i] = bytes ? bytes[i] / 255 : -1;
  }
  shadeMaterials() {
    const m = this.table.material;
    for (let i = 0; i < this.data.count; ++i) this.shades[i] = ((m ? m[i] : 0) + 0.5) / 256;
  }
  /** @param {string} by */
  paint(by) {
    const data = /** @type {Uint8Array} */ (this.colours.image.data);
    for (let k = 0; k < 256; ++k) {
      const c = new THREE.Color(colourOf(1 + k % 8));
      const rgb = by === 'material' ? [c.r, c.g, c.b].map(v => 255 * Math.pow(v, 1 / 2.2)) : mixed(SCALES[by] || SCALES.depth, k / 255);
      data.set([rgb[0], rgb[1], rgb[2], 255], 4 * k);
    }
    this.colours.needsUpdate = true;
  }
  /** m between the places of a sphere. @param {Uint16Array} a @param {Uint16Array} b @param {number} i */
  distance(a, b, i) {
    let sum = 0;
    for (let k = 0; k < 3; ++k) {
      const d = (b[3 * i + k] - a[3 * i + k]) / 65534 * this.size[k];
      sum += d * d;
    }
    return Math.sqrt(sum);
  }
  /** Of 998 in 1000 spheres in the last frame that is here, so that a single one that flies off does not pale the others. */
  largestDisplacement() {
    if (this.span !== undefined) return this.span;
    const frames = this.frames.filter(f => f), last = /** @type {FrameData} */ (frames[frames.length - 1]).positions, all = [];
    for (let i = 0; i < this.data.count; ++i)
      if (last[3 * i] !== ABSENT) all.push(this.distance(this.first, last, i));
    all.sort((a, b) => a - b);
    this.span = Math.max(all[Math.floor(0.998 * (all.length - 1))] || 0, this.data.error, 1e-9);
    return this.span;
  }
  /**
   * Box of the spheres of this frame, but for one in 200 at either side of each axis: single ones that fly off do not
   * make a picture small.
   */
  extent() {
    const p = this.now.positions, box = new THREE.Box3(), radius = this.data.radius.high;
    for (let axis = 0; axis < 3; ++axis) {
      /** @type {number[]} */
      const all = [];
      for (let i = 0; i < this.data.count; ++i) if (p[3 * i] !== ABSENT) all.push(p[3 * i + axis]);
      if (!all.length) return box;
      all.sort((a, b) => a - b);
      const at = (/** @type {number} */ k) => this.data.low[axis] + all[k] / 65534 * this.size[axis], out = Math.floor(all.length / 200);
      box.min.setComponent(axis, at(out) - radius);
      box.max.setComponent(axis, at(all.length - 1 - out) + radius);
    }
    return box;
  }
  /** World place of a sphere in this frame; null where it is not there. @param {number} i */
  at(i) {
    const p = this.now.positions;
    return p[3 * i] === ABSENT ? null : new THREE.Vector3(...this.data.low.map((v, k) => v + p[3 * i + k] / 65534 * this.size[k]));
  }
  /**
   * The nearest sphere that a ray meets on the kept side of the section plane.
   * @param {import('three').Ray} ray
   * @param {import('three').Plane | null} plane of which the positive side is kept
   */
  pick(ray, plane) {
    let best = -1, least = Infinity;
    const p = this.now.positions, { low } = this.data, size = this.size, o = ray.origin, d = ray.direction;
    for (let i = 0; i < this.data.count; ++i) {
      if (p[3 * i] === ABSENT) continue;
      const x = low[0] + p[3 * i] / 65534 * size[0] - o.x, y = low[1] + p[3 * i + 1] / 65534 * size[1] - o.y,
        z = low[2] + p[3 * i + 2] / 65534 * size[2] - o.z, along = x * d.x + y * d.y + z * d.z, r = this.radii[i];
      const room = r * r - (x * x + y * y + z * z - along * along);
      if (room < 0 || along - r > least) continue;
      if (plane && plane.normal.x * (x + o.x) + plane.normal.y * (y + o.y) + plane.normal.z * (z + o.z) + plane.constant < 0) continue;
      const t = along - Math.sqrt(room);
      if (t < least) least = t, best = i;
    }
    return best < 0 ? null : { index: best, distance: least };
  }
  /** What is known of a sphere. @param {number} i */
  describe(i) {
    const place = this.at(i), lines = [`radius: ${lengthText(this.radii[i])}`];
    if (place) lines.push(`at: ${place.toArray().map(v => text(v)).join(' ')} m`);
    if (this.data.materials.length) lines.push(`material: ${this.data.materials[this.table.material ? this.table.material[i] : 0]}`);
    if (this.frames.length > 1) lines.push(`displacement: ${lengthText(this.distance(this.first, this.now.positions, i))}`);
    const { speed, force } = this.now;
    if (speed) lines.push(`speed: ${text(speed[i] / 255 * this.data.speedTop, 2)} m/s`);
    if (force) lines.push(`force: ${text(force[i] / 255 * this.data.forceTop, 2)} N`);
    lines.push(`positions are exact to ${text(this.data.error * 1e6, 2)} \u00b5m`);
    return lines.join('\n');
  }
}
