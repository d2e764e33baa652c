// @ts-check
'use strict';
// The panel beside the picture: what there is, what `check` warns of, what is monitored, and the values of what is selected.

const KINDS = /** @type {const} */ ([['body', 'Bodies'], ['joint', 'Joints'], ['driver', 'Drivers'], ['force', 'Forces'], ['marker', 'Markers'],
  ['surface', 'Surfaces'], ['boundary', 'Boundaries'], ['container', 'Container'], ['bed', 'Bed']]);

class Panel {
  /** @param {Scene} scene @param {(thing: number) => void} choose */
  constructor(scene, choose) {
    this.scene = scene;
    this.choose = choose;
    /** @type {Map<number, HTMLElement>} */
    this.buttons = new Map();
    this.details = h('section', { class: 'details', 'aria-live': 'polite', 'aria-label': 'selection' }, h('p', { class: 'note' }, 'Click a thing, or choose it below.'));
    this.warningBox = h('div', {}, this.warnings());
    this.root = h('aside', { class: 'panel', 'aria-label': 'contents' }, this.details, this.warningBox, this.monitorList(), this.lists(), this.notes());
  }
  /** @param {number} thing @param {any} [words] */
  button(thing, words) {
    const t = this.scene.things[thing];
    const b = h('button', { type: 'button', class: 'item', onclick: () => this.choose(thing), title: t.path }, words || t.name);
    if (!this.buttons.has(thing)) this.buttons.set(thing, b);
    return b;
  }
  warnings() {
    const list = this.scene.warnings;
    if (!list.length) return this.scene.mode === 'show' ? h('p', { class: 'fine' }, 'No warnings.') : null;
    return h('section', { class: 'warnings' }, h('h2', {}, `Warnings (${list.length})`), h('ol', {}, list.map(w =>
      h('li', {}, w.text, w.things.map(t => [' ', this.button(t, '\u25b8 ' + this.scene.things[t].name)])))));
  }
  /** After `scene.warnings` has changed. */
  renewWarnings() {
    const now = this.warnings();
    this.warningBox.replaceChildren(...(now ? [now] : []));
  }
  monitorList() {
    const list = this.scene.monitors;
    if (!list.length) return null;
    return h('section', {}, h('h2', {}, 'Monitors'), h('ul', { class: 'plain' }, list.map(m =>
      h('li', {}, this.button(m.thing), h('span', { class: 'note' }, ` ${m.unit ? `[${m.unit}] ` : ''}${m.words}`)))));
  }
  lists() {
    return KINDS.map(([kind, title]) => {
      const all = this.scene.things.map((t, i) => ({ t, i })).filter(({ t }) => t.kind === kind);
      if (!all.length) return null;
      return h('details', { open: all.length <= 12 }, h('summary', {}, `${title} (${all.length})`),
        h('div', { class: 'items' }, all.map(({ t, i }) => this.button(i, [this.swatch(t, i), t.name]))));
    });
  }
  /** @param {Thing} t @param {number} i */
  swatch(t, i) {
    if (t.kind !== 'body') return null;
    return h('span', { class: 'swatch', style: `background:${colourOf(this.scene.bodies.findIndex(b => b.thing === i))}` });
  }
  notes() { return this.scene.notes.length ? h('section', {}, h('h2', {}, 'Notes'), h('ul', {}, this.scene.notes.map(n => h('li', { class: 'note' }, n)))) : null; }
  /** @param {number} thing */
  select(thing) {
    this.buttons.forEach((b, i) => b.setAttribute('aria-pressed', String(i === thing)));
    const t = this.scene.things[thing];
    if (!t) return this.words('', '', 'Click a thing, or choose it below.');
    this.words(`${t.kind} ${t.name}`, t.place, t.values);
  }
  /** @param {string} title @param {string} place @param {string} values */
  words(title, place, values) {
    this.details.replaceChildren(...[title && h('h2', {}, title), place && h('p', { class: 'place' }, h('code', {}, place)), h('pre', {}, values)].filter(Boolean));
  }
}
