// Types of what the program writes into the page (libsim/view/scene.cpp) and of the vendored libraries.
import type * as Three from "three";
import type { OrbitControls as Orbit } from "three/examples/jsm/controls/OrbitControls.js";

declare global {
  const THREE: typeof Three & { OrbitControls: typeof Orbit };
  const uPlot: any;
  interface Window { subsoil: any }

  type V2 = [number, number];
  type V3 = [number, number, number];
  /** zlib stream in base64 */
  type Packed = string;

  /** Something with a name that can be selected. Its place in `Scene.things` is its number. */
  interface Thing {
    kind: "body" | "joint" | "driver" | "force" | "surface" | "boundary" | "container" | "bed" | "monitor" | "marker";
    name: string;
    path: string;
    place: string;   // file:line:column of the scenario
    values: string;  // YAML with units
  }
  interface BodyData { thing: number; mass: number }
  interface MeshData {
    thing: number;
    body: number;         // -1: not of the machine
    path: number;         // of Motion.paths; -1: stands still
    touches: boolean;     // acts on the soil
    vertices: Packed;     // float32 x y z, m, in the axes of what carries it
    triangles: Packed;    // uint32
    open: Packed | null;  // uint32 pairs: edges of one triangle only
  }
  interface SymbolData {
    kind: "pin" | "weld" | "slide" | "rod" | "spring" | "damper" | "disk" | "outline" | "side" | "marker" | "driver" | "load";
    thing: number;
    a: number;            // body
    b: number;
    pa: V2;               // m, body axes
    pb: V2;
    angle?: number;       // rad, axes of a
    radius?: number;
    points?: number[];    // x y x y ...
    closed?: boolean;
    block?: boolean;
    below?: number;
    hitch?: boolean;
    what?: string;        // driver: x, y, angle, distance, slide
  }
  interface Container { thing: number; low: V3; high: V3; faces: { name: string; state: string }[] }
  interface Bed { thing: number; low: V3; high: V3; surface: number | null; note: string;
    layers: { name: string; from: number; until: number }[] }
  interface SphereFrame { time: number; position: Packed; speed?: Packed; force?: Packed; chains?: Packed; }
  interface Spheres {
    count: number;
    low: V3; high: V3;    // of the centres
    error: number;        // m, largest of a coordinate
    radius: { low: number; high: number; bytes: Packed | null };
    materials: string[];
    material: Packed | null;
    speedTop: number; forceTop: number; chainTop: number;
    frames: SphereFrame[];
  }
  interface Motion {
    note: string;
    times: number[];
    bodies: Packed | null;     // float32 x y angle, body by body (ground first), frame by frame
    paths: { name: string }[];
    poses: Packed | null;      // float32 x y z, quaternion w x y z, path by path, frame by frame
  }
  interface Tool {
    times: number[];
    names: string[]; surface: number; axis: number; direction: number; middle: number;
    width: number; depth: number[]; tip: number[]; speed: number; rakeLow: number; rakeHigh: number;
  }
  interface Monitor { thing: number; name: string; unit: string; words: string;
    arrow: { body: number; point: V2; along: V3 } | null }
  interface ForceArrow { name: string; thing: number; body: number; path: number; columns: [string, string, string] }
  interface Furrow { z: number[]; before: (number | null)[]; after: (number | null)[]; across: string }
  interface Scene {
    format: string; mode: "show" | "view"; title: string; file: string; version: string;
    gravity: V3; size: number;
    things: Thing[]; bodies: BodyData[]; meshes: MeshData[]; symbols: SymbolData[];
    container: Container | null; bed: Bed | null; spheres: Spheres | null;
    motion: Motion; tool: Tool | null;
    warnings: { text: string; things: number[] }[];
    monitors: Monitor[];
    notes: string[];
    series: { time: Packed; columns: { name: string; unit: string; values: Packed }[] } | null;
    forces: ForceArrow[];
    furrow: Furrow | null;
  }
}
export {};
