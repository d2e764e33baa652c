'use strict';
// What the figures and tables of a report have in common, beside the helpers of the viewer.

const colours = ['#0b62a4', '#d1500a', '#00875a', '#b0559a', '#8a6d00', '#3aa0d8', '#6b4b2a', '#444444'];
const colour = i => colours[i % colours.length];

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
