// @ts-check
'use strict';
// Bodies as solids: true meshes, plates and bars where a body has no mesh, and springs, dampers and rods between points.

/** @typedef {{ object: import('three').Object3D, thing: number }} Solid */

/** Rounded bar from p to q of a width, in the plane. @param {V2} p @param {V2} q @param {number} width */
function barShape(p, q, width) {
  const along = Math.atan2(q[1] - p[1], q[0] - p[0]), r = width / 2, shape = new THREE.Shape();
  shape.absarc(q[0], q[1], r, along - Math.PI / 2, along + Math.PI / 2, false);
  shape.absarc(p[0], p[1], r, along + Math.PI / 2, along + 1.5 * Math.PI, false);
  shape.closePath();
  return shape;
}

/** Helix about x from 0 to 1 with straight ends. */
class Coil extends /** @type {new () => import('three').Curve<import('three').Vector3>} */ (/** @type {any} */ (THREE.Curve)) {
  /** @param {number} turns @param {number} radius */
  constructor(turns, radius) {
    super();
    this.turns = turns;
    this.radius = radius;
  }
  /** @param {number} t */
  getPoint(t) {
    const end = 0.08, inner = Math.min(1, Math.max(0, (t - end) / (1 - 2 * end))), a = 2 * Math.PI * this.turns * inner;
    const r = this.radius * Math.min(1, t / end, (1 - t) / end);
    return new THREE.Vector3(t, r * Math.cos(a), r * Math.sin(a));
  }
}

