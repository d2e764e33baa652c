// @ts-check
'use strict';
// Symbols of joints and forces that are no solids: gears, stops, springs that turn, contacts, motors.
// Each returns SVG elements in pixels of the overlay; lengths of the machine are projected from the world.

const SPRING_INK = '#2f6b3a', STOP_INK = '#9a5b00', GROUND_INK = '#5c666f', GEAR_INK = '#343b42';

/** Names of gear teeth: as many on each of two gears as their radii say. @param {number} radius @param {number} pitch */
const teethOf = (radius, pitch) => Math.max(6, Math.round(2 * Math.PI * radius / pitch));

class Glyphs {
  /** @param {Overlay} overlay */
  constructor(overlay) {
    this.o = overlay;
  }
  get size() { return this.o.scene.size; }
  /** World places of the two points of a symbol, and the angles of its bodies. @param {SymbolData} s */
  places(s) {
    const { poses, time } = this.o;
    return { p: poses.point(s.a, s.pa, time), q: poses.point(s.b, s.pb, time), angleA: poses.body(s.a, time)[2], angleB: poses.body(s.b, time)[2] };
  }
  /** Circle or sector in the machine's plane, projected. @param {V2} centre @param {number} radius @param {number} from @param {number} to */
  arc(centre, radius, from, to) {
    const count = Math.max(2, Math.ceil(Math.abs(to - from) / 0.13)), points = [];
    for (let k = 0; k <= count; ++k) points.push(this.along(centre, from + (to - from) * k / count, radius));
    return points;
  }
  /** Pixels of what lies from a world point so far in a direction. @param {V2} p @param {number} angle @param {number} far m */
  along(p, angle, far) { return this.o.at(p[0] + far * Math.cos(angle), p[1] + far * Math.sin(angle)); }

