'use strict';
// Draws the report from the data in the page.

const data = JSON.parse(document.getElementById('data').textContent);
const page = document.getElementById('page');
const runs = data.runs, several = runs.length > 1;
const charts = new Map();  // key of a curve -> uPlot
const plots = [];           // all of them
function plot(...arguments_) { const u = new uPlot(...arguments_); plots.push(u); return u; }
const swatch = i => h('span', { class: 'swatch', style: 'background:' + colour(i) });
const titles = { pull: 'Pull', draft: 'Draft of the soil', lift: 'Vertical force of the soil (up positive)', 'spring force': 'Spring force (compression positive)', pitch: 'Pitch', height: 'Height' };
const sections = [];
function section(id, title, note) {
  const s = h('section', { id }, h('h2', {}, title), note ? h('p', { class: 'note' }, note) : null);
  sections.push([id, title]);
  page.append(s);
  return s;
}
const interval = w => w.from === null ? '\u2013' : text(w.from) + ' \u2026 ' + text(w.until) + ' s';
const width = () => Math.max(320, page.clientWidth - (matchMedia('print').matches ? 0 : 56));

function drawHead() {
  page.replaceChildren(h('h1', {}, runs[0].title || runs[0].name),
    h('p', { class: 'note' }, (several ? runs.length + ' runs side by side; differences are against the first. ' : '') + 'Report of subsoil ' + data.version + '. All forces are in N and all times in s unless a unit stands beside.'));
  page.append(h('nav', {}));
  const s = section('runs', several ? 'Runs' : 'Run');
  const names = [...new Set(runs.flatMap(r => r.head.map(x => x[0])))];
  const value = (r, name) => { const f = r.head.find(x => x[0] === name); return f ? f[1] : '\u2013'; };
  s.append(h('div', { class: 'wide' }, h('table', {}, h('tr', {}, h('th', {}, ''), runs.map((r, i) => h('th', {}, swatch(i), r.name))),
    names.map(n => h('tr', {}, h('td', {}, n), runs.map(r => h('td', {}, value(r, n))))))));
  runs.forEach(r => {
    const prefix = several ? r.name + ': ' : '';
    if (r.warnings.length) s.append(h('ul', { class: 'box' }, r.warnings.map(w => h('li', {}, prefix + 'warning: ' + w))));
    if (r.missing.length) s.append(h('ul', { class: 'box missing' }, r.missing.map(w => h('li', {}, prefix + 'missing: ' + w))));
  });
}

// ---- film ----------------------------------------------------------------------------------------------------------

/// The page of `subsoil view` for a run, in a frame of this page.
class Film {
  constructor(run, number, parts) {
    this.run = run;
    this.number = number;
    this.frame = h('iframe', { class: 'film', title: 'film of ' + run.name });
    const scene = JSON.stringify({ ...run.scene, embedded: true }).replace(/</g, '\\u003c');
    this.loaded = new Promise(done => this.frame.addEventListener('load', done, { once: true }));
    this.frame.srcdoc = parts.before + scene + parts.after;
  }
  async ready() {
    await this.loaded;
    const root = this.frame.contentDocument;
    for (;;) {
      if (root.documentElement.dataset.ready === 'yes') break;
      const failure = root.querySelector('.failure');
      if (failure) throw new Error(failure.textContent);
      await new Promise(done => setTimeout(done, 20));
    }
    this.viewer = this.frame.contentWindow.subsoil;
    this.soil = this.viewer.soil;
  }
  get end() { return this.viewer.poses.end; }
  /// Side view of the soil at a time and of what stands above it as high as a good half of its depth; of a machine alone all.
  box(time) {
    const { viewer, soil } = this, whole = viewer.stage.bounds, { tool } = viewer.scene;
    if (!soil) return whole.clone();
    viewer.show(time);
    const box = soil.extent(), length = box.max.x - box.min.x, low = box.min.x, high = box.max.x;
    // The tool on its way to the soil and out of it, as far as a third of the bed.
    const way = tool && tool.axis === 0 && !soil.now.travelled ? tool.tip : [];
    box.min.x = Math.max(low - length / 3, Math.min(low, ...way) - 0.05 * length);
    box.max.x = Math.min(high + length / 3, Math.max(high, ...way) + 0.05 * length);
    box.max.y = Math.min(whole.max.y, box.min.y + 1.6 * ((tool ? tool.surface : box.max.y) - box.min.y));
    return box;
  }
  /// The slice through the tool; spheres beyond it are cut off.
  section() {
    const s = this.viewer.scene.spheres;
    return s ? { axis: 2, at: this.run.slice ?? 0.5 * (s.low[2] + s.high[2]), sign: 1 } : null;
  }
  still(time, wide, options) {
    const box = this.box(time), ratio = Math.min(0.75, Math.max(0.22, (box.max.y - box.min.y) / (box.max.x - box.min.x)));
    const width = Math.round(wide), height = Math.round(wide * ratio);
    const picture = this.viewer.still({ time, width, height, view: 'side', box, section: this.section(), ...options });
    return h('img', { class: 'still', src: picture, width, height, alt: this.run.name + ' at ' + text(time) + ' s, from the side' });
  }
  get colours() { return this.soil ? this.soil.colourings() : []; }
}

