// @ts-check
'use strict';
// Renderer, camera and section plane. The camera is orthographic: lengths can be read off with the scale bar.

/** Directions from which the presets look, and the one that is up. @type {Record<string, [V3, V3]>} */
const PRESETS = {
  oblique: [[0.38, 0.3, 0.88], [0, 1, 0]],
  side: [[0, 0, 1], [0, 1, 0]],
  front: [[1, 0, 0], [0, 1, 0]],
  top: [[0, 1, 0], [0, 0, -1]],
};

class Stage {
  /** @param {HTMLElement} parent */
  constructor(parent) {
    this.parent = parent;
    this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.localClippingEnabled = true;
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    parent.append(this.canvas);
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color('#f7f8f9');
    this.scene.add(new THREE.HemisphereLight('#ffffff', '#b4afa6', 2.2));
    const sun = new THREE.DirectionalLight('#ffffff', 2.6);
    sun.position.set(0.35, 0.8, 0.75);
    this.scene.add(sun);
    this.camera = new THREE.OrthographicCamera(-1, 1, 1, -1, -10, 10);
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    this.controls.enableDamping = false;
    this.controls.addEventListener('change', () => this.draw());
    /** What the camera shows all of, until the user moves it. @type {import('three').Box3 | null} */
    this.fitted = null;
    this.controls.addEventListener('start', () => { this.fitted = null; });
    /** Called after each picture. @type {(() => void)[]} */
    this.after = [];
    /** @type {{ axis: number, at: number, sign: number } | null} */
    this.section = null;
    /** @type {Soil | null} */
    this.soil = null;
    this.pending = false;
    /** Size in pixels in place of the parent's. @type {[number, number] | null} */
    this.other = null;
    this.bounds = new THREE.Box3(new THREE.Vector3(-1, -1, -1), new THREE.Vector3(1, 1, 1));
    new ResizeObserver(() => this.resize()).observe(parent);
    this.resize();
  }
  get width() { return this.other ? this.other[0] : this.parent.clientWidth || 1; }
  get height() { return this.other ? this.other[1] : this.parent.clientHeight || 1; }
  resize() {
    this.renderer.setSize(this.width, this.height, false);
    this.frustum(this.fitted ? this.halfHeight(this.fitted) : (this.camera.top - this.camera.bottom) / 2);
    this.drawNow();  // a new size clears the canvas: draw before the page is painted
  }
  /** @param {number} half m, of the height seen at zoom 1 */
  frustum(half) {
    const aspect = this.width / this.height;
    Object.assign(this.camera, { left: -half * aspect, right: half * aspect, top: half, bottom: -half });
    this.camera.updateProjectionMatrix();
  }
  /** Shows all of a box from a preset. @param {string} preset @param {import('three').Box3} [box] */
  look(preset, box = this.bounds) {
    const [from, up] = PRESETS[preset], centre = box.getCenter(new THREE.Vector3());
    const far = box.getSize(new THREE.Vector3()).length() || 1;
    this.camera.up.set(...up);
    this.camera.position.copy(centre).addScaledVector(new THREE.Vector3(...from).normalize(), far);
    this.camera.near = -20 * far;
    this.camera.far = 20 * far;
    this.camera.zoom = 1;
    this.controls.target.copy(centre);
    this.camera.lookAt(centre);
    this.camera.updateMatrixWorld(true);
    this.fitted = box;
    this.frustum(this.halfHeight(box));
    this.controls.update();
    this.draw();
  }
  /** In a page that scrolls, the wheel zooms with Ctrl or Shift alone. */
  leaveTheWheel() {
    this.canvas.addEventListener('wheel', e => { this.controls.enableZoom = e.ctrlKey || e.shiftKey; }, { capture: true, passive: true });
  }
  /**
   * The scene in another size and view, as PNG; the camera stays.
   * @param {number} width pixels @param {number} height @param {string} preset @param {import('three').Box3} [box]
   */
  snapshot(width, height, preset, box) {
    const camera = this.camera.clone(), target = this.controls.target.clone(), { fitted } = this;
    this.other = [width, height];
    this.renderer.setSize(width, height, false);
    this.look(preset, box);
    this.drawNow();
    const url = this.canvas.toDataURL('image/png');
    this.other = null;
    this.camera.copy(camera);
    this.controls.target.copy(target);
    this.controls.update();
    this.fitted = fitted;
    this.resize();
    return url;
  }
  /** Half height in which every corner of a box lies with a margin. @param {import('three').Box3} box */
  halfHeight(box) {
    const view = this.camera.matrixWorldInverse.copy(this.camera.matrixWorld).invert();
    let half = 1e-9;
    for (let k = 0; k < 8; ++k) {
      const p = new THREE.Vector3(k & 1 ? box.max.x : box.min.x, k & 2 ? box.max.y : box.min.y, k & 4 ? box.max.z : box.min.z).applyMatrix4(view);
      half = Math.max(half, Math.abs(p.y), Math.abs(p.x) * this.height / this.width);
    }
    return 1.12 * half;
  }
  /** @param {{ axis: number, at: number, sign: number } | null} section what lies beyond `at` along sign * axis is cut off */
  cut(section) {
    this.section = section;
    this.draw();
  }
  /** Plane of which three.js keeps the positive side. */
  plane() {
    if (!this.section) return null;
    const n = new THREE.Vector3().setComponent(this.section.axis, -this.section.sign);
    return new THREE.Plane(n, this.section.sign * this.section.at);
  }
  /** Pixels per metre. */
  get scale() { return this.height * this.camera.zoom / (this.camera.top - this.camera.bottom); }
  /** Place on the page, in pixels from the corner of the stage. @param {import('three').Vector3} p @returns {V2} */
  project(p) {
    const q = p.clone().project(this.camera);
    return [(q.x + 1) / 2 * this.width, (1 - q.y) / 2 * this.height];
  }
  /** @param {number} x pixels @param {number} y */
  ray(x, y) {
    const caster = new THREE.Raycaster();
    caster.setFromCamera(new THREE.Vector2(2 * x / this.width - 1, 1 - 2 * y / this.height), this.camera);
    // Behind the near plane of an orthographic camera there is no limit: start far outside.
    caster.ray.origin.addScaledVector(caster.ray.direction, this.camera.near);
    caster.far = Infinity;
    return caster;
  }
  draw() {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame(() => this.drawNow());
  }
  drawNow() {
    this.pending = false;
    this.camera.updateMatrixWorld(true);
    const plane = this.plane();
    this.renderer.clippingPlanes = plane ? [plane] : [];
    const seen = plane && plane.clone().applyMatrix4(this.camera.matrixWorldInverse);
    for (const { uniforms } of this.soil ? [this.soil.material, this.soil.chains.material] : []) {
      uniforms.cutting.value = seen ? 1 : 0;
      if (seen) uniforms.cut.value.set(-seen.normal.x, -seen.normal.y, -seen.normal.z, seen.constant);
      if (uniforms.pixel) uniforms.pixel.value = 1 / this.scale;
    }
    this.renderer.render(this.scene, this.camera);
    this.after.forEach(f => f());
  }
}
