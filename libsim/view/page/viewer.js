// @ts-check
'use strict';
// Puts picture, panel, time and curves together.

const FURROW = 'furrow profile';

/** Surroundings: container, region of the bed, paths over the run. */
class Surroundings {
  /** @param {Scene} scene @param {Poses} poses @param {MachineView} machine */
  constructor(scene, poses, machine) {
    this.root = new THREE.Group();
    this.container = new THREE.Group();
    this.bed = new THREE.Group();
    this.paths = new THREE.Group();
    this.root.add(this.container, this.bed, this.paths);
    if (scene.container) this.addContainer(scene.container);
    if (scene.bed) this.addBed(scene.bed);
    if (poses.times.length > 1) this.addPaths(scene, poses, machine);
  }
  /** @param {V3[]} points @param {string} colour @param {boolean} [dashed] @param {number} [dash] m */
  lines(points, colour, dashed = false, dash = 0.02) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(points.flat()), 3));
    const material = dashed ? new THREE.LineDashedMaterial({ color: colour, dashSize: dash, gapSize: dash }) : new THREE.LineBasicMaterial({ color: colour });
    const lines = new THREE.LineSegments(geometry, material);
    if (dashed) lines.computeLineDistances();
    return lines;
  }
  /** @param {Container} c */
  addContainer(c) {
    const dash = 0.02 * Math.max(...c.high.map((v, i) => v - c.low[i]));
    c.faces.forEach((face, k) => {
      const axis = k >> 1, u = (axis + 1) % 3, v = (axis + 2) % 3, at = k & 1 ? c.high[axis] : c.low[axis];
      const corner = (/** @type {number} */ a, /** @type {number} */ b) => {
        const p = /** @type {V3} */ ([0, 0, 0]);
        p[axis] = at, p[u] = a ? c.high[u] : c.low[u], p[v] = b ? c.high[v] : c.low[v];
        return p;
      };
      const ring = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)], edges = ring.flatMap((p, i) => [p, ring[(i + 1) % 4]]);
      const colour = { wall: '#5c666f', open: '#9aa5ad', periodic: '#1565c0', moving: '#c77700' }[face.state] || '#5c666f';
      this.container.add(this.lines(edges, colour, face.state === 'open', dash));
      if (face.state !== 'open') this.container.add(this.face(ring, colour, 0.07));
    });
  }
  /** @param {V3[]} ring @param {string} colour @param {number} opacity */
  face(ring, colour, opacity) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(ring.flat()), 3));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    return new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ color: colour, transparent: true, opacity, side: THREE.DoubleSide, depthWrite: false }));
  }
  /** Region that will be filled, its surface and its layers. @param {Bed} bed */
  addBed(bed) {
    const { low, high } = bed, level = (/** @type {number} */ y) => /** @type {V3[]} */ ([[low[0], y, low[2]], [high[0], y, low[2]], [high[0], y, high[2]], [low[0], y, high[2]]]);
    const top = bed.surface === null ? high[1] : bed.surface;
    const slabs = bed.layers.length ? bed.layers.map(l => [Math.max(l.until, low[1]), l.from]) : [[low[1], top]];
    slabs.forEach(([from, until], i) => {
      const box = new THREE.BoxGeometry(high[0] - low[0], Math.max(until - from, 1e-9), high[2] - low[2]);
      box.translate((low[0] + high[0]) / 2, (from + until) / 2, (low[2] + high[2]) / 2);
      const colour = bed.layers.length > 1 ? colourOf(1 + i) : SOIL_COLOUR;
      this.bed.add(new THREE.Mesh(box, new THREE.MeshStandardMaterial({ color: colour, transparent: true, opacity: 0.35, depthWrite: false })));
    });
    const ring = level(top);
    this.bed.add(this.lines(ring.flatMap((p, i) => [p, ring[(i + 1) % 4]]), '#6b4b2a'));
  }
  /** Paths of the lowest point of what moves in the soil, and of markers. @param {Scene} scene @param {Poses} poses @param {MachineView} machine */
  addPaths(scene, poses, machine) {
    const add = (/** @type {V3[]} */ points, /** @type {string} */ colour) => {
      const far = points.some(p => Math.hypot(p[0] - points[0][0], p[1] - points[0][1], p[2] - points[0][2]) > 1e-6 * scene.size);
      if (far) this.paths.add(this.lines(points.slice(1).flatMap((p, i) => [points[i], p]), colour));
    };
    for (const s of scene.symbols)
      if (s.kind === 'marker') add(poses.times.map(t => /** @type {V3} */ ([...poses.point(s.a, s.pa, t), 0])), '#7a00c4');
    machine.show(poses.begin);
    for (const mesh of machine.pickable) {
      const data = scene.meshes.find(m => m.thing === mesh.userData.thing);
      if (!data || !data.touches || (data.body < 0 && data.path < 0)) continue;
      const p = this.lowest(mesh);
      add(poses.times.map(t => this.placed(poses, data, p, t)), colourOf(Math.max(0, data.body)));
    }
    scene.bodies.forEach((b, i) => {
      if (i > 0) add(poses.times.map(t => { const [x, y] = poses.body(i, t); return /** @type {V3} */ ([x, y, 0]); }), '#a5b0ba');
    });
  }
  /** Lowest vertex now, in the axes of its carrier. @param {import('three').Mesh} mesh */
  lowest(mesh) {
    const all = mesh.geometry.getAttribute('position'), p = new THREE.Vector3(), best = new THREE.Vector3();
    let least = Infinity;
    for (let i = 0; i < all.count; ++i) {
      p.fromBufferAttribute(all, i).applyMatrix4(mesh.matrixWorld);
      if (p.y < least) least = p.y, best.fromBufferAttribute(all, i);
    }
    return best;
  }
  /** @param {Poses} poses @param {MeshData} data @param {import('three').Vector3} p @param {number} t @returns {V3} */
  placed(poses, data, p, t) {
    if (data.body >= 0) return [...poses.point(data.body, [p.x, p.y], t), p.z];
    const { place, turn } = poses.path(data.path, t);
    return /** @type {V3} */ (p.clone().applyQuaternion(turn).add(place).toArray());
  }
}

