'use strict';
// Small helpers, and the section through the soil as a film.

const errors = [];
window.addEventListener('error', e => { errors.push(String(e.message)); document.documentElement.dataset.errors = errors.length; });
window.addEventListener('unhandledrejection', e => { errors.push(String(e.reason)); document.documentElement.dataset.errors = errors.length; });

function h(tag, attributes, ...children) {
  const e = document.createElement(tag);
  for (const [k, v] of Object.entries(attributes || {})) {
    if (k.startsWith('on')) e.addEventListener(k.slice(2), v);
    else if (k === 'class') e.className = v;
    else if (v !== null && v !== undefined && v !== false) e.setAttribute(k, v);
  }
  for (const c of children.flat(Infinity)) if (c !== null && c !== undefined && c !== false) e.append(c);
  return e;
}
const colours = ['#0b62a4', '#d1500a', '#00875a', '#b0559a', '#8a6d00', '#3aa0d8', '#6b4b2a', '#444444'];
const colour = i => colours[i % colours.length];

/// Four digits, without a tail of zeros.
function text(v, digits = 4) {
  if (v === null || v === undefined || !isFinite(v)) return '\u2013';
  if (v === 0) return '0';
  const a = Math.abs(v);
  return a >= 1e6 || a < 1e-4 ? v.toExponential(digits - 1) : String(Number(v.toPrecision(digits)));
}
/// Units a reader takes in: factor and name, by the largest number to be shown.
function handy(unit, size) {
  if (unit === '1') return [1, ''];
  if (unit === 'rad') return [180 / Math.PI, 'deg'];
  if (unit === 'm' && size < 1) return [1e3, 'mm'];
  if (unit === 'm^2') return [1e4, 'cm\u00b2'];
  if (unit === 'N/m^2' || unit === 'Pa') return [1e-3, 'kPa'];
  return [1, unit];
}
function save(name, content, type) {
  const a = h('a', { href: URL.createObjectURL(new Blob([content], { type })), download: name });
  document.body.append(a); a.click(); a.remove();
}
const field = s => /[",\n]/.test(s) ? '"' + String(s).replace(/"/g, '""') + '"' : String(s);

async function unpack(base64) {
  if (typeof DecompressionStream === 'undefined') throw new Error('this browser cannot inflate: use one of 2023 or later');
  const bytes = Uint8Array.from(atob(base64), c => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Colour scales: 24 steps each.
const steps = 24;
function scale(stops) {
  const out = [];
  for (let i = 0; i < steps; ++i) {
    const x = i / (steps - 1) * (stops.length - 1), k = Math.min(stops.length - 2, Math.floor(x)), f = x - k;
    out.push('rgb(' + [0, 1, 2].map(c => Math.round(stops[k][c] + f * (stops[k + 1][c] - stops[k][c]))).join(',') + ')');
  }
  return out;
}
const scales = {
  speed: scale([[222, 218, 205], [148, 190, 190], [54, 140, 160], [38, 88, 150], [120, 40, 130], [200, 30, 60]]),
  depth: Array.from({ length: steps }, (_, i) => {
    const l = 80 - 46 * i / (steps - 1);
    return Math.floor(i / 4) % 2 ? 'hsl(30,32%,' + l + '%)' : 'hsl(205,26%,' + l + '%)';
  }),
  moved: scale([[238, 236, 230], [240, 205, 130], [225, 130, 60], [160, 40, 40]])
};
function gradient(name) { return 'linear-gradient(90deg,' + scales[name].join(',') + ')'; }

/// The packed film of a run, opened.
class Film {
  static async open(data) {
    const film = new Film();
    film.data = data;
    film.times = data.times;
    film.box = data.box;
    film.first = [0];
    for (const n of data.counts) film.first.push(film.first[film.first.length - 1] + n);
    film.total = film.first[film.first.length - 1];
    film.bytes = await unpack(data.spheres);
    film.places = await unpack(data['surface places']);
    film.chains = new Map();
    for (const s of data.stills) film.chains.set(s.frame, { pairs: s.pairs, bytes: await unpack(s.bytes) });
    let at = 0;
    film.surfaces = data.surfaces.map(s => { const first = at; at += s.vertices * 2 * (s.moves ? film.times.length : 1); return { ...s, first }; });
    film.half = at;
    film.extent();
    return film;
  }
  /// x and y of a sphere, m.
  x(i) { const b = this.box; return b[0] + (this.bytes[i] + 256 * this.bytes[this.total + i]) / 65535 * (b[2] - b[0]); }
  y(i) { const n = this.total, b = this.box; return b[1] + (this.bytes[2 * n + i] + 256 * this.bytes[3 * n + i]) / 65535 * (b[3] - b[1]); }
  vx(i) { return (this.bytes[4 * this.total + i] - 128) / 127 * this.data['v max']; }
  vy(i) { return (this.bytes[5 * this.total + i] - 128) / 127 * this.data['v max']; }
  r(i) { const r = this.data.radius; return r[0] + this.bytes[6 * this.total + i] / 255 * (r[1] - r[0]); }
  depth(i) { return 1 - this.bytes[7 * this.total + i] / 255; }  // 0 at the surface, 1 at the floor
  material(i) { return this.bytes[8 * this.total + i]; }
  vertex(s, frame, v, axis) {
    const k = s.first + (s.moves ? frame : 0) * 2 * s.vertices + axis * s.vertices + v, b = this.box;
    return b[axis] + (this.places[k] + 256 * this.places[this.half + k]) / 65535 * (b[axis + 2] - b[axis]);
  }
  /// Boxes of everything and of the soil with some air.
  extent() {
    const b = [Infinity, Infinity, -Infinity, -Infinity];
    for (let i = 0; i < this.total; ++i) {
      const x = this.x(i), y = this.y(i);
      if (x < b[0]) b[0] = x; if (x > b[2]) b[2] = x; if (y < b[1]) b[1] = y; if (y > b[3]) b[3] = y;
    }
    if (!this.total) { this.soil = this.box; return; }
    const length = b[2] - b[0], height = b[3] - b[1], near = [b[0], b[2]];
    // The tool on its way to the soil, as far as a third of the bed before it.
    for (const s of this.surfaces) {
      if (!s.moves || !(this.data.tool || []).includes(s.name)) continue;
      for (let f = 0; f < this.times.length; ++f)
        for (let v = 0; v < s.vertices; ++v) {
          if (this.vertex(s, f, v, 1) > b[3]) continue;
          near[0] = Math.max(b[0] - length / 3, Math.min(near[0], this.vertex(s, f, v, 0)));
          near[1] = Math.min(b[2] + length / 3, Math.max(near[1], this.vertex(s, f, v, 0)));
        }
    }
    this.soil = [near[0] - 0.02 * length, b[1] - 0.04 * height, near[1] + 0.02 * length, b[3] + 0.4 * height];
    this.used = new Set();
    for (let i = 0; i < this.total; ++i) this.used.add(this.material(i));
  }
  frame(time) {
    let best = 0;
    this.times.forEach((t, i) => { if (Math.abs(t - time) < Math.abs(this.times[best] - time)) best = i; });
    return best;
  }
}

/// A canvas that shows a film.
class FilmView {
  constructor(film, options) {
    this.film = film;
    this.options = { colour: 'speed', arrows: false, chains: false, machine: true, box: film.soil, vmax: film.data['v max'], ...options };
    this.canvas = h('canvas', { class: 'film' });
    this.at = 0;
    if (this.options.moves) this.mouse();
  }
  resize(width) {
    const b = this.options.box, ratio = Math.min(0.75, Math.max(0.22, (b[3] - b[1]) / (b[2] - b[0])));
    this.canvas.width = Math.round(2 * width);
    this.canvas.height = Math.round(2 * width * ratio);
    this.draw(this.at);
  }
  view() {
    const b = this.options.box, w = this.canvas.width, hgt = this.canvas.height;
    const k = Math.min(w / (b[2] - b[0]), hgt / (b[3] - b[1]));
    return { k, x: x => (x - b[0]) * k + (w - k * (b[2] - b[0])) / 2, y: y => hgt - (y - b[1]) * k - (hgt - k * (b[3] - b[1])) / 2 };
  }
  draw(frame) {
    this.at = frame;
    const c = this.canvas.getContext('2d'), v = this.view();
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.fillStyle = '#fff';
    c.fillRect(0, 0, this.canvas.width, this.canvas.height);
    this.spheres(c, v, frame);
    const chains = this.film.chains.get(frame);
    if (this.options.chains && chains) this.drawChains(c, v, frame, chains);
    this.drawSurfaces(c, v, frame);
    if (this.options.arrows) this.drawArrows(c, v, frame);
    this.drawScale(c, v);
  }
  bin(i) {
    const f = this.film, o = this.options;
    if (o.colour === 'depth') return Math.min(steps - 1, Math.floor(f.depth(i) * steps));
    if (o.colour === 'material') return f.material(i);
    if (o.colour === 'plain') return 0;
    return Math.min(steps - 1, Math.floor(Math.hypot(f.vx(i), f.vy(i)) / o.vmax * steps));
  }
  spheres(c, v, frame) {
    const f = this.film, bins = new Map();
    for (let i = f.first[frame]; i < f.first[frame + 1]; ++i) {
      const b = this.bin(i);
      if (!bins.has(b)) bins.set(b, []);
      bins.get(b).push(i);
    }
    for (const [b, list] of bins) {
      const o = this.options.colour;
      c.fillStyle = o === 'material' ? colour(b) : o === 'plain' ? '#e9e6df' : scales[o][b];
      c.beginPath();
      for (const i of list) {
        const x = v.x(f.x(i)), y = v.y(f.y(i)), r = Math.max(0.7, f.r(i) * v.k);
        c.moveTo(x + r, y);
        c.arc(x, y, r, 0, 2 * Math.PI);
      }
      c.fill();
    }
  }
  drawSurfaces(c, v, frame) {
    const f = this.film;
    f.surfaces.forEach((s, k) => {
      const tool = (f.data.tool || []).includes(s.name);
      if (s.triangles && s.moves && this.options.machine) {
        c.fillStyle = tool ? '#30363c' : 'rgba(90,104,118,0.32)';
        c.beginPath();
        for (let t = 0; t + 2 < s.triangles.length; t += 3) {
          const p = [0, 1, 2].map(j => [v.x(f.vertex(s, frame, s.triangles[t + j], 0)), v.y(f.vertex(s, frame, s.triangles[t + j], 1))]);
          // One sense of turning for all: overlapping faces then fill once.
          if ((p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) < (p[1][1] - p[0][1]) * (p[2][0] - p[0][0])) p.reverse();
          c.moveTo(...p[0]); c.lineTo(...p[1]); c.lineTo(...p[2]); c.closePath();
        }
        c.fill();
        if (s.thinned) { c.strokeStyle = c.fillStyle; c.lineWidth = 3; c.stroke(); }  // closes the gaps of a mesh of which a part is drawn
      } else if (s.triangles && !s.moves) {
        this.edges(c, v, frame, s);
      }
      if (s.segments && this.options.machine) {
        c.strokeStyle = s.name === 'machine links' ? '#c2410c' : '#4a545e';
        c.lineWidth = s.name === 'machine links' ? 5 : 2.4;
        c.beginPath();
        for (let e = 0; e + 1 < s.segments.length; e += 2) {
          c.moveTo(v.x(f.vertex(s, frame, s.segments[e], 0)), v.y(f.vertex(s, frame, s.segments[e], 1)));
          c.lineTo(v.x(f.vertex(s, frame, s.segments[e + 1], 0)), v.y(f.vertex(s, frame, s.segments[e + 1], 1)));
        }
        c.stroke();
      }
      if (!s.triangles && !s.segments && this.options.machine) {
        c.fillStyle = '#111';
        for (let p = 0; p < s.vertices; ++p) { c.beginPath(); c.arc(v.x(f.vertex(s, frame, p, 0)), v.y(f.vertex(s, frame, p, 1)), 4, 0, 2 * Math.PI); c.fill(); }
      }
    });
  }
  /// A surface that stands still: its edges, each once.
  edges(c, v, frame, s) {
    const f = this.film;
    c.strokeStyle = '#9aa4ad'; c.lineWidth = 1.5;
    c.beginPath();
    const b = [Infinity, Infinity, -Infinity, -Infinity];
    for (let p = 0; p < s.vertices; ++p) {
      const x = f.vertex(s, frame, p, 0), y = f.vertex(s, frame, p, 1);
      b[0] = Math.min(b[0], x); b[1] = Math.min(b[1], y); b[2] = Math.max(b[2], x); b[3] = Math.max(b[3], y);
    }
    c.rect(v.x(b[0]), v.y(b[3]), (b[2] - b[0]) * v.k, (b[3] - b[1]) * v.k);
    c.stroke();
  }
  drawChains(c, v, frame, chains) {
    const f = this.film, n = chains.pairs, b = chains.bytes, first = f.first[frame];
    const index = (k, end) => first + b[4 * n * end + k] + 256 * b[4 * n * end + n + k] + 65536 * b[4 * n * end + 2 * n + k];
    for (let level = -6; level <= 6; ++level) {  // pulled ones below, pressed ones above
      if (!level) continue;
      c.beginPath();
      for (let k = 0; k < n; ++k) {
        const share = (b[8 * n + k] - 128) / 127;
        if (Math.sign(share) * Math.ceil(Math.abs(share) * 6) !== level) continue;
        const i = index(k, 0), j = index(k, 1);
        c.moveTo(v.x(f.x(i)), v.y(f.y(i)));
        c.lineTo(v.x(f.x(j)), v.y(f.y(j)));
      }
      const a = Math.abs(level);
      c.strokeStyle = 'rgba(' + (level > 0 ? '140,20,30,' : '20,70,150,') + (0.25 + 0.125 * a) + ')';
      c.lineWidth = Math.max(0.8, a / 6 * 1.1 * f.data.radius[1] * v.k);
      c.stroke();
    }
  }
  /// Mean velocity of the spheres of a cell, an arrow each.
  drawArrows(c, v, frame) {
    const f = this.film, b = this.options.box, cell = Math.max(2.6 * f.data.radius[1], (b[2] - b[0]) / 44), cells = new Map();
    for (let i = f.first[frame]; i < f.first[frame + 1]; ++i) {
      const key = Math.floor(f.x(i) / cell) + ':' + Math.floor(f.y(i) / cell);
      const s = cells.get(key) || [0, 0, 0, 0, 0];
      s[0] += f.vx(i); s[1] += f.vy(i); s[2] += f.x(i); s[3] += f.y(i); s[4] += 1;
      cells.set(key, s);
    }
    c.strokeStyle = '#111'; c.lineWidth = 1.6;
    for (const s of cells.values()) {
      const vx = s[0] / s[4], vy = s[1] / s[4], speed = Math.hypot(vx, vy);
      if (speed < 0.02 * this.options.vmax) continue;
      const length = 1.3 * cell * Math.min(1.4, speed / this.options.vmax) / speed * v.k;
      const x = v.x(s[2] / s[4]), y = v.y(s[3] / s[4]), dx = vx * length, dy = -vy * length, n = Math.hypot(dx, dy);
      const tip = Math.min(7, 0.4 * n) / n;
      c.beginPath();
      c.moveTo(x, y); c.lineTo(x + dx, y + dy);
      c.lineTo(x + dx - tip * (dx + 0.5 * dy), y + dy - tip * (dy - 0.5 * dx));
      c.moveTo(x + dx, y + dy);
      c.lineTo(x + dx - tip * (dx - 0.5 * dy), y + dy - tip * (dy + 0.5 * dx));
      c.stroke();
    }
  }
  drawScale(c, v) {
    const b = this.options.box, wanted = (b[2] - b[0]) / 6, p = 10 ** Math.floor(Math.log10(wanted));
    const length = [1, 2, 5].map(k => k * p).filter(l => l <= wanted).pop();
    const x = 16, y = 22, w = length * v.k;
    c.fillStyle = 'rgba(255,255,255,0.8)'; c.fillRect(6, 4, w + 96, 34);
    c.strokeStyle = c.fillStyle = '#222'; c.lineWidth = 2;
    c.beginPath(); c.moveTo(x, y - 6); c.lineTo(x, y + 6); c.moveTo(x, y); c.lineTo(x + w, y); c.moveTo(x + w, y - 6); c.lineTo(x + w, y + 6); c.stroke();
    c.font = '22px sans-serif'; c.fillText(length >= 1 ? length + ' m' : Math.round(length * 1000) + ' mm', x + w + 10, y + 8);
  }
  mouse() {
    const c = this.canvas;
    let from = null;
    const zoom = (k, px, py) => {
      const v = this.view(), b = this.options.box, x = b[0] + (px - v.x(b[0])) / v.k, y = b[1] + (v.y(b[1]) - py) / v.k;
      this.options.box = [x + (b[0] - x) * k, y + (b[1] - y) * k, x + (b[2] - x) * k, y + (b[3] - y) * k];
      this.draw(this.at);
    };
    const place = e => [e.offsetX * c.width / c.clientWidth, e.offsetY * c.height / c.clientHeight];
    c.addEventListener('wheel', e => { if (!e.ctrlKey && !e.shiftKey) return; e.preventDefault(); zoom(e.deltaY > 0 ? 1.2 : 1 / 1.2, ...place(e)); }, { passive: false });
    c.addEventListener('pointerdown', e => { from = place(e); c.setPointerCapture(e.pointerId); });
    c.addEventListener('pointerup', () => { from = null; });
    c.addEventListener('pointermove', e => {
      if (!from) return;
      const to = place(e), k = this.view().k, dx = (from[0] - to[0]) / k, dy = (to[1] - from[1]) / k, b = this.options.box;
      this.options.box = [b[0] + dx, b[1] + dy, b[2] + dx, b[3] + dy];
      from = to;
      this.draw(this.at);
    });
    c.addEventListener('dblclick', () => { this.options.box = this.film.soil; this.draw(this.at); });
  }
}