async function drawFilm() {
  const films = runs.flatMap((r, i) => r.scene ? [new Film(r, i, JSON.parse(document.getElementById('viewer').textContent))] : []);
  if (!films.length) return;
  const s = section('film', 'Film', 'Drag turns the picture, Ctrl or Shift with the wheel zooms, a click shows what a thing is.' + (films.length > 1 ? ' All runs show the same time.' : ''));
  s.append(h('div', { class: films.length > 1 ? 'grid2 screen' : 'screen' }, films.map(f => h('figure', {}, f.frame, several ? h('figcaption', {}, swatch(f.number), f.run.name) : null))));
  await Promise.all(films.map(f => f.ready()));
  let following = false;
  for (const f of films) f.viewer.timed.push(t => {
    if (following) return;
    following = true;
    for (const other of films) if (other !== f) other.viewer.show(Math.min(t, other.end));
    following = false;
  });
  for (const f of films) {
    f.viewer.stage.look('side');
    if (f.colours.includes('speed')) f.viewer.colour('speed');
  }
  films[0].viewer.show(Math.min(films[0].end, runs[0].window.until ?? films[0].end));
  drawStills(films);
  drawSections(films);
}

const key = (by, low, high) => h('div', { class: 'key' }, low, h('span', { class: 'scale', style: 'background:' + gradientOf(by) }), high);
const speedKey = f => key('speed', '0', text(f.soil.data.speedTop, 2) + ' m/s and more');

function drawStills(films) {
  const s = section('stills', 'Still frames', films.some(f => f.soil) ? 'Slice through the tool, from the side.' : 'From the side.');
  for (const f of films) {
    const by = f.colours.includes('speed') ? 'speed' : f.soil ? 'depth' : undefined;
    if (several) s.append(h('h3', {}, swatch(f.number), f.run.name));
    if (by === 'speed') s.append(speedKey(f));
    s.append(h('div', { class: 'grid3' }, f.run.stills.map(t => h('figure', {}, f.still(t, width() / 3, { colour: by }), h('figcaption', {}, 't = ' + text(t) + ' s')))));
  }
}

function drawSections(films) {
  const with_soil = films.filter(f => f.soil);
  if (!with_soil.length) return;
  const s = section('section', 'Speed, force chains and layers', 'The slice at the end of the window.');
  for (const f of with_soil) {
    const t = f.run.stills[f.run.stills.length - 1], w = width() / 2, data = f.viewer.scene.spheres;
    const figure = (words, options) => h('figure', {}, f.still(t, w, options), h('figcaption', {}, 't = ' + text(t) + ' s: ', words));
    if (several) s.append(h('h3', {}, swatch(f.number), f.run.name));
    s.append(h('div', { class: 'grid2' },
      f.colours.includes('speed') ? figure(speedKey(f), { colour: 'speed' }) : null,
      f.soil.hasChains ? figure('force chains, red where spheres press and blue where they pull, up to ' + text(data.chainTop, 2) + ' N; ' + data.chainNote, { chains: true, colour: 'plain' }) : null,
      figure(key('depth', 'lowest before the pass', 'highest'), { colour: 'depth' }),
      f.colours.includes('material') ? figure(data.materials.map((m, k) => h('span', {}, h('span', { class: 'swatch', style: 'background:' + colourOf(1 + k % 8) }), m + ' ')), { colour: 'material' }) : null));
  }
}