class Viewer {
  /** @param {Scene} scene */
  constructor(scene) {
    this.scene = scene;
    this.time = 0;
    this.selected = -1;
    this.playing = false;
    /** Called when another time is shown. @type {((t: number) => void)[]} */
    this.timed = [];
  }
  async build() {
    const { scene } = this, motion = scene.motion;
    const meshes = await Promise.all(scene.meshes.map(async m => ({ vertices: await floats(m.vertices), triangles: await words(m.triangles), open: await words(m.open) })));
    this.poses = new Poses(motion, await floats(motion.bodies), await floats(motion.poses), scene.bodies.length);
    this.served = scene.served ? new Served(this) : null;
    this.soil = scene.spheres ? await Soil.open(scene.spheres, this.served && Served.frame) : null;
    this.series = scene.series ? await this.opened(scene.series) : null;
    const holder = h('div', { class: 'stage' });
    this.panel = new Panel(scene, t => this.select(t));
    this.frame = h('div', { class: 'page' }, this.header(), h('div', { class: 'middle' }, this.panel.root, holder), this.timeBar());
    const page = /** @type {HTMLElement} */ (document.getElementById('page'));
    page.replaceChildren(this.frame);
    this.stage = new Stage(holder);
    if (scene.embedded) document.documentElement.classList.add('embedded'), this.stage.leaveTheWheel();
    this.stage.canvas.setAttribute('role', 'img');
    this.stage.canvas.setAttribute('aria-label', `${scene.title}: picture of the scene; drag turns it, the wheel zooms, 1 to 4 choose views`);
    this.machine = new MachineView(scene, this.poses, meshes);
    this.around = new Surroundings(scene, this.poses, this.machine);
    this.stage.scene.add(this.machine.root, this.around.root);
    if (this.soil) this.stage.scene.add(this.soil.mesh, this.soil.chains.mesh), this.stage.soil = this.soil;
    this.overlay = new Overlay(scene, this.stage, this.poses, t => this.select(t));
    this.overlay.placeOf = t => this.placeOf(t);
    this.overlay.depthOf = body => /** @type {MachineView} */ (this.machine).depthOf(body);
    this.forceColumns();
    this.controls(holder);
    this.show(this.poses.begin);
    this.stage.bounds = this.bounds();
    this.chart();
    this.stage.look('oblique');
    this.address();
    this.stage.drawNow();
    if (this.soil) this.soil.arrived = () => { this.surroundingsFollow(); this.colour(this.colourChoice.value); this.stage && this.stage.draw(); };
    if (this.served) this.served.follow();
    document.documentElement.dataset.ready = 'yes';
  }
  /** @param {SeriesData} series */
  async opened(series) {
    return { time: await doubles(series.time), columns: await Promise.all(series.columns.map(async c => ({ ...c, values: await doubles(c.values) }))) };
  }
  /** Rows that a run has written meanwhile. @param {SeriesData} series */
  async takeSeries(series) {
    this.series = await this.opened(series);
    this.forceColumns();
    const column = this.plot && !this.plot.isFurrow && this.series.columns.find(c => c.name === this.plotted);
    if (column) this.plot.setData([this.series.time, column.values]);
  }
  /** What follows # in the address: view, time (or end), colour, section (x, y or z), select, hide (layers), and bare, which leaves the picture alone. */
  address() {
    const wanted = new URLSearchParams(location.hash.slice(1)), stage = /** @type {Stage} */ (this.stage), overlay = /** @type {Overlay} */ (this.overlay);
    if (wanted.has('bare')) document.documentElement.classList.add('bare'), stage.resize();
    for (const layer of (wanted.get('hide') || '').split(',')) if (layer) overlay.layers[layer] = false;
    if (wanted.has('time')) this.show(wanted.get('time') === 'end' ? /** @type {Poses} */ (this.poses).end : Number(wanted.get('time')));
    const section = 'xyz'.indexOf(wanted.get('section') || '?'), middle = stage.bounds.getCenter(new THREE.Vector3());
    if (section >= 0) stage.cut({ axis: section, at: middle.getComponent(section), sign: 1 });
    const view = wanted.get('view') || 'oblique', colour = wanted.get('colour');
    if (view in PRESETS) stage.look(view);
    if (colour && this.soil && this.soil.colourings().includes(colour)) this.colour(colour);
    if (wanted.has('select')) this.select(this.scene.things.findIndex(t => t.name === wanted.get('select')));
  }
  /** Where a surface, the container or the bed is. @param {number} thing */
  placeOf(thing) {
    const box = [this.scene.container, this.scene.bed].find(b => b && b.thing === thing);
    if (box) return new THREE.Vector3((box.low[0] + box.high[0]) / 2, box.high[1], (box.low[2] + box.high[2]) / 2);
    const bed = this.scene.things[thing], s = this.scene.spheres;
    if (bed && bed.kind === 'bed' && s) return new THREE.Vector3((s.low[0] + s.high[0]) / 2, s.high[1], (s.low[2] + s.high[2]) / 2);
    return /** @type {MachineView} */ (this.machine).centre(thing);
  }
  /** @param {import('three').Box3} box @param {{ low: number[], high: number[] }} b */
  expand(box, b) { return box.expandByPoint(new THREE.Vector3(...b.low)).expandByPoint(new THREE.Vector3(...b.high)); }
  bounds() {
    const box = /** @type {MachineView} */ (this.machine).bounds(), poses = /** @type {Poses} */ (this.poses);
    // Where joints and forces hold on to the ground; sides without ends have no place of their own.
    for (const k of this.scene.symbols)
      if (!['side', 'ground', 'disk on line'].includes(k.kind))
        for (const [x, y] of [poses.point(k.a, k.pa, poses.begin), poses.point(k.b, k.pb, poses.begin)]) box.expandByPoint(new THREE.Vector3(x, y, 0));
    for (const b of [this.scene.container, this.scene.bed]) if (b) this.expand(box, b);
    if (this.soil && this.served) this.expand(box, this.soil.data);
    else if (this.soil) {
      // Where the soil is at both ends of the run.
      this.show(poses.end);
      box.union(this.soil.extent());
      this.show(poses.begin);
      box.union(this.soil.extent());
    }
    // Paths are seen whole, unless they lead so far away that the machine would be small.
    const paths = new THREE.Box3().setFromObject(/** @type {Surroundings} */ (this.around).paths), size = new THREE.Vector3();
    const machine = /** @type {MachineView} */ (this.machine);
    machine.show(poses.end);
    paths.union(machine.bounds());
    machine.show(this.time);
    const both = box.clone().union(paths), before = box.getSize(size).length();
    if (!paths.isEmpty() && both.getSize(size).length() < 2 * before) box.copy(both);
    if (box.isEmpty()) box.set(new THREE.Vector3(-1, -1, -1), new THREE.Vector3(1, 1, 1));
    return box;
  }
  header() {
    const s = this.scene;
    return h('header', {}, h('h1', {}, s.title), h('span', { class: 'note' }, `${s.mode === 'show' ? 'set-up' : 'results'} \u00b7 ${s.file} \u00b7 subsoil ${s.version}`), this.served && this.served.status);
  }
  timeBar() {
    const p = /** @type {Poses} */ (this.poses), many = p.times.length > 1;
    this.clock = h('output', { class: 'clock', for: 'time' }, '');
    this.slider = h('input', { type: 'range', id: 'time', 'aria-label': 'time, s', min: p.begin, max: p.end || 1, step: 'any', value: p.begin,
      oninput: (/** @type {any} */ e) => this.show(Number(e.target.value)) });
    this.playButton = h('button', { type: 'button', 'aria-label': 'play', onclick: () => this.play(!this.playing) }, '\u25b6');
    this.speed = h('select', { 'aria-label': 'speed of the film' }, [1, 0.5, 0.2, 0.1, 0.01].map(v => h('option', { value: v }, `${v} \u00d7`)));
    return many ? h('footer', {}, h('div', { class: 'row' }, this.playButton, this.slider, this.clock, this.speed, h('span', { class: 'note' }, this.scene.motion.note)),
      this.chartBox = h('div', { class: 'chart' }))
      : h('footer', {}, h('span', { class: 'note' }, this.scene.motion.note));
  }
  /** @param {HTMLElement} holder */
  controls(holder) {
    const stage = /** @type {Stage} */ (this.stage), overlay = /** @type {Overlay} */ (this.overlay), soil = this.soil;
    const button = (/** @type {string} */ words, /** @type {() => void} */ act, /** @type {string} */ label) => h('button', { type: 'button', onclick: act, 'aria-label': label, title: label }, words);
    const box = (/** @type {string} */ words, /** @type {boolean} */ on, /** @type {(on: boolean) => void} */ act) =>
      h('label', {}, h('input', { type: 'checkbox', checked: on, onchange: (/** @type {any} */ e) => { act(e.target.checked); stage.draw(); } }), words);
    const layer = (/** @type {string} */ key) => box(key, overlay.layers[key], on => { overlay.layers[key] = on; });
    const colouring = soil && h('label', {}, 'colour ', this.colourChoice = h('select', { 'aria-label': 'colour of the spheres', onchange: (/** @type {any} */ e) => this.colour(e.target.value) },
      soil.colourings().map(c => h('option', { value: c }, c))));
    this.section = this.sectionControls();
    this.key = h('div', { class: 'key' });
    holder.append(h('div', { class: 'tools', role: 'toolbar', 'aria-label': 'view' },
      Object.keys(PRESETS).map((p, i) => button(p, () => stage.look(p), `view ${p}, key ${i + 1}`)),
      button('PNG', () => this.savePicture(), 'save the picture as PNG'),
      typeof MediaRecorder !== 'undefined' && /** @type {Poses} */ (this.poses).times.length > 1 && button('film', () => this.record(), 'record the run as a film'),
      colouring, this.section, ['symbols', 'names', 'dimensions', 'monitors', 'axes'].map(layer), this.scene.forces.length > 0 && layer('forces'), this.scene.warnings.some(w => w.things.length) && layer('warnings'),
      box('normals', false, on => this.machine && this.machine.normals.forEach(n => { n.visible = on; })),
      soil && box('spheres', true, on => { soil.mesh.visible = on; }), soil && soil.hasChains && h('span', { title: soil.data.chainNote }, box('chains', false, on => soil.showChains(on))), this.scene.motion.times.length > 1 && box('paths', true, on => { if (this.around) this.around.paths.visible = on; }), this.key));
    stage.canvas.addEventListener('pointerdown', e => { this.pressed = [e.clientX, e.clientY]; });
    stage.canvas.addEventListener('click', e => {
      if (this.pressed && Math.hypot(e.clientX - this.pressed[0], e.clientY - this.pressed[1]) > 4) return;
      const r = stage.canvas.getBoundingClientRect();
      this.pick(e.clientX - r.left, e.clientY - r.top);
    });
    document.addEventListener('keydown', e => this.key_(e));
  }
  sectionControls() {
    const stage = /** @type {Stage} */ (this.stage);
    const axis = h('select', { 'aria-label': 'section plane' }, [['', 'no section'], ['0', 'section at x'], ['1', 'section at y'], ['2', 'section at z']].map(([v, w]) => h('option', { value: v }, w)));
    const place = h('input', { type: 'range', 'aria-label': 'place of the section, share of the box', min: 0, max: 1, step: 0.005, value: 0.5 });
    const act = () => {
      if (axis.value === '') return stage.cut(null);
      const k = Number(axis.value), low = stage.bounds.min.getComponent(k), high = stage.bounds.max.getComponent(k);
      stage.cut({ axis: k, at: low + Number(place.value) * (high - low), sign: 1 });
    };
    axis.addEventListener('change', act);
    place.addEventListener('input', act);
    return h('span', {}, axis, place);
  }
  /** @param {KeyboardEvent} e */
  key_(e) {
    const target = /** @type {HTMLElement} */ (e.target);
    if (['INPUT', 'SELECT', 'BUTTON'].includes(target.tagName) && e.key === ' ') return;
    const preset = Object.keys(PRESETS)[Number(e.key) - 1];
    if (preset && this.stage) this.stage.look(preset);
    else if (e.key === ' ') e.preventDefault(), this.play(!this.playing);
    else if (e.key === 'Escape') this.select(-1);
    else if (target.tagName !== 'INPUT' && (e.key === ',' || e.key === '.')) this.step(e.key === '.' ? 1 : -1);
  }
  /** To the next sample or the one before. @param {number} by */
  step(by) {
    const times = /** @type {Poses} */ (this.poses).times, { at } = bracket(times, this.time + 1e-12);
    if (times.length) this.show(times[Math.min(times.length - 1, Math.max(0, at + by))]);
  }
  /** @param {number} t */
  show(t) {
    this.time = t;
    /** @type {MachineView} */ (this.machine).show(t);
    if (this.soil) this.soil.showTime(t), this.surroundingsFollow();
    if (this.overlay) this.overlay.time = t;
    this.slider.value = String(t);
    this.clock.textContent = `${t.toFixed(3)} s`;
    if (this.plot) this.markTime();
    /** @type {Stage} */ (this.stage).draw();
    this.timed.forEach(f => f(t));
  }
  /** The walls of a moving bed go with its window. */
  surroundingsFollow() {
    if (this.around && this.soil && this.soil.frame >= 0) this.around.container.position.x = this.soil.now.travelled;
  }
  /** @param {boolean} on */
  play(on) {
    const p = /** @type {Poses} */ (this.poses);
    if (p.times.length < 2) return;
    this.playing = on;
    this.playButton.textContent = on ? '\u23f8' : '\u25b6';
    this.playButton.setAttribute('aria-label', on ? 'pause' : 'play');
    if (on && this.time >= p.end) this.show(p.begin);
    let last = performance.now();
    const next = (/** @type {number} */ now) => {
      if (!this.playing) return;
      const t = this.time + (now - last) / 1000 * Number(this.speed.value);
      last = now;
      this.show(Math.min(t, p.end));
      if (t >= p.end) this.play(false); else requestAnimationFrame(next);
    };
    if (on) requestAnimationFrame(next);
  }
  /** @param {number} thing */
  select(thing) {
    this.selected = thing;
    /** @type {Panel} */ (this.panel).select(thing);
    /** @type {MachineView} */ (this.machine).select(thing);
    if (this.overlay) this.overlay.selected = thing;
    if (this.stage) this.stage.draw();
  }
  /** What lies under a pixel of the stage: a thing, a sphere, or nothing. @param {number} x @param {number} y */
  pick(x, y) {
    const stage = /** @type {Stage} */ (this.stage), machine = /** @type {MachineView} */ (this.machine), caster = stage.ray(x, y), plane = stage.plane();
    const hit = caster.intersectObjects(machine.pickable, false).find(i => !plane || plane.distanceToPoint(i.point) >= 0);
    const sphere = this.soil && this.soil.mesh.visible ? this.soil.pick(caster.ray, plane) : null;
    if (sphere && (!hit || sphere.distance < hit.distance)) {
      this.select(-1);
      /** @type {Panel} */ (this.panel).words(`sphere ${sphere.index}`, '', /** @type {Soil} */ (this.soil).describe(sphere.index));
      return { sphere: sphere.index };
    }
    this.select(hit ? hit.object.userData.thing : -1);
    return hit ? { thing: hit.object.userData.thing } : null;
  }
  /** @param {string} by */
  colour(by) {
    const soil = /** @type {Soil} */ (this.soil);
    soil.colour(by);
    this.colourChoice.value = by;
    const unit = { displacement: 'm', speed: 'm/s', force: 'N' }[by];
    const names = by === 'material' ? this.scene.spheres && this.scene.spheres.materials.map((m, i) => h('span', {}, h('span', { class: 'swatch', style: `background:${colourOf(1 + i % 8)}` }), m)) : null;
    const ends = by === 'depth' ? ['lowest before', 'highest'] : ['0', `${text(soil.top, 3)} ${unit || ''}`];
    this.key.replaceChildren(...(by === 'plain' ? [] : names || [`${by} `, ends[0], h('span', { class: 'scale', style: `background:${gradientOf(by)}` }), ends[1]]));
    /** @type {Stage} */ (this.stage).draw();
  }
  /** Forces on bodies at a time come from the series. */
  forceColumns() {
    const overlay = /** @type {Overlay} */ (this.overlay), series = this.series;
    if (!series) return;
    const of = (/** @type {string} */ name) => series.columns.find(c => c.name === name);
    for (const f of this.scene.forces) {
      const columns = f.columns.map(of);
      const size = (/** @type {number} */ i) => Math.hypot(...columns.map(c => (c ? c.values[i] : 0)));
      for (let i = 0; i < series.time.length; ++i) if (isFinite(size(i))) overlay.largestForce = Math.max(overlay.largestForce, size(i));
    }
    overlay.forceAt = f => /** @type {V3} */ (f.columns.map(name => this.value(name, this.time)));
  }
  /** A column of the series at a time, linear between rows. @param {string} name @param {number} t */
  value(name, t) {
    const series = this.series, c = series && series.columns.find(k => k.name === name);
    if (!series || !c) return 0;
    const { at, share } = bracket(series.time, t), a = c.values[at];
    return share > 0 ? a + share * (c.values[at + 1] - a) : a;
  }
  chart() {
    const series = this.series;
    if (!series || !this.chartBox) return;
    const names = series.columns.map(c => c.name), choice = h('select', { 'aria-label': 'column of the chart', onchange: (/** @type {any} */ e) => this.plotColumn(e.target.value) },
      names.map(n => h('option', { value: n }, n)), this.scene.furrow && h('option', { value: FURROW }, FURROW));
    this.plotBox = h('div', {});
    this.chartBox.append(choice, this.plotBox);
    const wanted = this.scene.monitors.map(m => m.name).find(n => names.includes(n)) || names[0];
    choice.value = wanted;
    this.plotColumn(wanted);
  }
  /** @param {string} name */
  plotColumn(name) {
    if (name === FURROW) return this.plotFurrow();
    const series = this.series, column = series && series.columns.find(c => c.name === name);
    if (!series || !column) return;
    this.plotBox.replaceChildren();
    this.plotted = name;
    this.plot = new uPlot({ width: this.chartWidth(), height: 150, legend: { show: false }, cursor: { drag: { x: false, y: false } },
      scales: { x: { time: false } }, axes: [{ label: 'time, s', size: 34, labelSize: 16 }, { label: `${name}, ${column.unit}`, size: 64 }],
      series: [{}, { stroke: '#0b62a4', width: 1.2 }], hooks: { draw: [(/** @type {any} */ u) => this.timeLine(u)] } }, [series.time, column.values], this.plotBox);
    this.plotBox.querySelector('.u-over').addEventListener('click', (/** @type {MouseEvent} */ e) => this.show(this.plot.posToVal(e.offsetX, 'x')));
  }
  chartWidth() { return Math.max(300, this.chartBox.clientWidth - 190); }
  /** Height of the surface across the travel, before and after. */
  plotFurrow() {
    const f = /** @type {Furrow} */ (this.scene.furrow);
    this.plotBox.replaceChildren();
    this.plot = new uPlot({ width: this.chartWidth(), height: 150, scales: { x: { time: false } },
      axes: [{ label: `${f.across}, m`, size: 34, labelSize: 16 }, { label: 'surface, m', size: 64 }],
      series: [{}, { label: 'before', stroke: '#8795a1', width: 1.2 }, { label: 'after', stroke: '#6b4b2a', width: 1.6 }] }, [f.z, f.before, f.after], this.plotBox);
    this.plot.isFurrow = true;
  }
  /** @param {any} u */
  timeLine(u) {
    const x = u.valToPos(this.time, 'x', true);
    u.ctx.strokeStyle = '#c62828';
    u.ctx.beginPath();
    u.ctx.moveTo(x, u.bbox.top);
    u.ctx.lineTo(x, u.bbox.top + u.bbox.height);
    u.ctx.stroke();
  }
  markTime() { if (!this.plot.isFurrow) this.plot.redraw(false, false); }

