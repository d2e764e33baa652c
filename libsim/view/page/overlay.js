// @ts-check
'use strict';
// Kinematic symbols, arrows, dimensions and labels: drawn in pixels over the picture, so that they keep their size.

const INK = '#1c2024';
/** @param {string} tag @param {Record<string, any>} attributes @param {...any} children */
function svg(tag, attributes, ...children) {
  const e = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [k, v] of Object.entries(attributes))
    if (k.startsWith('on')) e.addEventListener(k.slice(2), v); else if (v !== null && v !== undefined) e.setAttribute(k, v);
  for (const c of children.flat(Infinity)) if (c) e.append(c);
  return e;
}
/** @param {V2} a @param {V2} b @param {number} k @returns {V2} */
const plus = (a, b, k = 1) => [a[0] + k * b[0], a[1] + k * b[1]];
/** @param {V2[]} points */
const pathOf = points => points.map((p, i) => `${i ? 'L' : 'M'}${p[0].toFixed(1)} ${p[1].toFixed(1)}`).join('');
/** Unit vector from a to b and its length. @param {V2} a @param {V2} b @returns {{ e: V2, size: number }} */
function direction(a, b) {
  const d = plus(b, a, -1), size = Math.hypot(d[0], d[1]);
  return { e: size > 1e-9 ? [d[0] / size, d[1] / size] : [1, 0], size };
}
/** 1, 2 or 5 times a power of ten, at most v. @param {number} v */
function round125(v) {
  const power = Math.pow(10, Math.floor(Math.log10(v))), m = v / power;
  return (m >= 5 ? 5 : m >= 2 ? 2 : 1) * power;
}

/** Symbols between two points. */
const LINKS = ['spring', 'damper', 'rod', 'distance stop', 'beam', 'ratio', 'contact'];

class Overlay {
  /** @param {Scene} scene @param {Stage} stage @param {Poses} poses @param {(thing: number) => void} choose */
  constructor(scene, stage, poses, choose) {
    this.scene = scene;
    this.stage = stage;
    this.poses = poses;
    this.choose = choose;
    this.time = 0;
    this.selected = -1;
    /** @type {Record<string, boolean>} */
    this.layers = { symbols: true, names: true, dimensions: true, axes: true, monitors: true, forces: true, warnings: true };
    this.glyphs = new Glyphs(this);
    /** Where a thing without body or joint is, world. @type {(thing: number) => import('three').Vector3 | null} */
    this.placeOf = () => null;
    /** Labels of this picture, first ones first. @type {{ p: V2, words: string, thing: number, style: Record<string, any> }[]} */
    this.wanted = [];
    this.root = svg('svg', { class: 'overlay', role: 'group', 'aria-label': 'symbols, dimensions and labels' });
    stage.parent.append(this.root);
    stage.after.push(() => this.draw());
    /** Forces of the series at this time, N. @type {(arrow: ForceArrow) => V3} */
    this.forceAt = () => [0, 0, 0];
    /** z of the middle of a body's surfaces, m. @type {(body: number) => number} */
    this.depthOf = () => 0;
    this.largestForce = 1;
    this.slides = scene.symbols.filter(s => s.kind === 'slide').map(s => ({ s, range: this.rangeOf(s) }));
  }
  /** Pixels of a world point. @param {number} x @param {number} y @param {number} [z] */
  at(x, y, z = 0) { return this.stage.project(new THREE.Vector3(x, y, z)); }
  /** @param {number} body @param {V2} p */
  on(body, p) { const [x, y] = this.poses.point(body, p, this.time); return this.at(x, y); }