class MachineView {
  /** @param {Scene} scene @param {Poses} poses @param {{ vertices: Float32Array, triangles: Uint32Array, open: Uint32Array }[]} meshes */
  constructor(scene, poses, meshes) {
    this.scene = scene;
    this.poses = poses;
    this.size = scene.size;
    this.root = new THREE.Group();
    this.bodies = scene.bodies.map(() => new THREE.Group());
    this.bodies.forEach(b => this.root.add(b));
    this.paths = scene.motion.paths.map(() => new THREE.Group());
    this.paths.forEach(p => this.root.add(p));
    /** @type {import('three').Mesh[]} */
    this.pickable = [];
    /** @type {import('three').LineSegments[]} */
    this.normals = [];
    /** Half of the depth (z) of each body, m. @type {number[]} */
    this.reach = scene.bodies.map(() => 0);
    /** z of the middle of the first surface of each body, m. @type {(number | undefined)[]} */
    this.middles = scene.bodies.map(() => undefined);
    /** @type {{ update: (t: number) => void }[]} */
    this.moving = [];
    scene.meshes.forEach((m, i) => this.addMesh(m, meshes[i]));
    const plate = 0.012 * this.size;
    this.plate = plate;
    scene.symbols.forEach(s => this.addSymbol(s));
  }
  /** @param {number} body */
  material(body) {
    return new THREE.MeshStandardMaterial({ color: colourOf(body), metalness: 0.05, roughness: 0.75, side: THREE.DoubleSide });
  }
  /**
   * @param {import('three').Object3D} parent @param {import('three').BufferGeometry} geometry @param {number} thing
   * @param {import('three').Material} material @param {boolean} [edges]
   */
  solid(parent, geometry, thing, material, edges = true) {
    const mesh = new THREE.Mesh(geometry, material);
    mesh.userData.thing = thing;
    if (edges) mesh.add(new THREE.LineSegments(new THREE.EdgesGeometry(geometry, 25), new THREE.LineBasicMaterial({ color: '#20262b', transparent: true, opacity: 0.55 })));
    parent.add(mesh);
    this.pickable.push(mesh);
    return mesh;
  }
  /** @param {MeshData} m @param {{ vertices: Float32Array, triangles: Uint32Array, open: Uint32Array }} data */
  addMesh(m, data) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(data.vertices, 3));
    geometry.setIndex(new THREE.BufferAttribute(data.triangles, 1));
    const parent = m.body >= 0 ? this.bodies[m.body] : m.path >= 0 ? this.paths[m.path] : this.root;
    const material = this.material(m.body >= 0 ? m.body : 0);
    material.flatShading = true;
    if (m.body < 0) material.color.set('#7d8790');
    const mesh = this.solid(parent, geometry, m.thing, material);
    this.addNormals(mesh, data);
    if (data.open.length) {
      const open = new THREE.BufferGeometry();
      open.setAttribute('position', new THREE.BufferAttribute(data.vertices, 3));
      open.setIndex(new THREE.BufferAttribute(data.open, 1));
      const lines = new THREE.LineSegments(open, new THREE.LineBasicMaterial({ color: '#d40000', depthTest: false }));
      lines.renderOrder = 3;
      mesh.add(lines);
    }
    geometry.computeBoundingBox();
    const z = geometry.boundingBox && (geometry.boundingBox.min.z + geometry.boundingBox.max.z) / 2;
    if (m.body >= 0 && this.middles[m.body] === undefined) this.middles[m.body] = z || 0;
    if (m.body >= 0)
      for (let i = 2; i < data.vertices.length; i += 3) this.reach[m.body] = Math.max(this.reach[m.body], Math.abs(data.vertices[i]));
  }
  /** Strokes along the normals, of fine meshes one of many. @param {import('three').Mesh} mesh @param {{ vertices: Float32Array, triangles: Uint32Array }} data */
  addNormals(mesh, { vertices, triangles }) {
    const count = triangles.length / 3, step = Math.ceil(count / 4000), points = [];
    const corner = (/** @type {number} */ k) => new THREE.Vector3().fromArray(vertices, 3 * triangles[k]);
    for (let t = 0; t < count; t += step) {
      const a = corner(3 * t), b = corner(3 * t + 1), c = corner(3 * t + 2);
      const n = b.clone().sub(a).cross(c.clone().sub(a)).normalize().multiplyScalar(0.02 * this.size);
      const middle = a.add(b).add(c).multiplyScalar(1 / 3);
      points.push(...middle.toArray(), ...middle.clone().add(n).toArray());
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(points), 3));
    const lines = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: '#7a00c4' }));
    lines.visible = false;
    this.normals.push(lines);
    mesh.add(lines);
  }
  /** Bodies without a mesh lie in neighbouring planes, as links on a pin do. @param {number} body */
  layer(body) { return this.reach[body] > 0 || body === 0 ? 0 : ((body % 3) - 1) * 1.15 * this.plate; }
  /** @param {SymbolData} s */
  addSymbol(s) {
    /** @type {Partial<Record<SymbolData['kind'], () => void>>} */
    const add = {
      pin: () => this.addPin(s), slide: () => this.addSlide(s), disk: () => this.addDisk(s),
      outline: () => this.addOutline(s), rod: () => this.addLink(s), spring: () => this.addLink(s), damper: () => this.addLink(s),
    };
    (add[s.kind] || (() => {}))();  // the others are glyphs of the overlay
  }
  /** @param {SymbolData} s */
  addPin(s) {
    const reach = Math.max(this.reach[s.a], this.reach[s.b], 1.8 * this.plate) + 0.6 * this.plate;
    const geometry = new THREE.CylinderGeometry(0.008 * this.size, 0.008 * this.size, 2 * Math.min(reach, 0.25 * this.size), 24);
    geometry.rotateX(Math.PI / 2);
    geometry.translate(s.pb[0], s.pb[1], 0);
    const steel = new THREE.MeshStandardMaterial({ color: '#3c444b', metalness: 0.4, roughness: 0.45 });
    this.solid(this.bodies[s.b === 0 && s.a !== 0 ? s.a : s.b], s.b === 0 && s.a !== 0 ? geometry.clone().translate(s.pa[0] - s.pb[0], s.pa[1] - s.pb[1], 0) : geometry, s.thing, steel, false);
  }
  /** @param {SymbolData} s */
  addSlide(s) {
    if (!s.block) return;
    const box = new THREE.BoxGeometry(0.07 * this.size, 0.04 * this.size, 3 * this.plate);
    const mesh = this.solid(this.root, box, s.thing, this.material(s.b));
    this.moving.push({ update: t => {
      const [x, y] = this.poses.point(s.b, s.pb, t);
      mesh.position.set(x, y, this.layer(s.b));
      mesh.rotation.z = this.poses.body(s.a, t)[2] + (s.angle || 0);
    } });
  }
  /** A wheel with its spokes; a dot is a small disk. @param {SymbolData} s */
  addDisk(s) {
    const r = s.radius || 0, group = this.bodies[s.a], material = this.material(s.a), z = this.layer(s.a);
    const tube = Math.min(0.06 * r, 0.012 * this.size);
    const rim = new THREE.TorusGeometry(r - tube, tube, 10, 48).translate(s.pa[0], s.pa[1], z);
    this.solid(group, rim, s.thing, material, false);
    const hub = new THREE.CylinderGeometry(0.14 * r, 0.14 * r, 3 * tube, 24).rotateX(Math.PI / 2).translate(s.pa[0], s.pa[1], z);
    this.solid(group, hub, s.thing, material, false);
    for (let k = 0; k < 5; ++k) {
      const spoke = new THREE.BoxGeometry(0.88 * r, 0.7 * tube, 0.7 * tube).translate(0.5 * r, 0, 0).rotateZ(2 * Math.PI * k / 5);
      this.solid(group, spoke.translate(s.pa[0], s.pa[1], z), s.thing, material, false);
    }
  }
  /** Closed: a plate; two points: a bar with eyes; more: a rail. @param {SymbolData} s */
  addOutline(s) {
    const flat = s.points || [], points = [];
    for (let i = 0; i + 1 < flat.length; i += 2) points.push(new THREE.Vector2(flat[i], flat[i + 1]));
    const z = this.layer(s.a), depth = this.plate;
    const extruded = (/** @type {import('three').Shape} */ shape) =>
      this.solid(this.bodies[s.a], new THREE.ExtrudeGeometry(shape, { depth, bevelEnabled: false, curveSegments: 16 }).translate(0, 0, z - depth / 2), s.thing, this.material(s.a));
    if (s.closed) extruded(new THREE.Shape(points));
    else if (points.length === 2) extruded(barShape([points[0].x, points[0].y], [points[1].x, points[1].y], 0.026 * this.size));
    else {
      const curve = new THREE.CatmullRomCurve3(points.map(p => new THREE.Vector3(p.x, p.y, 0)));
      this.solid(this.bodies[s.a], new THREE.TubeGeometry(curve, 4 * points.length, 0.004 * this.size, 8), s.thing, this.material(s.a), false);
    }
  }
  /** What lies along x from 0 to 1 is laid between two points. @param {SymbolData} s */
  addLink(s) {
    const group = new THREE.Group(), w = 0.02 * this.size;
    this.root.add(group);
    const steel = new THREE.MeshStandardMaterial({ color: s.kind === 'spring' ? '#2f6b3a' : '#4a545d', metalness: 0.35, roughness: 0.4 });
    const rod = (/** @type {number} */ radius, /** @type {number} */ from, /** @type {number} */ to) =>
      this.solid(group, new THREE.CylinderGeometry(radius, radius, to - from, 20).rotateZ(Math.PI / 2).translate((from + to) / 2, 0, 0), s.thing, steel, false);
    if (s.kind === 'spring') {
      this.solid(group, new THREE.TubeGeometry(new Coil(8, 1.15 * w), 400, 0.28 * w, 8), s.thing, steel, false);
      rod(0.3 * w, 0, 1);
    } else if (s.kind === 'damper') {
      rod(0.95 * w, 0.02, 0.55);
      rod(0.4 * w, 0.5, 0.98);
    } else rod(0.5 * w, 0, 1);
    this.moving.push({ update: t => {
      const p = this.poses.point(s.a, s.pa, t), q = this.poses.point(s.b, s.pb, t);
      group.position.set(p[0], p[1], 0);
      group.rotation.z = Math.atan2(q[1] - p[1], q[0] - p[0]);
      group.scale.set(Math.max(Math.hypot(q[0] - p[0], q[1] - p[1]), 1e-9), 1, 1);
    } });
  }
  /** @param {number} t */
  show(t) {
    this.bodies.forEach((group, i) => {
      const [x, y, angle] = this.poses.body(i, t);
      group.position.set(x, y, 0);
      group.rotation.z = angle;
    });
    this.paths.forEach((group, i) => {
      const { place, turn } = this.poses.path(i, t);
      group.position.copy(place);
      group.quaternion.copy(turn);
    });
    this.moving.forEach(m => m.update(t));
    this.root.updateMatrixWorld(true);
  }
  /** Lights what belongs to a thing. @param {number} thing */
  select(thing) {
    for (const mesh of this.pickable) {
      const material = /** @type {import('three').MeshStandardMaterial} */ (mesh.material);
      material.emissive.set(thing >= 0 && mesh.userData.thing === thing ? '#b8860b' : '#000000');
      material.emissiveIntensity = 0.7;
    }
  }
  /** Centre of a thing's solids now; null: it has none. @param {number} thing */
  centre(thing) {
    const box = new THREE.Box3();
    for (const mesh of this.pickable) if (mesh.userData.thing === thing) box.expandByObject(mesh);
    return box.isEmpty() ? null : box.getCenter(new THREE.Vector3());
  }
  /** z of the middle of a body's surfaces. @param {number} body */
  depthOf(body) { return this.middles[body] || 0; }
  /** Box of all solids now. */
  bounds() { return new THREE.Box3().setFromObject(this.root); }
}
