'use strict';
// Draws the page of a sweep or of a credibility study from the data in it.

const data = JSON.parse(document.getElementById('data').textContent);
const page = document.getElementById('page');
const svgNames = 'http://www.w3.org/2000/svg';
function g(tag, attributes, ...children) {
  const e = document.createElementNS(svgNames, tag);
  for (const [k, v] of Object.entries(attributes)) e.setAttribute(k, v);
  e.append(...children.filter(c => c !== null));
  return e;
}
const wordsOf = p => data.parameters.map((n, k) => n + ' = ' + p.values[k]).join(', ');
const numberLabel = k => (data['number labels'] || data.numbers)[k], parameterLabel = k => (data['parameter labels'] || data.parameters)[k];
const pm = (v, half) => text(v, 5) + (half === null || half === undefined ? '' : ' \u00b1 ' + text(half, 2));

/// Points, and means with intervals, of one number over one parameter.
function effectChart(e) {
  const w = 360, hgt = 230, left = 62, bottom = 40, top = 12, right = 12;
  const points = data.points.filter(p => p.end === 'reached' && p.value[e.number] !== null);
  const wordsOnly = points.some(p => p.places[e.parameter] === null);
  const names = [...new Set(points.map(p => p.values[e.parameter]))];
  const place = p => wordsOnly ? names.indexOf(p.values[e.parameter]) : p.places[e.parameter];
  const xs = points.map(place), ys = points.flatMap(p => [p.value[e.number] - (p['half width'][e.number] ?? 0), p.value[e.number] + (p['half width'][e.number] ?? 0)]);
  for (const l of e.levels) if (l['half width'] !== null) ys.push(l.mean - l['half width'], l.mean + l['half width']);
  const range = a => { const lo = Math.min(...a), hi = Math.max(...a), pad = 0.08 * (hi - lo) || 0.05 * Math.abs(hi) || 1; return [lo - pad, hi + pad]; };
  const [x0, x1] = range(xs), [y0, y1] = range(ys);
  const X = x => left + (x - x0) / (x1 - x0) * (w - left - right), Y = y => hgt - bottom - (y - y0) / (y1 - y0) * (hgt - top - bottom);
  const s = g('svg', { viewBox: '0 0 ' + w + ' ' + hgt, width: '100%', style: 'max-width:' + w + 'px;font:11px sans-serif' });
  for (let k = 0; k <= 4; ++k) {
    const y = y0 + (y1 - y0) * k / 4;
    s.append(g('line', { x1: left, x2: w - right, y1: Y(y), y2: Y(y), stroke: '#e4e7ea' }), g('text', { x: left - 6, y: Y(y) + 4, 'text-anchor': 'end' }, text(y, 4)));
  }
  const marks = wordsOnly ? names.map((n, i) => [i, n]) : (names.length <= 6 ? names.map(n => [points.find(p => p.values[e.parameter] === n).places[e.parameter], n]) : [0, 1, 2, 3].map(k => { const x = Math.min(...xs) + (Math.max(...xs) - Math.min(...xs)) * k / 3; return [x, text(x, 3)]; }));
  for (const [x, n] of marks) s.append(g('text', { x: X(x), y: hgt - bottom + 16, 'text-anchor': 'middle' }, String(n).length > 14 ? String(n).slice(0, 13) + '\u2026' : String(n)));
  s.append(g('text', { x: (left + w - right) / 2, y: hgt - 6, 'text-anchor': 'middle', 'font-weight': 'bold' }, parameterLabel(e.parameter)));
  for (const p of points) {
    const half = p['half width'][e.number];
    if (half !== null && half !== undefined) s.append(g('line', { x1: X(place(p)), x2: X(place(p)), y1: Y(p.value[e.number] - half), y2: Y(p.value[e.number] + half), stroke: '#0b62a4', 'stroke-opacity': 0.45 }));
    s.append(g('circle', { cx: X(place(p)), cy: Y(p.value[e.number]), r: 3.4, fill: '#0b62a4', 'fill-opacity': 0.45 }, g('title', {}, wordsOf(p) + ': ' + pm(p.value[e.number], p['half width'][e.number]))));
  }
  const path = [];
  for (const l of e.levels) {
    const x = X(wordsOnly ? names.indexOf(l.value) : l.place), y = Y(l.mean);
    path.push((path.length ? 'L' : 'M') + x + ' ' + y);
    if (l['half width'] !== null) s.append(g('line', { x1: x, x2: x, y1: Y(l.mean - l['half width']), y2: Y(l.mean + l['half width']), stroke: '#d1500a', 'stroke-width': 2 }));
    s.append(g('circle', { cx: x, cy: y, r: 4.5, fill: '#d1500a' }, g('title', {}, l.value + ': mean ' + pm(l.mean, l['half width']) + ' of ' + l.count)));
  }
  if (path.length > 1 && !wordsOnly) s.append(g('path', { d: path.join(' '), stroke: '#d1500a', fill: 'none', 'stroke-width': 1.2 }));
  return h('figure', {}, s, h('figcaption', {}, e.slope === null ? 'no plane through these points' : 'from least to largest: ' + (e.slope > 0 ? '+' : '') + pm(e.slope, e['slope half'])));
}