  /** Picture with symbols and labels on one canvas. */
  async picture() {
    const stage = /** @type {Stage} */ (this.stage), overlay = /** @type {Overlay} */ (this.overlay);
    stage.drawNow();
    const canvas = h('canvas', { width: stage.canvas.width, height: stage.canvas.height }), c = canvas.getContext('2d');
    c.drawImage(stage.canvas, 0, 0);
    const copy = /** @type {SVGElement} */ (overlay.root.cloneNode(true));
    copy.setAttribute('xmlns', 'http://www.w3.org/2000/svg');
    copy.setAttribute('width', String(canvas.width));
    copy.setAttribute('height', String(canvas.height));
    copy.setAttribute('font-family', 'Liberation Sans, Helvetica, Arial, sans-serif');
    const image = new Image();
    image.src = 'data:image/svg+xml;charset=utf-8,' + encodeURIComponent(new XMLSerializer().serializeToString(copy));
    await image.decode();
    c.drawImage(image, 0, 0);
    return canvas;
  }
  /**
   * A picture of a size of its own, without symbols; what is shown stays.
   * @param {{ width: number, height: number, time: number, view?: string, colour?: string, chains?: boolean,
   *   section?: { axis: number, at: number, sign: number } | null, box?: import('three').Box3 }} wanted
   * @returns {string} PNG as a data URL
   */
  still(wanted) {
    const stage = /** @type {Stage} */ (this.stage), around = /** @type {Surroundings} */ (this.around), { soil } = this;
    const before = { time: this.time, section: stage.section, colour: soil && soil.colouring, chains: soil && soil.chains.mesh.visible, paths: around.paths.visible };
    this.show(wanted.time);
    around.paths.visible = false;
    if (soil && wanted.colour) soil.colour(wanted.colour);
    if (soil) soil.showChains(wanted.chains === true);
    stage.section = wanted.section || null;
    const url = stage.snapshot(wanted.width, wanted.height, wanted.view || 'side', wanted.box);
    stage.section = before.section;
    around.paths.visible = before.paths;
    if (soil) soil.colour(/** @type {string} */ (before.colour)), soil.showChains(before.chains === true);
    this.show(before.time);
    return url;
  }
  async savePicture() { this.save((await this.picture()).toDataURL('image/png'), 'png'); }
  /** @param {string} url @param {string} kind */
  save(url, kind) {
    const a = h('a', { href: url, download: `${this.scene.title.replace(/[^\w-]+/g, '-') || 'subsoil'}.${kind}` });
    document.body.append(a);
    a.click();
    a.remove();
  }
  /** Plays the run once and saves what was seen. */
  async record() {
    const stage = /** @type {Stage} */ (this.stage), type = ['video/mp4', 'video/webm'].find(t => MediaRecorder.isTypeSupported(t));
    const recorder = new MediaRecorder(stage.canvas.captureStream(30), { mimeType: type });
    /** @type {Blob[]} */
    const parts = [];
    recorder.ondataavailable = e => parts.push(e.data);
    recorder.onstop = () => this.save(URL.createObjectURL(new Blob(parts, { type })), type === 'video/mp4' ? 'mp4' : 'webm');
    this.show(/** @type {Poses} */ (this.poses).begin);
    recorder.start();
    this.play(true);
    const watch = () => (this.playing ? requestAnimationFrame(watch) : recorder.stop());
    requestAnimationFrame(watch);
  }
}

const sceneText = /** @type {HTMLElement} */ (document.getElementById('data')).textContent || '';
window.subsoil = new Viewer(JSON.parse(sceneText));
window.subsoil.errors = errors;
window.subsoil.build().catch((/** @type {unknown} */ e) => {
  fail(e);
  /** @type {HTMLElement} */ (document.getElementById('page')).replaceChildren(h('p', { class: 'failure' }, `The picture cannot be drawn: ${e}`));
});