// ---- curves --------------------------------------------------------------------------------------------------------

/// The bands of all runs, each once, with the runs that it is of where these are not all.
function allBands() {
  const out = [];
  for (const r of runs) for (const b of r.bands || []) {
    const same = out.find(o => o.name === b.name && o.low === b.low && o.high === b.high && o.text === b.text);
    if (same) same.of.push(r.name); else out.push({ ...b, of: [r.name] });
  }
  for (const b of out) b.label = (b.of.length < runs.length ? b.of.join(', ') + ': ' : '') + b.name;
  return out;
}

/// Window, bands and the source's values under a curve, their names over the grid.
function hooks(key, factor) {
  const w = runs[0].window, bands = key === 'draft' ? allBands().filter(band => band.low !== undefined) : [];
  const marks = (data.source || []).filter(n => n.quantity === key && !n.statistic.startsWith('span'));
  const inPlot = (u, paint) => {
    const c = u.ctx, b = u.bbox;
    c.save();
    c.beginPath(); c.rect(b.left, b.top, b.width, b.height); c.clip();
    c.font = 11 * devicePixelRatio + 'px sans-serif';
    paint(c, b, t => Math.min(b.left + b.width, Math.max(b.left, u.valToPos(t, 'x', true))), v => u.valToPos(v, 'y', true));
    c.restore();
  };
  const areas = (c, b, x, y) => {
    if (w.from !== null && w.until !== null) { c.fillStyle = 'rgba(30,60,90,0.055)'; c.fillRect(x(w.from), b.top, x(w.until) - x(w.from), b.height); }
    bands.forEach((band, i) => {
      c.fillStyle = i % 2 ? 'rgba(0,135,90,0.13)' : 'rgba(176,85,154,0.11)';
      c.fillRect(b.left, y(band.high), b.width, y(band.low) - y(band.high));
    });
    c.strokeStyle = '#9c1c1c'; c.setLineDash([7, 5]); c.lineWidth = 1.3 * devicePixelRatio;
    for (const n of marks) { c.beginPath(); c.moveTo(b.left, y(n.value * factor)); c.lineTo(b.left + b.width, y(n.value * factor)); c.stroke(); }
  };
  const names = (c, b, x, y) => {
    const low = 13 * devicePixelRatio;
    bands.forEach((band, i) => {
      c.fillStyle = i % 2 ? '#00875a' : '#8c3c7a';
      const inside = y(band.low) > b.top && y(band.high) < b.top + b.height, where = y(band.low) <= b.top ? ' (above this range)' : ' (below this range)';
      c.fillText(band.label + (inside ? '' : where), b.left + 6 + (i % 2) * 330 * devicePixelRatio, (inside ? Math.max(b.top, y(band.high)) : b.top) + low * (1 + Math.floor(i / 2)));
    });
    c.fillStyle = '#9c1c1c';
    for (const n of marks) {
      const above = y(n.value * factor) - 5 > b.top + 12 * devicePixelRatio;
      c.fillText('source, ' + n.statistic.split(' ')[0] + ' ' + text(n.value * factor), b.left + 6, y(n.value * factor) + (above ? -5 : low));
    }
  };
  return { drawClear: [u => inPlot(u, areas)], draw: [u => inPlot(u, names)] };
}

function range(key, factor) {
  return (u, low, high) => {
    if (low === null || high === null) return [0, 1];
    for (const n of data.source || []) if (n.quantity === key && !n.statistic.startsWith('span')) { low = Math.min(low, n.value * factor); high = Math.max(high, n.value * factor); }
    const pad = 0.07 * (high - low) || 0.05 * Math.abs(high) || 1;
    return [low - pad, high + pad];
  };
}