  /** Along a slide's line over the run: from, to, m. @param {SymbolData} s @returns {V2} */
  rangeOf(s) {
    let low = 0, high = 0;
    for (const t of this.poses.times.length ? this.poses.times : [0]) {
      const p = this.poses.point(s.b, s.pb, t), o = this.poses.point(s.a, s.pa, t), a = this.poses.body(s.a, t)[2] + (s.angle || 0);
      const d = (p[0] - o[0]) * Math.cos(a) + (p[1] - o[1]) * Math.sin(a);
      low = Math.min(low, d), high = Math.max(high, d);
    }
    const beyond = 0.06 * this.scene.size;
    return [low - beyond, high + beyond];
  }
  draw() {
    this.root.setAttribute('viewBox', `0 0 ${this.stage.width} ${this.stage.height}`);
    /** @type {any[]} */
    const parts = [];
    this.wanted = [];
    if (this.layers.axes) parts.push(this.axes(), this.scaleBar(), this.triad());
    if (this.layers.symbols) parts.push(this.symbols());
    if (this.layers.dimensions) parts.push(this.dimensions());
    if (this.layers.forces) parts.push(this.forces());
    if (this.layers.monitors) parts.push(this.monitors());
    if (this.layers.names) this.names();
    parts.push(this.placed());
    if (this.layers.warnings) parts.push(this.warnings());
    this.root.replaceChildren(...parts.flat(Infinity).filter(Boolean));
  }
  /** A group that selects its thing. @param {number} thing @param {...any} children */
  group(thing, ...children) {
    const t = this.scene.things[thing], chosen = thing >= 0 && thing === this.selected;
    return svg('g', { class: chosen ? 'thing chosen' : 'thing', 'data-thing': thing, role: 'img', 'aria-label': t ? `${t.kind} ${t.name}` : null,
      onclick: (/** @type {Event} */ e) => { e.stopPropagation(); if (thing >= 0) this.choose(thing); } }, ...children);
  }
  /** @param {V2[]} points @param {Record<string, any>} [style] */
  line(points, style = {}) { return svg('path', { d: pathOf(points), fill: 'none', stroke: INK, 'stroke-width': 1.3, ...style }); }
  /** @param {V2} p @param {string} words @param {Record<string, any>} [style] */
  label(p, words, style = {}) {
    return svg('text', { x: p[0].toFixed(1), y: p[1].toFixed(1), 'font-size': 12, fill: INK, stroke: '#ffffff', 'stroke-width': 3,
      'paint-order': 'stroke', ...style }, words);
  }
  /** @param {V2} from @param {V2} to @param {Record<string, any>} [style] */
  arrow(from, to, style = {}) {
    const { e, size } = direction(from, to), n = /** @type {V2} */ ([-e[1], e[0]]), head = Math.min(9, 0.6 * size);
    const neck = plus(to, e, -head), colour = style.stroke || INK;
    return [this.line([from, neck], { 'stroke-width': 2, ...style }),
      svg('path', { d: pathOf([to, plus(neck, n, 0.45 * head), plus(neck, n, -0.45 * head)]) + 'Z', fill: colour })];
  }
  /** Strokes on the right of a line, as of solid ground. @param {V2} from @param {V2} to */
  hatch(from, to) {
    const { e, size } = direction(from, to), n = /** @type {V2} */ ([-e[1], e[0]]), count = Math.min(160, Math.max(2, Math.floor(size / 8)));
    const strokes = [];
    for (let k = 1; k <= count; ++k) {
      const foot = plus(from, e, size * (k - 0.25) / count);
      strokes.push(pathOf([foot, plus(plus(foot, n, 6), e, -6)]));
    }
    return [this.line([from, to], { 'stroke-width': 1.6 }), svg('path', { d: strokes.join(''), stroke: '#5c666f', 'stroke-width': 0.9, fill: 'none' })];
  }

