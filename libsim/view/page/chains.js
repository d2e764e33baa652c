// @ts-check
'use strict';
// Force chains: a ribbon for each contact that carries a force, as wide and dark as the force, before the spheres. With a
// section only those of the slice behind the plane are drawn.

const CHAIN_VERTEX = `
attribute vec3 from, to;
attribute float force;   // over the top of the scale
uniform float thickest, pixel;  // m
varying float strength;
varying vec3 middle;
void main() {
  vec3 a = (modelViewMatrix * vec4(from, 1.0)).xyz, b = (modelViewMatrix * vec4(to, 1.0)).xyz;
  vec2 along = b.xy - a.xy;
  float length_ = length(along);
  vec2 across = length_ > 0.0 ? vec2(-along.y, along.x) / length_ : vec2(0.0);
  strength = force;
  middle = 0.5 * (a + b);
  vec3 p = mix(a, b, position.x);
  p.xy += across * position.y * max(0.7 * pixel, thickest * sqrt(abs(force)));
  gl_Position = projectionMatrix * vec4(p, 1.0);
}`;
const CHAIN_FRAGMENT = `
precision highp float;
uniform vec4 cut;        // view axes: what has dot(n, p) > w is cut off
uniform float cutting, slice;
varying float strength;
varying vec3 middle;
void main() {
  float beyond = dot(cut.xyz, middle) - cut.w;
  if (cutting > 0.5 && (beyond > 0.0 || beyond < -slice)) discard;
  vec3 colour = strength >= 0.0 ? vec3(0.62, 0.02, 0.1) : vec3(0.05, 0.25, 0.8);
  gl_FragColor = vec4(colour, 0.25 + 0.75 * sqrt(min(1.0, abs(strength))));
}`;

class Chains {
  /** @param {number} radius mean, m @param {number} top of the scale, N */
  constructor(radius, top) {
    this.top = top;
    this.material = new THREE.ShaderMaterial({
      vertexShader: CHAIN_VERTEX, fragmentShader: CHAIN_FRAGMENT, transparent: true, depthTest: false, depthWrite: false, side: THREE.DoubleSide,
      uniforms: { thickest: { value: 0.5 * radius }, pixel: { value: 0 }, slice: { value: 2 * radius }, cut: { value: new THREE.Vector4() }, cutting: { value: 0 } },
    });
    this.mesh = new THREE.Mesh(this.geometry(null), this.material);
    this.mesh.visible = false;
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 2;
  }
  /** @param {Float32Array | null} data seven numbers each: both ends, m, and the force, N */
  geometry(data) {
    const count = data ? data.length / 7 : 0, out = new THREE.InstancedBufferGeometry();
    const from = new Float32Array(3 * count), to = new Float32Array(3 * count), force = new Float32Array(count);
    for (let i = 0; i < count && data; ++i) {
      from.set(data.subarray(7 * i, 7 * i + 3), 3 * i);
      to.set(data.subarray(7 * i + 3, 7 * i + 6), 3 * i);
      force[i] = data[7 * i + 6] / this.top;
    }
    out.setAttribute('position', new THREE.BufferAttribute(new Float32Array([0, -1, 0, 1, -1, 0, 1, 1, 0, 0, 1, 0]), 3));
    out.setIndex([0, 1, 2, 0, 2, 3]);
    out.setAttribute('from', new THREE.InstancedBufferAttribute(from, 3));
    out.setAttribute('to', new THREE.InstancedBufferAttribute(to, 3));
    out.setAttribute('force', new THREE.InstancedBufferAttribute(force, 1));
    out.instanceCount = count;
    return out;
  }
  /** Contacts of another frame. @param {Float32Array | null} data */
  show(data) {
    this.mesh.geometry.dispose();
    this.mesh.geometry = this.geometry(data);
  }
}