function joined(pick, factor) {
  const tables = [], series = [];
  runs.forEach((r, i) => {
    const c = r.curves && pick(r);
    if (!c) return;
    tables.push([r.curves.time, factor === 1 ? c.values : c.values.map(v => v === null ? null : v * factor)]);
    series.push({ label: several ? r.name : (titles[c.key] || c.key), stroke: colour(i), width: 1.4, spanGaps: true });
  });
  return { data: tables.length > 1 ? uPlot.join(tables) : tables[0], series };
}

function drawCurves() {
  const keys = [...new Set(runs.flatMap(r => r.curves ? r.curves.columns.map(c => c.key) : []))];
  if (!keys.length) return;
  const s = section('curves', 'Curves', 'Hover for values; drag along the time axis to zoom, double click to see all. Shaded: the window of the numbers' + (several ? ' of the first run' : '') + '. Drawn are the rows of series.csv' + (runs.some(r => r.curves && r.curves.every > 1) ? ', every ' + Math.max(...runs.map(r => r.curves ? r.curves.every : 1)) + 'th' : '') + '.');
  allBands().forEach(b => s.append(h('p', { class: 'note' }, b.label + ': ' + (b.low === undefined ? 'not drawn; ' : text(b.low, 3) + ' \u2026 ' + text(b.high, 3) + ' N; ') + b.text + '.')));
  for (const key of keys) {
    const pick = r => r.curves.columns.find(c => c.key === key);
    const own = runs.map(r => r.curves && pick(r)).find(c => c).unit;
    const [factor, unit] = own === 'rad' ? handy(own, 1) : [1, own], j = joined(pick, factor);  // angles as in the tables
    const place = h('div', { class: 'chart', id: 'chart-' + key.replace(/[^\w]+/g, '-') });
    s.append(place);
    const label = unit === '1' ? '' : ' [' + unit + ']';
    charts.set(key, plot({
      width: width(), height: 210, title: (titles[key] || key) + label, cursor: { sync: { key: 'time' }, drag: { x: true, y: false } },
      scales: { x: { time: false }, y: { range: range(key, factor) } }, hooks: hooks(key, factor), legend: { live: true },
      axes: [{ label: null, values: (u, v) => v.map(t => text(t, 4) + ' s'), grid: { stroke: '#e4e7ea' } }, { size: 64, values: (u, v) => v.map(x => text(x, 5)), grid: { stroke: '#e4e7ea' } }],
      series: [{ label: 'time', value: (u, t) => t === null ? '\u2013' : t.toFixed(4) + ' s' }, ...j.series.map(x => ({ ...x, points: { show: false }, value: (u, v) => v === null || v === undefined ? '\u2013' : text(v, 5) + (unit === '1' ? '' : ' ' + unit) }))]
    }, j.data, place));
  }
}

// ---- furrow, energy ------------------------------------------------------------------------------------------------