  symbols() {
    const out = [], drawn = { pin: this.pin, weld: this.weld, marker: this.marker, driver: this.driver, side: this.side };
    for (const { s, range } of this.slides) out.push(this.group(s.thing, this.rail(s, range)));
    for (const s of this.scene.symbols) {
      const draw = drawn[/** @type {keyof typeof drawn} */ (s.kind)];
      const glyph = this.glyphs.of(s.kind);
      if (draw) out.push(this.group(s.thing, draw.call(this, s)));
      if (glyph) out.push(this.group(s.thing, glyph.call(this.glyphs, s)));
    }
    this.scene.bodies.forEach((b, i) => { if (i > 0) out.push(this.group(b.thing, this.massCentre(this.on(i, [0, 0])))); });
    return out;
  }
  /** @param {SymbolData} s */
  pin(s) {
    const p = this.on(s.b, s.pb), grounded = s.a === 0 || s.b === 0;
    const left = plus(p, [-9, 15]), right = plus(p, [9, 15]);
    return [grounded && svg('path', { d: pathOf([p, left, right]) + 'Z', fill: '#ffffff', stroke: INK, 'stroke-width': 1.3 }),
      grounded && this.hatch(plus(left, [-5, 0]), plus(right, [5, 0])),
      svg('circle', { cx: p[0], cy: p[1], r: 5, fill: '#ffffff', stroke: s.hitch ? '#b00020' : INK, 'stroke-width': s.hitch ? 2.4 : 1.6 })];
  }
  /** @param {SymbolData} s */
  weld(s) {
    const p = this.on(s.b, s.pb), grounded = s.a === 0 || s.b === 0;
    return [grounded && this.hatch(plus(p, [-14, 5]), plus(p, [14, 5])),
      svg('rect', { x: p[0] - 4.5, y: p[1] - 4.5, width: 9, height: 9, fill: INK })];
  }
  /** @param {SymbolData} s */
  marker(s) {
    const p = this.on(s.a, s.pa);
    return [this.line([plus(p, [-6, 0]), plus(p, [6, 0])], { stroke: '#7a00c4' }),
      this.line([plus(p, [0, -6]), plus(p, [0, 6])], { stroke: '#7a00c4' })];
  }
  /** @param {SymbolData} s @param {V2} range */
  rail(s, range) {
    const [x, y] = this.poses.point(s.a, s.pa, this.time), a = this.poses.body(s.a, this.time)[2] + (s.angle || 0);
    let tail = this.at(x + range[0] * Math.cos(a), y + range[0] * Math.sin(a)), head = this.at(x + range[1] * Math.cos(a), y + range[1] * Math.sin(a));
    const colour = s.a === 0 ? INK : colourOf(s.a);
    if (s.a !== 0) return this.line([tail, head], { stroke: colour, 'stroke-width': 2 });
    if (head[0] < tail[0]) [tail, head] = [head, tail];
    const { e } = direction(tail, head), n = /** @type {V2} */ ([-e[1], e[0]]);
    const aside = s.block ? 0.026 * this.scene.size * this.stage.scale : (s.below || 0) * this.stage.scale;
    return this.hatch(plus(tail, n, aside), plus(head, n, aside));
  }
  /** @param {SymbolData} s */
  side(s) {
    const [x, y] = this.poses.point(s.a, s.pa, this.time), a = this.poses.body(s.a, this.time)[2] + (s.angle || 0), half = 0.8 * this.scene.size;
    const middle = s.a === 0 ? this.nearest(x, y, a) : 0;
    const tail = this.at(x + (middle - half) * Math.cos(a), y + (middle - half) * Math.sin(a));
    const head = this.at(x + (middle + half) * Math.cos(a), y + (middle + half) * Math.sin(a));
    return this.hatch(tail, head);
  }
  /** Where along a line the centre of the machine is. @param {number} x @param {number} y @param {number} a */
  nearest(x, y, a) {
    let sum = 0;
    for (let i = 1; i < this.scene.bodies.length; ++i) {
      const b = this.poses.body(i, this.time);
      sum += (b[0] - x) * Math.cos(a) + (b[1] - y) * Math.sin(a);
    }
    return sum / Math.max(1, this.scene.bodies.length - 1);
  }
  /** @param {SymbolData} s */
  driver(s) {
    const p = this.on(s.b, s.pb), style = { stroke: '#0052cc', 'stroke-width': 2.4 };
    if (s.what === 'angle')
      return [svg('path', { d: `M${p[0] + 20} ${p[1]} A20 20 0 1 0 ${p[0]} ${p[1] + 20}`, fill: 'none', ...style }),
        svg('path', { d: pathOf([plus(p, [8, 20]), plus(p, [-2, 15]), plus(p, [-2, 25])]) + 'Z', fill: style.stroke })];
    if (s.what === 'distance') {
      const q = this.on(s.a, s.pa), { e } = direction(q, p);
      return this.arrow(p, plus(p, e, 34), style);
    }
    const a = s.what === 'y' ? Math.PI / 2 : s.what === 'slide' ? this.poses.body(s.a, this.time)[2] + (s.angle || 0) : 0;
    const [x, y] = this.poses.point(s.b, s.pb, this.time), e = direction(p, this.at(x + Math.cos(a), y + Math.sin(a))).e;
    return this.arrow(plus(p, e, 8), plus(p, e, 48), style);
  }
  /** The quartered disk of a centre of mass. @param {V2} p */
  massCentre(p) {
    const r = 6, quarter = (/** @type {number} */ x, /** @type {number} */ y) =>
      svg('path', { d: `M${p[0]} ${p[1]}h${x * r}A${r} ${r} 0 0 ${x * y > 0 ? 1 : 0} ${p[0]} ${p[1] + y * r}Z`, fill: INK });
    return [svg('circle', { cx: p[0], cy: p[1], r, fill: '#ffffff', stroke: INK, 'stroke-width': 1 }), quarter(1, -1), quarter(-1, 1)];
  }
  names() {
    this.scene.bodies.forEach((b, i) => {
      if (i > 0) this.name(plus(this.on(i, [0, 0]), [9, -8]), this.scene.things[b.thing].name, b.thing, { 'font-weight': 600 });
    });
    const named = new Set();
    for (const s of this.scene.symbols) {
      const t = this.scene.things[s.thing];
      if (!t || t.kind === 'body' || named.has(s.thing)) continue;
      named.add(s.thing);
      const link = LINKS.includes(s.kind), p = this.on(s.b, s.pb), q = link ? this.on(s.a, s.pa) : p;
      const middle = /** @type {V2} */ ([(p[0] + q[0]) / 2, (p[1] + q[1]) / 2]);
      this.name(plus(middle, link ? [8, -16] : [9, 14]), (s.hitch ? 'hitch ' : '') + t.name, s.thing);
    }
  }
  /** @param {V2} p @param {string} words @param {number} thing @param {Record<string, any>} [style] */
  name(p, words, thing, style = {}) { this.wanted.push({ p, words, thing, style }); }
  /** Labels that do not cover each other: one that finds no room moves down or up, then is left out. */
  placed() {
    /** @type {number[][]} */
    const taken = [];
    const out = [];
    for (const w of this.wanted) {
      const width = 6.6 * w.words.length + 4, left = w.style['text-anchor'] === 'end' ? w.p[0] - width : w.p[0];
      for (const dy of [0, 13, -13, 26, -26, 39, -39]) {
        const box = [left, w.p[1] + dy - 11, left + width, w.p[1] + dy + 2];
        if (taken.some(b => b[0] < box[2] && box[0] < b[2] && b[1] < box[3] && box[1] < b[3])) continue;
        taken.push(box);
        out.push(this.group(w.thing, this.label(plus(w.p, [0, dy]), w.words, w.style)));
        break;
      }
    }
    return out;
  }
  /** World place of a thing now: of its joint or force, its body, or its surface. @param {number} thing */
  place(thing) {
    const body = this.scene.bodies.findIndex(b => b.thing === thing), s = this.scene.symbols.find(k => k.thing === thing);
    const of = (/** @type {V2} */ p) => new THREE.Vector3(p[0], p[1], 0);
    if (thing < 0) return null;
    if (body > 0) return of(this.poses.point(body, [0, 0], this.time));
    if (!s) return this.placeOf(thing);
    const q = this.poses.point(s.b, s.pb, this.time), p = LINKS.includes(s.kind) ? this.poses.point(s.a, s.pa, this.time) : q;
    return of([(p[0] + q[0]) / 2, (p[1] + q[1]) / 2]);
  }
  /** Numbers of the warnings at what they mean. */
  warnings() {
    /** @type {Map<number, number[]>} */
    const numbers = new Map();
    this.scene.warnings.forEach((w, i) => w.things.forEach(t => numbers.set(t, [...(numbers.get(t) || []), i + 1])));
    /** @type {V2[]} */
    const taken = [];
    return [...numbers].map(([thing, list]) => {
      const place = this.place(thing);
      if (!place) return null;
      const p = this.stage.project(place), words = list.join(' '), w = 12 + 7 * words.length;
      while (taken.some(t => Math.hypot(t[0] - p[0], t[1] - p[1]) < 18)) p[0] -= 22;
      taken.push(p);
      const at = plus(p, [-15, -22]);
      const g = this.group(thing, svg('path', { d: `M${p[0]} ${p[1]}l${-11} ${-13}h8Z`, fill: '#d08a2e' }),
        svg('rect', { x: at[0] - w / 2, y: at[1] - 9, width: w, height: 18, rx: 9, fill: '#d08a2e', stroke: '#ffffff', 'stroke-width': 1.2 }),
        svg('text', { x: at[0], y: at[1] + 4, 'font-size': 12, 'font-weight': 700, fill: '#ffffff', 'text-anchor': 'middle' }, words),
        svg('title', {}, list.map(i => this.scene.warnings[i - 1].text).join('\n')));
      g.setAttribute('data-warning', list.join(' '));
      g.setAttribute('aria-label', `warning ${words} at ${this.scene.things[thing].name}`);
      return g;
    });
  }
  /** Arrow around a point, counter-clockwise for 1. @param {V2} p @param {number} sense @param {number} r pixels @param {Record<string, any>} style */
  turn(p, sense, r, style) {
    const point = (/** @type {number} */ a) => /** @type {V2} */ ([p[0] + r * Math.cos(a), p[1] - sense * r * Math.sin(a)]), points = [];
    for (let a = -0.6; a <= 3.8; a += 0.2) points.push(point(a));
    const end = point(3.95), back = direction(point(3.7), end).e, n = /** @type {V2} */ ([-back[1], back[0]]), tip = plus(end, back, 5);
    return [this.line(points, style), svg('path', { d: pathOf([tip, plus(plus(tip, back, -9), n, 4), plus(plus(tip, back, -9), n, -4)]) + 'Z', fill: style.stroke })];
  }
  scaleBar() {
    const metres = round125(150 / this.stage.scale), w = metres * this.stage.scale, y = this.stage.height - 16, x = this.stage.width - 24 - w;
    return svg('g', { role: 'img', 'aria-label': `scale ${lengthText(metres)}` },
      this.line([[x, y - 4], [x, y], [x + w, y], [x + w, y - 4]], { 'stroke-width': 1.6 }),
      this.label([x + w / 2, y - 6], lengthText(metres), { 'text-anchor': 'middle' }));
  }
  /** Directions of the axes and of gravity. */
  triad() {
    const o = /** @type {V2} */ ([58, this.stage.height - 58]), zero = this.at(0, 0, 0), out = [];
    const of = (/** @type {V3} */ v) => {
      const d = direction(zero, this.at(v[0], v[1], v[2]));
      return /** @type {V2} */ ([d.e[0] * Math.min(1, d.size / this.stage.scale), d.e[1] * Math.min(1, d.size / this.stage.scale)]);
    };
    /** @type {[string, V3, string][]} */
    const axes = [['x', [1, 0, 0], '#c62828'], ['y', [0, 1, 0], '#2e7d32'], ['z', [0, 0, 1], '#1565c0']];
    for (const [name, v, colour] of axes) {
      const e = of(v);
      if (Math.hypot(...e) < 0.08) continue;
      out.push(this.arrow(o, plus(o, e, 34), { stroke: colour }), this.label(plus(plus(o, e, 42), [-3, 4]), name, { fill: colour }));
    }
    const g = this.scene.gravity, size = Math.hypot(...g);
    if (size > 0) {
      const e = of([g[0] / size, g[1] / size, g[2] / size]), from = plus(o, [62, -24]);
      out.push(this.arrow(from, plus(from, e, 34), { stroke: '#5c666f' }), this.label(plus(from, [6, 10]), `g ${text(size, 3)} m/s\u00b2`, { fill: '#5c666f' }));
    }
    return out;
  }
  /** Rulers along the lower edges of the box around everything. */
  axes() {
    const { min, max } = this.stage.bounds, out = [], away = this.stage.camera.getWorldDirection(new THREE.Vector3());
    const z = away.z < 0 ? max.z : min.z, x = away.x < 0 ? max.x : min.x;
    const flat = this.scene.spheres === null && this.scene.bed === null;
    out.push(this.ruler(0, t => [t, min.y, flat ? 0 : z], min.x, max.x, [0, 14]));
    out.push(this.ruler(1, t => [min.x, t, flat ? 0 : z], min.y, max.y, [-8, 4]));
    if (!flat) out.push(this.ruler(2, t => [x, min.y, t], min.z, max.z, [10, 10]));
    return out;
  }
  /** @param {number} axis @param {(t: number) => V3} place @param {number} from @param {number} to @param {V2} aside */
  ruler(axis, place, from, to, aside) {
    const a = this.at(...place(from)), b = this.at(...place(to)), { size, e } = direction(a, b);
    if (size < 40) return [];
    const step = round125((to - from) * 70 / size * 1.6), n = /** @type {V2} */ ([-e[1], e[0]]);
    const out = [this.line([a, b], { stroke: '#8795a1', 'stroke-width': 1 })];
    for (let t = Math.ceil(from / step - 1e-9) * step; t <= to + 1e-9; t += step) {
      const p = this.at(...place(t));
      out.push(this.line([plus(p, n, -3), plus(p, n, 3)], { stroke: '#8795a1', 'stroke-width': 1 }));
      out.push(this.label(plus(p, aside), text(Math.abs(t) < 1e-9 * step ? 0 : t, 3), { fill: '#5c666f', 'font-size': 11, 'text-anchor': axis === 0 ? 'middle' : axis === 1 ? 'end' : 'start' }));
    }
    const end = axis === 0 ? plus(plus(a, e, -22), aside) : plus(plus(b, e, 14), axis === 1 ? [-14, 0] : aside);
    out.push(this.label(end, `${'xyz'[axis]}, m`, { fill: '#5c666f', 'font-size': 11, 'text-anchor': axis === 0 ? 'end' : 'start' }));
    return out;
  }
  /** Depth, width, rake and speed of the tool where they are read off. */
  dimensions() {
    const tool = this.scene.tool;
    if (!tool) return [];
    const { at, share } = bracket(tool.times, this.time);
    const value = (/** @type {number[]} */ list) => list[at] + (share > 0 ? share * (list[at + 1] - list[at]) : 0);
    const tip = value(tool.tip), depth = value(tool.depth), colour = '#6a1b9a', style = { stroke: colour, 'stroke-width': 1.4 };
    const world = (/** @type {number} */ along, /** @type {number} */ y, /** @type {number} */ across) =>
      tool.axis === 0 ? this.at(along, y, across) : this.at(across, y, along);
    const ahead = tip + tool.direction * 0.05 * this.scene.size, out = [];
    const top = world(ahead, tool.surface, tool.middle), low = world(ahead, tool.surface - depth, tool.middle);
    if (Math.abs(depth) > 1e-6)
      out.push(this.arrow(top, low, style), this.arrow(low, top, style));
    if (Math.abs(depth) > 1e-6) this.name(plus(low, [8, -6]), `${depth > 0 ? 'depth' : 'above the soil'} ${lengthText(Math.abs(depth))}`, -1, { fill: colour });
    const a = world(tip, tool.surface - depth, tool.middle - tool.width / 2), b = world(tip, tool.surface - depth, tool.middle + tool.width / 2);
    if (direction(a, b).size > 6) out.push(this.arrow(a, b, style), this.arrow(b, a, style));
    const rake = tool.rakeHigh - tool.rakeLow < 0.02 ? `${text(tool.rakeHigh * 180 / Math.PI, 3)}\u00b0`
      : `${text(tool.rakeLow * 180 / Math.PI, 3)}\u2026${text(tool.rakeHigh * 180 / Math.PI, 3)}\u00b0`;
    const words = [`width ${lengthText(tool.width)}`, `rake ${rake}`, `speed ${text(tool.speed, 3)} m/s`];
    words.forEach((w, k) => this.name(plus(low, [8, 9 + 15 * k]), w, -1, { fill: colour }));
    const end = world(ahead + tool.direction * 0.1 * this.scene.size, tool.surface - depth, tool.middle);
    out.push(this.arrow(low, end, style));
    return svg('g', { role: 'img', 'aria-label': `tool: depth ${lengthText(depth)}, ${words.join(', ')}` }, out.flat(Infinity));
  }
  /** The direction in which a monitor is positive. */
  monitors() {
    const style = { stroke: '#00695c', 'stroke-dasharray': '4 2' };
    return this.scene.monitors.map((m, k) => {
      const a = m.arrow, place = a && (a.body >= 0 ? new THREE.Vector3(...this.poses.point(a.body, a.point, this.time), 0) : this.place(a.thing === undefined ? -1 : a.thing));
      if (!a || !place) return null;
      const p = this.stage.project(place), far = 40 + 8 * (k % 3);
      if (a.turn) {
        this.name(plus(p, [far - 16, 22]), `+${m.name}`, m.thing, { fill: style.stroke });
        return this.group(m.thing, this.turn(p, a.turn, far - 16, { ...style, 'stroke-width': 2 }));
      }
      const e = this.sense(a, place, p), from = plus(p, [0, -4 - 3 * (k % 3)]), end = plus(from, e, far);
      this.name(plus(end, e, 6), `+${m.name}`, m.thing, { fill: style.stroke, 'text-anchor': e[0] < -0.3 ? 'end' : 'start' });
      return this.group(m.thing, this.arrow(from, end, style));
    });
  }
  /** Direction of an arrow on the page. @param {MonitorArrow} a @param {import('three').Vector3} place @param {V2} p */
  sense(a, place, p) {
    if (a.from) return direction(this.on(a.from.body, a.from.point), p).e;
    const turned = a.line ? this.poses.body(a.line.body, this.time)[2] + a.line.angle : 0;
    const along = a.line ? [Math.cos(turned), Math.sin(turned), 0] : a.along || [1, 0, 0];
    return direction(p, this.stage.project(place.clone().add(new THREE.Vector3(along[0], along[1], along[2])))).e;
  }
  /** Forces on bodies: 90 pixels are the largest of the run. */
  forces() {
    return this.scene.forces.map(f => {
      const force = this.forceAt(f), size = Math.hypot(...force);
      if (!(size > 0.004 * this.largestForce)) return null;
      const o = this.forcePlace(f), p = this.stage.project(o);
      const q = this.stage.project(o.clone().add(new THREE.Vector3(...force).multiplyScalar(90 / this.largestForce / this.stage.scale)));
      const left = q[0] < p[0] - 20;
      this.name(plus(q, [left ? -6 : 6, q[1] > p[1] ? 14 : -4]), `${f.name} ${text(size, 3)} N`, f.thing, { fill: '#b00020', 'text-anchor': left ? 'end' : 'start' });
      const g = this.group(f.thing, this.arrow(p, q, { stroke: '#b00020', 'stroke-width': 3 }));
      g.setAttribute('data-force', f.name);
      g.setAttribute('data-from', p.join(' '));
      g.setAttribute('data-to', q.join(' '));
      return g;
    });
  }
  /** Of a body its centre of mass, in the plane where its surface is. @param {ForceArrow} f */
  forcePlace(f) {
    const place = f.body >= 0 ? this.poses.body(f.body, this.time) : f.path >= 0 ? this.poses.path(f.path, this.time).place.toArray() : [0, 0, 0];
    return new THREE.Vector3(place[0], place[1], f.body >= 0 ? this.depthOf(f.body) : place[2]);
  }
}
