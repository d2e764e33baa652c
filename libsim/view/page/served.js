// @ts-check
'use strict';
// A page that the program serves: frames are fetched when they are shown, and a run in progress is followed.

const POLL = 1000;  // ms; a run writes its curves once a second

class Served {
  /** @param {Viewer} viewer */
  constructor(viewer) {
    this.viewer = viewer;
    this.stamp = '';
    this.running = false;
    this.stopped = false;
    this.renewed = 0;
    this.status = h('output', { class: 'status', 'aria-live': 'polite', 'aria-label': 'state of the run' }, '');
  }
  /** @param {string} what @returns {Promise<any>} */
  static async get(what) {
    const answer = await fetch(what, { cache: 'no-store' });
    if (!answer.ok) throw new Error(`${what}: ${answer.status} ${await answer.text()}`);
    return answer.json();
  }
  /** @param {number} number @returns {Promise<SphereFrame>} */
  static frame(number) { return Served.get(`frame?number=${number}`); }
  async follow() {
    while (!this.stopped) {
      const begin = performance.now();
      try {
        await this.look();
      } catch (e) {
        this.status.textContent = `no answer: the program that serves this page has ended (${e})`;
        this.stopped = true;
      }
      // An answer that took long, of a large series, is asked for less often.
      await new Promise(done => setTimeout(done, Math.max(POLL, 5 * (performance.now() - begin))));
    }
  }
  /** Asks once, and takes what is new. */
  async look() {
    /** @type {State} */
    const state = await Served.get(`state?known=${encodeURIComponent(this.stamp)}`), known = this.stamp;
    const was = this.running;
    this.running = state.progress !== null;
    this.stamp = state.stamp;
    this.status.textContent = this.words(state);
    if (was && !this.running) return location.reload();  // now there are summary and furrow
    if (state.motion && known !== '') await this.take(state);
    if (this.running && known === '') this.viewer.show(/** @type {Poses} */ (this.viewer.poses).end);  // where the run is
  }
  /** @param {State} state */
  words(state) {
    const p = state.progress;
    if (!p) return '';
    if (p.until === undefined) return 'running';
    const share = 100 * (p.time - p.from) / Math.max(p.until - p.from, 1e-12), left = p.remaining;
    return `running: ${text(p.time, 4)} s, ${share.toFixed(1)} %` + (typeof left === 'number' ? `, ${this.clock(left)} left` : '');
  }
  /** @param {number} seconds */
  clock(seconds) {
    const s = Math.round(seconds), two = (/** @type {number} */ v) => String(v).padStart(2, '0');
    return `${Math.floor(s / 3600)}:${two(Math.floor(s / 60) % 60)}:${two(s % 60)}`;
  }
  /** @param {State} state */
  async take(state) {
    const v = this.viewer, poses = /** @type {Poses} */ (v.poses), many = poses.times.length > 1;
    const grown = (state.count || 0) !== (v.soil ? v.soil.data.count : 0), begun = !many && state.motion.times.length > 1;
    if (grown || begun) return location.reload();  // the page begins with other parts
    const newest = v.time >= poses.end - 1e-12;
    if (v.soil) v.soil.extend(state.frames || []);
    v.scene.motion = state.motion;
    poses.take(state.motion, await floats(state.motion.bodies), await floats(state.motion.poses));
    v.scene.warnings = state.warnings || [];
    /** @type {Panel} */ (v.panel).renewWarnings();
    if (state.series) await v.takeSeries(state.series);
    v.slider.max = String(poses.end);
    v.show(newest ? poses.end : v.time);
    document.documentElement.dataset.renewed = String(++this.renewed);
  }
}