function drawFurrow() {
  const some = runs.map((r, i) => ({ r, i })).filter(x => x.r.furrow);
  if (!some.length) return;
  const s = section('furrow', 'Furrow, disturbed soil, heave and mixing', 'Cross-section across the travel, mean over the stretch that the tool has passed, from the first frame to the last. Heights are of the highest sphere of a column one diameter wide.');
  const place = h('div', { class: 'chart' });
  s.append(place);
  const tables = [], series = [];
  some.forEach(({ r, i }) => {
    const f = r.furrow, mm = a => a.map(v => v === null ? null : 1e3 * v);
    tables.push([mm(f.z), mm(f.before), mm(f.after)]);
    series.push({ label: (several ? r.name + ', ' : '') + 'before', stroke: colour(i), dash: [6, 4], width: 1.2, spanGaps: true, points: { show: false } },
      { label: (several ? r.name + ', ' : '') + 'after', stroke: colour(i), width: 2, spanGaps: true, points: { show: false } });
  });
  const value = (u, v) => v === null || v === undefined ? '\u2013' : text(v, 4) + ' mm', across = some[0].r.furrow.across;
  plot({ width: width(), height: 230, title: 'Surface across the travel [mm]', scales: { x: { time: false } },
    axes: [{ label: null, values: (u, v) => v.map(place => across + ' ' + place + ' mm'), grid: { stroke: '#e4e7ea' } }, { size: 64, grid: { stroke: '#e4e7ea' } }],
    series: [{ label: across, value }, ...series.map(x => ({ ...x, value }))] }, tables.length > 1 ? uPlot.join(tables) : tables[0], place);
  const grid = h('div', { class: 'grid2' });
  some.forEach(({ r, i }) => grid.append(h('figure', {}, movedCanvas(r.furrow), h('figcaption', {}, several ? swatch(i) : null, (several ? r.name + ': ' : '') +
    'mean displacement by place before the pass, 0 \u2026 ' + text(movedLargest(r.furrow) * 1e3, 3) + ' mm; black line: disturbed, more than ' + text(1e3 * r.furrow.threshold, 3) + ' mm; ' + r.furrow.along + ' = ' + text(r.furrow.from) + ' \u2026 ' + text(r.furrow.until) + ' m' + (r.furrow.steady ? '.' : ' (the entry: too little steady work is passed).') +
    (r.furrow['reaches wall'] ? ' Disturbed soil reaches a wall: the bin is too small.' : r.furrow['reaches wall'] === false ? ' Disturbed soil reaches no wall.' : '')))));
  s.append(grid);
  some.forEach(({ r, i }) => s.append(h('h3', {}, several ? swatch(i) : null, (several ? r.name + ': ' : '') + 'Layers in the tool\u2019s way'), h('table', { class: 'zebra' },
    h('tr', {}, h('th', {}, 'layer before the pass'), h('th', { class: 'n' }, 'spheres'), h('th', { class: 'n' }, 'mean rise [mm]'), h('th', { class: 'n' }, 'mean way forward [mm]'), h('th', { class: 'n' }, 'now in another layer')),
    r.furrow.layers.map(l => h('tr', {}, h('td', {}, l.name), h('td', { class: 'n' }, String(l.spheres)), h('td', { class: 'n' }, text(1e3 * l.rise, 3)), h('td', { class: 'n' }, text(1e3 * l.forward, 3)), h('td', { class: 'n' }, text(100 * l['moved out'], 3) + ' %'))))));
}
const movedLargest = f => Math.max(2 * f.threshold, ...f.moved.filter(v => v !== null).sort((a, b) => a - b).slice(0, -1).slice(-1));
function movedCanvas(f) {
  const k = 24, c = h('canvas', { class: 'film', width: k * f.columns, height: k * f.rows }), g = c.getContext('2d'), top = movedLargest(f);
  g.fillStyle = '#fff'; g.fillRect(0, 0, c.width, c.height);
  const at = (row, col) => row < 0 || col < 0 || row >= f.rows || col >= f.columns ? null : f.moved[row * f.columns + col];
  for (let row = 0; row < f.rows; ++row) for (let col = 0; col < f.columns; ++col) {
    const v = at(row, col);
    if (v === null) continue;
    g.fillStyle = `rgb(${mixed(SCALES.displacement, v / top).join(',')})`;
    g.fillRect(col * k, (f.rows - 1 - row) * k, k, k);
  }
  g.strokeStyle = '#111'; g.lineWidth = 3;
  for (let row = 0; row < f.rows; ++row) for (let col = 0; col < f.columns; ++col) {
    if (!((at(row, col) ?? -1) > f.threshold)) continue;
    const x = col * k, y = (f.rows - 1 - row) * k, quiet = (r, q) => !((at(r, q) ?? -1) > f.threshold);
    g.beginPath();
    if (quiet(row, col - 1)) { g.moveTo(x, y); g.lineTo(x, y + k); }
    if (quiet(row, col + 1)) { g.moveTo(x + k, y); g.lineTo(x + k, y + k); }
    if (quiet(row + 1, col)) { g.moveTo(x, y); g.lineTo(x + k, y); }
    if (quiet(row - 1, col)) { g.moveTo(x, y + k); g.lineTo(x + k, y + k); }
    g.stroke();
  }
  return c;
}