  /** Pitch circle and teeth of a gear. @param {V2} centre @param {number} radius @param {number} turn @param {number} pitch m */
  gear(centre, radius, turn, pitch) {
    const count = teethOf(radius, pitch), height = 0.3 * pitch, points = [];
    for (let k = 0; k < count; ++k)
      for (const [share, side] of [[0.05, -1], [0.2, 1], [0.45, 1], [0.6, -1]])
        points.push(this.along(centre, turn + 2 * Math.PI * (k + share) / count, radius + side * height));
    return [svg('path', { d: pathOf(points) + 'Z', fill: 'none', stroke: GEAR_INK, 'stroke-width': 1.1 }),
      this.o.line(this.arc(centre, radius, 0, 2 * Math.PI), { stroke: '#b00020', 'stroke-width': 0.9, 'stroke-dasharray': '9 3 2 3' })];
  }
  /** Where two surfaces touch: filled, they roll; hollow, they slide; two wedges, they may part. @param {V2} at pixels @param {string} what */
  touch(at, what) {
    if (what === 'contact')
      return [svg('path', { d: pathOf([plus(at, [-9, -5]), at, plus(at, [-9, 5])]), fill: 'none', stroke: STOP_INK, 'stroke-width': 2 }),
        svg('path', { d: pathOf([plus(at, [9, -5]), at, plus(at, [9, 5])]), fill: 'none', stroke: STOP_INK, 'stroke-width': 2 })];
    return [svg('circle', { cx: at[0], cy: at[1], r: 4, fill: what === 'rolls' ? INK : '#ffffff', stroke: INK, 'stroke-width': 1.4 })];
  }
  /** @param {SymbolData} s */
  twoDisks(s) {
    const { p, q, angleA, angleB } = this.places(s), ra = s.radius || 0, rb = s.radiusB || 0, share = ra / (ra + rb);
    if (s.what === 'gears') {
      const pitch = 2 * Math.PI * Math.min(ra, Math.abs(rb)) / 14;
      return [this.gear(p, ra, angleA, pitch), this.gear(q, Math.abs(rb), angleB, pitch)];
    }
    return this.touch(this.o.at(p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])), s.what || '');
  }
  /** A disk of b on a line of a. @param {SymbolData} s */
  diskOnLine(s) {
    const { p, q, angleA, angleB } = this.places(s), a = angleA + (s.angle || 0), e = /** @type {V2} */ ([Math.cos(a), Math.sin(a)]);
    const way = (q[0] - p[0]) * e[0] + (q[1] - p[1]) * e[1], foot = plus(p, e, way);
    if (s.what !== 'rack') return this.touch(this.o.at(foot[0], foot[1]), s.what || '');
    const r = s.radius || 0, pitch = 2 * Math.PI * r / 14, points = [], n = /** @type {V2} */ ([-e[1], e[0]]), count = Math.min(60, Math.ceil(this.size / pitch));
    const first = -Math.ceil(count / 2) + Math.round(way / pitch);
    for (let k = first; k < first + count; ++k)
      for (const [share, side] of [[0.05, -1], [0.2, 1], [0.45, 1], [0.6, -1]]) {
        const w = plus(plus(p, e, (k + share) * pitch), n, side * 0.3 * pitch);
        points.push(this.o.at(w[0], w[1]));
      }
    return [this.gear(q, r, angleB, pitch), this.o.line(points, { stroke: GEAR_INK, 'stroke-width': 1.1 })];
  }
  /** Turns in a fixed ratio: a belt drawn dashed. @param {SymbolData} s */
  ratio(s) {
    const { p, q } = this.places(s), a = this.o.at(p[0], p[1]), b = this.o.at(q[0], q[1]), { e, size } = direction(a, b), n = /** @type {V2} */ ([-e[1], e[0]]);
    const style = { 'stroke-dasharray': '7 4', stroke: GEAR_INK };
    const middle = plus(plus(a, e, size / 2), [8, -8]);
    return [...[7, -7].map(k => this.o.line([plus(a, n, k), plus(b, n, k)], style)), this.o.label(middle, `i = ${text(s.ratio || 0, 3)}`, { fill: GEAR_INK })];
  }
  /** @param {SymbolData} s */
  follower(s) {
    const { q, angleB } = this.places(s), at = this.o.at(q[0], q[1]);
    if (s.angle === undefined) return this.touch(at, 'slides');
    const a = angleB + s.angle, far = 0.12 * this.size;
    return [this.o.line([this.along(q, a, -far), this.along(q, a, far)], { 'stroke-width': 2.4 }), this.touch(at, 'slides')];
  }
  /** @param {SymbolData} s */
  contact(s) {
    const { p, q } = this.places(s);
    return this.touch(this.o.at((p[0] + q[0]) / 2, (p[1] + q[1]) / 2), 'contact');
  }
  /** A spiral. @param {SymbolData} s */
  torsion(s) {
    const { q } = this.places(s), at = this.o.at(q[0], q[1]), points = [];
    for (let k = 0; k <= 72; ++k) {
      const a = 2 * Math.PI * 2.75 * k / 72, r = 3 + 14 * k / 72;
      points.push(plus(at, [r * Math.cos(a), -r * Math.sin(a)]));
    }
    return [this.o.line(/** @type {V2[]} */ (points), { stroke: SPRING_INK, 'stroke-width': 1.8 })];
  }
  /** @param {SymbolData} s */
  bushing(s) {
    const { q } = this.places(s), [cx, cy] = this.o.at(q[0], q[1]);
    return [svg('circle', { cx, cy, r: 9.5, fill: 'none', stroke: '#6d6d6d', 'stroke-width': 5, 'stroke-opacity': 0.65, 'stroke-dasharray': '3 1.5' })];
  }
  /** @param {SymbolData} s */
  beam(s) {
    const { p, q } = this.places(s), ends = [this.o.at(p[0], p[1]), this.o.at(q[0], q[1])];
    return [this.o.line(ends, { stroke: GEAR_INK, 'stroke-width': 4 }), this.o.line(ends, { stroke: '#e8edf2', 'stroke-width': 1.6 })];
  }
  /** Air or water that brakes. @param {SymbolData} s */
  drag(s) {
    const { q } = this.places(s), at = this.o.at(q[0], q[1]);
    return [-6, 0, 6].map(dy => svg('path', { d: `M${at[0] + 9} ${at[1] + dy}q4 -5 8 0t8 0t8 0`, fill: 'none', stroke: '#1565c0', 'stroke-width': 1.5 }));
  }
  /** Sector that the second body may take, with its ends; the hand is where it is. @param {SymbolData} s */
  angleStop(s) {
    const { q, angleA, angleB } = this.places(s), own = Math.hypot(s.pb[0], s.pb[1]) > 1e-9 ? Math.atan2(-s.pb[1], -s.pb[0]) : 0;
    const hand = angleB + own, theta = angleB - angleA, r = 0.11 * this.size;
    const ends = [s.from, s.until].filter(v => typeof v === 'number').map(v => hand + /** @type {number} */ (v) - theta);
    const style = { stroke: STOP_INK, 'stroke-width': 1.4 };
    const bars = ends.map(a => this.o.line([this.along(q, a, 0.75 * r), this.along(q, a, 1.2 * r)], { stroke: STOP_INK, 'stroke-width': 4 }));
    const sector = this.arc(q, r, ends.length === 2 ? ends[0] : hand, ends[ends.length - 1]);
    return [this.o.line(sector, style), bars, this.o.line([this.o.at(q[0], q[1]), this.along(q, hand, r)], { ...style, 'stroke-dasharray': '4 3' })];
  }
  /** @param {SymbolData} s */
  slideStop(s) {
    const { p, q, angleA } = this.places(s), a = angleA + (s.angle || 0), half = 0.035 * this.size;
    const bar = (/** @type {number} */ way) => {
      const at = /** @type {V2} */ ([p[0] + way * Math.cos(a), p[1] + way * Math.sin(a)]);
      return this.o.line([this.along(at, a + Math.PI / 2, -half), this.along(at, a + Math.PI / 2, half)], { stroke: STOP_INK, 'stroke-width': 4 });
    };
    const ends = /** @type {number[]} */ ([s.from, s.until].filter(v => typeof v === 'number')), now = (q[0] - p[0]) * Math.cos(a) + (q[1] - p[1]) * Math.sin(a);
    const low = Math.min(now, ...ends), high = Math.max(now, ...ends);
    return [this.o.line([this.along(p, a, low), this.along(p, a, high)], { stroke: STOP_INK, 'stroke-dasharray': '4 3' }), ends.map(bar),
      svg('circle', { cx: this.along(p, a, now)[0], cy: this.along(p, a, now)[1], r: 3, fill: STOP_INK })];
  }
  /** A rope where only the maximum is limited; dashed while it is slack. @param {SymbolData} s */
  distanceStop(s) {
    const { p, q } = this.places(s), a = this.o.at(p[0], p[1]), b = this.o.at(q[0], q[1]), { e } = direction(a, b), n = /** @type {V2} */ ([-e[1], e[0]]);
    const far = Math.hypot(q[0] - p[0], q[1] - p[1]), slack = !(typeof s.until === 'number' && far >= s.until) && !(typeof s.from === 'number' && far <= s.from);
    return [this.o.line([a, b], { stroke: STOP_INK, 'stroke-width': 1.8, 'stroke-dasharray': slack ? '5 4' : null }),
      [a, b].map(c => this.o.line([plus(c, n, 6), plus(c, n, -6)], { stroke: STOP_INK, 'stroke-width': 2.6 }))];
  }
  /** Ground that yields under a wheel or a point. @param {SymbolData} s */
  ground(s) {
    const { q } = this.places(s), at = this.o.at(q[0], s.pa[1]), zigzag = [at, plus(at, [0, 4]), plus(at, [-6, 7]), plus(at, [6, 11]), plus(at, [-6, 15]), plus(at, [6, 19]), plus(at, [0, 22]), plus(at, [0, 26])];
    return [this.o.line([plus(at, [-12, 0]), plus(at, [12, 0])], { stroke: GROUND_INK, 'stroke-width': 2.2 }),
      this.o.line(/** @type {V2[]} */ (zigzag), { stroke: GROUND_INK }), this.o.hatch(plus(at, [-14, 26]), plus(at, [14, 26]))];
  }
  /** @param {SymbolData} s */
  motor(s) {
    const { q } = this.places(s), at = this.o.at(q[0], q[1]), [cx, cy] = plus(at, [-24, -20]);
    return [this.o.line([at, [cx, cy]], { stroke: '#0052cc' }), svg('circle', { cx, cy, r: 10, fill: '#ffffff', stroke: '#0052cc', 'stroke-width': 2 }),
      svg('text', { x: cx, y: cy + 4.5, 'text-anchor': 'middle', 'font-size': 13, 'font-weight': 600, fill: '#0052cc' }, 'M')];
  }
  /** @param {SymbolData} s */
  friction(s) {
    const { q } = this.places(s), at = this.o.at(q[0], q[1]);
    return [this.o.line([plus(at, [-20, -8]), plus(at, [-8, -8])], { stroke: STOP_INK, 'stroke-width': 2 }), this.o.line([plus(at, [-20, -12]), plus(at, [-8, -12])], { stroke: STOP_INK, 'stroke-width': 2 }),
      this.o.label(plus(at, [-20, -16]), '\u00b5', { fill: STOP_INK, 'font-style': 'italic' })];
  }
  /** A given force and moment as they are at the start. @param {SymbolData} s */
  load(s) {
    const { q, angleB } = this.places(s), at = this.o.at(q[0], q[1]), [fx, fy, moment] = s.along || [0, 0, 0], style = { stroke: '#b00020', 'stroke-width': 2.4 };
    const out = [svg('circle', { cx: at[0], cy: at[1], r: 3.5, fill: '#b00020' })];
    if (fx || fy) {
      const e = direction(at, this.along(q, Math.atan2(fy, fx) + (s.turns ? angleB : 0), 1)).e;
      out.push(...this.o.arrow(plus(at, e, -46), plus(at, e, -5), style));
    }
    if (moment) out.push(...this.o.turn(at, Math.sign(moment), 17, style));
    return [out, this.o.label(plus(at, [6, -8]), moment && !(fx || fy) ? 'M' : 'F', { fill: '#b00020', 'font-style': 'italic' })];
  }
  /** The function that draws a kind; undefined: it is a solid or drawn elsewhere. @param {SymbolData['kind']} kind */
  of(kind) {
    /** @type {Partial<Record<SymbolData['kind'], (s: SymbolData) => any>>} */
    const drawn = { 'two disks': this.twoDisks, 'disk on line': this.diskOnLine, ratio: this.ratio, follower: this.follower, contact: this.contact,
      torsion: this.torsion, bushing: this.bushing, beam: this.beam, drag: this.drag, 'angle stop': this.angleStop, 'slide stop': this.slideStop,
      'distance stop': this.distanceStop, ground: this.ground, motor: this.motor, friction: this.friction, load: this.load };
    return drawn[kind];
  }
}
