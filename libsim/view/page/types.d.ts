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
    kind: "pin" | "weld" | "slide" | "rod" | "spring" | "damper" | "disk" | "outline" | "side" | "marker" | "driver" | "load"
      | "two disks" | "disk on line" | "ratio" | "follower" | "contact" | "torsion" | "bushing" | "beam" | "drag"
      | "angle stop" | "slide stop" | "distance stop" | "ground" | "motor" | "friction";
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
    what?: string;        // driver: x, y, angle, distance, slide; disks: rolls, slides, gears, rack, contact
    radiusB?: number;     // below 0: inside
    ratio?: number;
    from?: number | null; // limits of a stop, m or rad; null: none there
    until?: number | null;
    along?: V3;           // load: N, N, N m at the start
    turns?: boolean;      // load: with its body
  }
  interface Container { thing: number; low: V3; high: V3; faces: { name: string; state: string }[] }
  interface Bed { thing: number; low: V3; high: V3; surface: number | null; note: string;
    layers: { name: string; from: number; until: number }[] }
  /** Of a page that is served all but the time comes later, with the box of its coordinates. */
  /** `travelled`: by the window of a moving bed since the first frame, along x, m. */
  interface SphereFrame { time: number; travelled?: number; position?: Packed; speed?: Packed; force?: Packed; chains?: Packed; low?: V3; high?: V3; error?: number }
  interface Spheres {
    count: number;
    low: V3; high: V3;    // of the centres
    error: number;        // m, largest of a coordinate
    radius: { low: number; high: number; bytes: Packed | null };
    materials: string[];
    material: Packed | null;
    speedTop: number; forceTop: number; chainTop: number;
    chainNote: string;    // where the forces of the chains come from
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
    arrow: MonitorArrow | null }
  /** Where a monitor is positive: along a direction of the world, away from a point, along a line of a body, or turning. */
  interface MonitorArrow { body: number; point: V2; thing?: number; along?: V3; from?: { body: number; point: V2 };
    line?: { body: number; angle: number }; turn?: number }
  interface ForceArrow { name: string; thing: number; body: number; path: number; columns: [string, string, string] }
  interface Furrow { z: number[]; before: (number | null)[]; after: (number | null)[]; across: string }
  interface SeriesData { time: Packed; columns: { name: string; unit: string; values: Packed }[] }
  /** What a served run has by now; all but the first two are there only where they are new. */
  interface State {
    progress: { time: number; from: number; until: number; remaining: number | null; warnings: string[] } | null;
    stamp: string;
    motion: Motion; series?: SeriesData | null; warnings?: { text: string; things: number[] }[]; frames?: number[]; count?: number;
  }
  interface Scene {
    served?: boolean;
    embedded?: boolean;   // inside a report
    format: string; mode: "show" | "view"; title: string; file: string; version: string;
    gravity: V3; size: number;
    things: Thing[]; bodies: BodyData[]; meshes: MeshData[]; symbols: SymbolData[];
    container: Container | null; bed: Bed | null; spheres: Spheres | null;
    motion: Motion; tool: Tool | null;
    warnings: { text: string; things: number[] }[];
    monitors: Monitor[];
    notes: string[];
    series: SeriesData | null;
    forces: ForceArrow[];
    furrow: Furrow | null;
  }
}
export {};