function drawPoints() {
  const failed = data.points.filter(p => p.end === 'failed').length, open = data.points.filter(p => p.end === 'open').length;
  page.append(h('h2', { id: 'points' }, 'Points'), h('p', { class: 'note' }, data.points.length + ' points, ' + failed + ' failed, ' + open + ' not run. \u00b1 is half of the 95 % interval of a mean over its own record.'));
  page.append(h('div', { class: 'wide' }, h('table', { class: 'zebra', id: 'table' },
    h('tr', {}, h('th', { class: 'n' }, 'point'), data.parameters.map(p => h('th', {}, p)), data.numbers.map((n, k) => h('th', { class: 'n' }, numberLabel(k))), h('th', { class: 'n' }, 'wall time [s]'), h('th', {}, 'end')),
    data.points.map((p, i) => h('tr', { class: p.end === 'failed' ? 'failed' : '' }, h('td', { class: 'n' }, String(i + 1)), p.values.map(v => h('td', {}, v)), data.numbers.map((n, k) => h('td', { class: 'n' }, pm(p.value[k], p['half width'][k]))),
      h('td', { class: 'n' }, text(p['wall time'], 3)), h('td', {}, p.end + (p.cause ? ': ' + p.cause : '')))))));
}

function drawVerdicts() {
  const c = data.credibility;
  page.append(h('h2', {}, 'Verdicts'), h('p', { class: 'note' }, c.note));
  page.append(h('div', { class: 'wide' }, h('table', { class: 'zebra', id: 'verdicts' },
    h('tr', {}, ['axis', 'number', 'as given', 'changed', 'change', 'uncertainty', 'verdict'].map((n, k) => h('th', { class: k > 1 && k < 6 ? 'n' : '' }, n))),
    c.rows.map(r => h('tr', { class: r.verdict.startsWith('not converged') || r.verdict.startsWith('failed') ? 'failed' : '' }, h('td', {}, r.axis), h('td', {}, r.number), h('td', { class: 'n' }, r.base), h('td', { class: 'n' }, r.changed), h('td', { class: 'n' }, r.change), h('td', { class: 'n' }, r.uncertainty), h('td', {}, r.verdict))))));
  for (const line of c.lines) page.append(h('p', {}, line));
}

document.documentElement.dataset.errors = 0;
page.replaceChildren(h('h1', {}, data.title || data.scenario), h('p', { class: 'note' }, 'subsoil ' + data.version + ', scenario ' + data.scenario));
if (data.credibility) drawVerdicts();
if (data.best) {
  const p = data.points[data.best.point];
  page.append(h('h2', {}, 'Best point'), h('p', { id: 'best' }, (data.best.largest ? 'Largest ' : 'Least ') + data.numbers[data.best.number] + ': ' + pm(p.value[data.best.number], p['half width'][data.best.number]) + ' at point ' + (data.best.point + 1) + ' (' + wordsOf(p) + ').'));
}
if (!data.credibility) {
  page.append(h('h2', {}, 'Main effects'), h('p', { class: 'note' }, 'Blue: points; orange: means at a value with their 95 % interval over the points that have it. Below: change of the number from the least to the largest value of the parameter, the other numeric ones held, by a least squares plane.'));
  data.numbers.forEach((n, k) => page.append(h('h3', {}, numberLabel(k)), h('div', { class: 'grid3' }, data.effects.filter(e => e.number === k).map(effectChart))));
}
drawPoints();
document.documentElement.dataset.ready = 'yes';