function drawEnergy() {
  const some = runs.filter(r => r.energy || r['energy curves']);
  if (!some.length) return;
  const s = section('energy', 'Energy balance', 'What was put in, where it went, and what does not close; over the whole run.');
  const keys = [...new Set(runs.flatMap(r => r.energy ? Object.keys(r.energy) : []))];
  if (keys.length) s.append(h('div', { class: 'wide' }, h('table', { class: 'zebra' }, h('tr', {}, h('th', {}, ''), runs.map((r, i) => h('th', { class: 'n' }, swatch(i), r.name))),
    keys.map(k => h('tr', {}, h('td', {}, k), runs.map(r => h('td', { class: 'n' }, r.energy && r.energy[k] !== undefined ? (k.includes('over') ? text(100 * r.energy[k], 3) + ' %' : text(r.energy[k], 5)) : '\u2013')))))));
  runs.forEach((r, i) => {
    const e = r['energy curves'];
    if (!e || (several && i > 0)) return;
    const place = h('div', { class: 'chart' });
    s.append(place);
    plot({ width: width(), height: 280, title: 'Change of the energies since the start [J]' + (several ? ' of ' + r.name : ''), scales: { x: { time: false } }, cursor: { sync: { key: 'time' } },
      axes: [{ label: null, values: (u, v) => v.map(t => text(t, 4) + ' s'), grid: { stroke: '#e4e7ea' } }, { size: 64, grid: { stroke: '#e4e7ea' } }],
      series: [{ label: 'time', value: (u, t) => t === null ? '\u2013' : t.toFixed(4) + ' s' }, ...e.columns.map((c, k) => ({ label: c.key, stroke: colour(k), dash: k >= colours.length ? [5, 4] : undefined, width: 1.3, points: { show: false }, value: (u, v) => v === null ? '\u2013' : text(v, 4) + ' J' }))]
    }, [e.time, ...e.columns.map(c => c.values.map(v => v === null ? null : v - c.values[0]))], place);
  });
}

// ---- numbers -------------------------------------------------------------------------------------------------------

function drawSource() {
  if (!data.source) return;
  const s = section('source', 'Beside the source', 'Yuan & Yu (2020), figures 5 and 6: ranges over its whole plot, beside the same numbers over the whole record of each run (rows of series.csv). The ratio is ours over the source\u2019s.');
  const rows = data.source.map(n => {
    const row = data.table.find(t => t.quantity === n.quantity && t.statistic === n.statistic);
    const [factor, unit] = handy(n.unit, Math.abs(n.value));
    return h('tr', {}, h('td', {}, n.quantity + ', ' + n.statistic + ' [' + unit + ']'), h('td', { class: 'n' }, text(n.value * factor)),
      runs.map((r, i) => {
        const v = row && row.runs[i].value !== undefined ? row.runs[i].value : null, ratio = v === null ? null : v / n.value;
        return [h('td', { class: 'n' }, v === null ? '\u2013' : text(v * factor)), h('td', { class: 'n' + (ratio !== null && Math.abs(ratio - 1) > 0.2 ? ' far' : '') }, ratio === null ? '\u2013' : text(ratio, 3))];
      }));
  });
  s.append(h('div', { class: 'wide' }, h('table', { class: 'zebra' }, h('tr', {}, h('th', {}, 'quantity'), h('th', { class: 'n' }, 'source'), runs.map((r, i) => [h('th', { class: 'n' }, swatch(i), r.name), h('th', { class: 'n' }, 'ratio')])), rows)),
    h('p', { class: 'note' }, 'Red: more than 20 % off.'));
}

function drawNumbers() {
  const s = section('numbers', 'Numbers', 'Every number with the time it is taken over. \u00b1 is half of the 95 % interval of a mean over one record, which allows for the correlation of its rows; it says nothing of other packings.' + (several ? ' \u0394: difference against the first run, with the interval of both; bold where it lies outside.' : ''));
  const cells = (row, c, i, factor) => {
    if (c.value === undefined || c.value === null) return [h('td', { class: 'n' }, '\u2013'), i ? h('td', { class: 'n' }, '\u2013') : null, h('td', {}, '')];
    const pm = c['half width'] === null ? '' : ' \u00b1 ' + text(c['half width'] * factor, 2);
    const d = c.difference, dpm = c['difference half width'], clear = d !== undefined && d !== null && dpm !== null && Math.abs(d) > dpm;
    return [h('td', { class: 'n' }, text(c.value * factor) + pm),
      i ? h('td', { class: 'n', style: clear ? 'font-weight:700' : '' }, d === undefined || d === null ? '\u2013' : (d > 0 ? '+' : '') + text(d * factor, 3) + (dpm === null ? '' : ' \u00b1 ' + text(dpm * factor, 2))) : null,
      h('td', { class: 'n' }, interval({ from: c['from [s]'], until: c['until [s]'] }))];
  };
  if (several && runs.some(r => r.window.from !== runs[0].window.from || r.window.until !== runs[0].window.until))
    s.append(h('ul', { class: 'box' }, h('li', {}, 'The windows of the runs differ: differences compare different times. --from and --until give all the same.')));
  s.append(h('div', { class: 'wide' }, h('table', { class: 'zebra', id: 'table' },
    h('tr', {}, h('th', {}, 'quantity'), h('th', {}, 'statistic'), h('th', {}, 'unit'), runs.map((r, i) => [h('th', { class: 'n' }, swatch(i), r.name), i ? h('th', { class: 'n' }, '\u0394') : null, h('th', { class: 'n' }, 'window')])),
    data.table.map(row => {
      const [factor, unit] = handy(row.unit, Math.max(...row.runs.map(c => Math.abs(c.value ?? 0))));
      return h('tr', {}, h('td', {}, row.quantity), h('td', {}, row.statistic), h('td', {}, unit), row.runs.map((c, i) => cells(row, c, i, factor)));
    }))));
  s.append(h('div', { class: 'controls' }, h('button', { onclick: () => save('report.csv', csvTable(), 'text/csv') }, 'Save the table as CSV'),
    h('button', { onclick: () => save('report.json', JSON.stringify(data.table, null, 1), 'application/json') }, 'Save it as JSON')),
    h('p', { class: 'note screen' }, 'The table is also in this file as JSON: the element with id \u201cdata\u201d, key \u201ctable\u201d, in SI units.'));
}
function csvTable() {
  const lines = ['quantity,statistic,unit,run,value,half width,from [s],until [s],difference,difference half width'];
  for (const row of data.table) for (const c of row.runs)
    lines.push([row.quantity, row.statistic, row.unit, c.run, c.value, c['half width'], c['from [s]'], c['until [s]'], c.difference, c['difference half width']].map(v => v === null || v === undefined ? '' : field(String(v))).join(','));
  return lines.join('\n') + '\n';
}

/// `#probe=draft@0.25`: puts the cursor of a chart there; the value it shows stands in the page's data-probe.
function probe() {
  const m = /^#probe=(.+)@([-\d.eE]+)$/.exec(decodeURIComponent(location.hash));
  if (!m || !charts.has(m[1])) return;
  const u = charts.get(m[1]);
  u.setCursor({ left: u.valToPos(+m[2], 'x'), top: 20 });
  document.documentElement.dataset.probe = [...u.root.querySelectorAll('.u-legend .u-value')].map(e => e.textContent).join(' | ');
}

(async () => {
  document.documentElement.dataset.errors = 0;
  drawHead();
  let problem = null;
  try { await drawFilm(); } catch (e) { problem = e; }
  if (problem) section('film problem', 'Film', 'The film cannot be shown: ' + problem.message);
  drawCurves();
  drawSource();
  drawFurrow();
  drawEnergy();
  drawNumbers();
  page.querySelector('nav').append(...sections.map(([id, t]) => h('a', { href: '#' + id }, t)));
  let last = width();
  window.addEventListener('resize', () => { if (Math.abs(width() - last) < 20) return; last = width(); plots.forEach(u => u.setSize({ width: last, height: u.height })); });
  window.addEventListener('beforeprint', () => plots.forEach(u => u.setSize({ width: 670, height: u.height })));
  window.addEventListener('afterprint', () => plots.forEach(u => u.setSize({ width: width(), height: u.height })));
  requestAnimationFrame(() => setTimeout(() => { probe(); document.documentElement.dataset.ready = problem ? 'with problems' : 'yes'; }, 0));
})();
