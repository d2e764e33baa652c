#!/usr/bin/env python3
"""Runs the studies of docs/1s300.md and prints their tables.

    scripts/study_1s300.py unprinted                 # a slice of the source's pass, one unprinted value changed at a time
    scripts/study_1s300.py stiffness                 # a rigid shovel in five beds of the settled printed lattice: step and stiffness
    scripts/study_1s300.py beds                      # a rigid shovel: packing, width and depth of the bed, entry and steady work
    scripts/study_1s300.py spring                    # spring free, locked and absent in the same five beds
    scripts/study_1s300.py pass                      # the full pass: half an hour of a core and more
    scripts/study_1s300.py spring --only free-1      # some of the runs
    scripts/study_1s300.py spring --report           # only the tables, of what has been run
    scripts/study_1s300.py spring --check            # `subsoil check` of one scenario of each kind, on a bed as placed

What has been run is kept in --out and not run again. One process and one thread per run; --jobs: how many at a time.
"""
import argparse
import concurrent.futures
import csv
import json
import math
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
CONFIGS = ROOT / "configs"
SEEDS = (1, 2, 3, 4, 5)
# Yuan & Yu (2020), figures 5 and 6: column, statistic of the record, value.
SOURCE = (("pull", "largest", 1493), ("pull", "least", -331), ("spring force", "largest", 2623),
          ("spring force", "least", -2231), ("pitch", "span", 0.11), ("height", "span", 0.181))
# Student's t, two-sided, 95 %, by degrees of freedom.
STUDENT = {1: 12.706, 2: 4.303, 3: 3.182, 4: 2.776, 5: 2.571, 6: 2.447, 7: 2.365, 8: 2.306, 9: 2.262}


# Runs ---------------------------------------------------------------------------------------------------------------

class Run:
    """A scenario with changes. `text` is YAML that goes over it; `sets` are of `subsoil run --set`."""

    def __init__(self, name, base, meaning, sets=(), text="", bed=None):
        self.name, self.base, self.meaning, self.sets, self.text, self.bed = name, base, meaning, list(sets), text, bed


def hinge(height=0.565, x=-0.830):
    """Sets of the shovel's hinge H8 and the spring 0.27 m above it, 0.34 m long."""
    return [f"machine.joints.H8.at={x} {height} m",
            f"machine.forces.H9.ends=[{x} {height + 0.27:.4f} m, {x + 0.34:.4f} {height + 0.27:.4f} m]"]


def hitch(lower):
    """Sets of H2, H3 and the links' centres for a hitch that is lower than 0.40 m by so much."""
    return [f"machine.joints.H2.at=0 {0.40 - lower:.4f} m", f"machine.joints.H3.at=-0.150 {0.78 - lower:.4f} m",
            f"machine.bodies.lower link.at=-0.345 {0.40 - lower / 2:.4f} m",
            f"machine.bodies.upper link.at=-0.3875 {0.79 - lower / 2:.4f} m"]


def depth(deeper):
    """Sets of a shovel, hinge and spring that sit lower in the frame by so much."""
    return [f"machine.bodies.shovel.at=-1.224 {0.360 - deeper:.4f} m"] + hinge(0.565 - deeper)


def unprinted():
    slice_ = CONFIGS / "1s300-reduced.yaml"
    changes = {
        "slice": ([], "as configs/1s300-reduced.yaml"),
        "hinge-0.29": (hinge(x=-0.930), "H8 0.29 m ahead of the shank's centre instead of 0.39 m"),
        "hinge-0.49": (hinge(x=-0.730), "H8 0.49 m ahead"),
        "hitch-0.07": (hitch(0.07), "hitch 0.07 m lower than in rig-1s300.yaml instead of 0.135 m"),
        "hitch-0.1025": (hitch(0.1025), "hitch 0.1025 m lower"),
        "hitch-0.12": (hitch(0.12), "hitch 0.12 m lower"),
        "preload-1.1": (["machine.forces.H9.free length=0.3467 m"], "spring pressed by 1.1 kN at assembly"),
        "tension-1.1": (["machine.forces.H9.free length=0.3333 m"], "spring drawn by 1.1 kN at assembly"),
        "damper-300": (["machine.forces.H9.damping=300 N s/m"], "damper 300 N s/m instead of 611"),
        "damper-1200": (["machine.forces.H9.damping=1200 N s/m"], "damper 1200 N s/m"),
        "start-lower": (["soil.container.at=-0.92 -0.39 -0.21 m"], "start 20 mm lower over the bed"),
        "start-higher": (["soil.container.at=-0.92 -0.45 -0.21 m"], "start 40 mm higher over the bed"),
        "depth-shallow": (depth(-0.04), "shovel 40 mm higher in the frame"),
        "depth-deep": (depth(0.04), "shovel 40 mm lower in the frame"),
        "double": (["precision=double"], "double instead of mixed precision"),
    }
    return [Run(n, slice_, meaning, sets + ["output.every=500 ms"]) for n, (sets, meaning) in changes.items()]


ALL = [(c, k) for c in ("soil-soil", "soil-steel") for k in ("K_X", "K_Y")]
STIFFNESS = {
    "printed": ([], "as printed, N/m, per body"),
    "all-x4": ([(*k, 4) for k in ALL], "all K_X, K_Y x 4, attraction as before"),
    "all-x16": ([(*k, 16) for k in ALL] + ["time.accuracy=1"], "all K_X, K_Y x 16, attraction as before"),
    "K_B-x2": ([("soil-soil", "K_B", 2), ("soil-steel", "K_B", 2)], "K_B x 2"),
    "half-step": (["time.safety=0.45"], "half the step"),
}
PRINTED = {"soil-soil": {"K_X": 10000, "K_Y": 8000, "K_B": 7000}, "soil-steel": {"K_X": 16000, "K_Y": 12000, "K_B": 3000}}
# Where the printed lattice settled, 0.18 m deep, is worked: the draft is level once the tip is 0.4 m in, and the soil ahead of it
# is out of the end wall's reach until it is 0.40 m from it. The sides stand 0.28 m from the shovel's plane, one and a half times its
# depth, and 9 mm from the lattice, as in the slice: 0.16 m away they took part from 0.4 m of travel on.
LEVEL = (0.40, 0.65)
LENGTH = LEVEL[1] + 0.40
WIDTH = 26 * 0.0202 + 0.0392
LATTICE = {"fill": "lattice", "material": "soil", "radius": "10 mm", "pitch": "20.2 mm", "depth": "0.324 m"}
REST = "{until: 10 mm/s, at most: 10 s, stages: no}"


def box(length, height, width):
    return [f"soil.container.size={length:g} {height:g} {width:g} m", f"soil.container.at=-0.92 {-height:g} {-width / 2:g} m"]


def words(**bed):
    return "soil.bed={" + ", ".join(f"{k}: {v}" for k, v in bed.items()) + "}"


# The floor holds the bed: of steel it would let the whole narrow bed slide at mu times its weight, some 0.4 kN, and the end wall
# would carry the rest of the draft. The bin of the pass weighs 979 kg and stays where it is.
GRIP = """materials: {grip: {density: 7850 kg/m^3}}
contacts:
  - &soil {between: [soil, soil], law: wet, values: per-body, K_X: 10000 N/m, C_X: 20 N s/m, K_Y: 8000 N/m, C_Y: 20 N s/m, K_B: 7000 N/m,
           dc: 2 mm, dB: 2 mm, mu: 0.5, mu_r: 0.3}
  - &steel {<<: *soil, between: [soil, steel], K_X: 16000 N/m, K_Y: 12000 N/m, K_B: 3000 N/m}
  - {<<: *steel, between: [soil, grip], mu: 5}
soil: {container: {material: grip}}
"""


def lattice_bed(seed):
    """The printed lattice, its sites shifted at random by up to 1 mm, settled; saved where it lies in the box, since the runs
    that take it move box and bed together until its surface is at y = 0."""
    bed = words(**LATTICE, jitter=0.1, seed=seed, settle=REST)
    return Run(f"bed-{seed}", CONFIGS / "1s300-shovel.yaml", "", box(LENGTH, 0.33, WIDTH) + [bed], "soil: {surface: }\n")


def stiffness():
    runs = []
    for seed in SEEDS:
        for name, (changes, meaning) in STIFFNESS.items():
            sets = [c if isinstance(c, str) else f"contacts.{c[0]}.{c[1]}={PRINTED[c[0]][c[1]] * c[2]} N/m" for c in changes]
            runs.append(Run(f"{name}-{seed}", CONFIGS / "1s300-shovel.yaml", meaning,
                            box(LENGTH, 0.33, WIDTH) + [f"time.end={(LEVEL[1] + 0.06) / 0.5:g} s"] + sets, GRIP, lattice_bed(seed)))
    return runs


def beds():
    """One bed each: what packing and walls do to the draft of the same shovel on the same path."""
    shovel = CONFIGS / "1s300-shovel.yaml"
    random = {"fill": "random", "material": "soil", "radius": "10 mm", "settle": "{until: 10 mm/s, at most: 10 s}"}
    end = ["time.end=1.2 s"]
    return [
        Run("dense", shovel, "random, rained with a tenth of friction and rolling; 0.24 m wide",
            box(0.9, 0.22, 0.24) + [words(**random, depth="0.214 m")] + end),
        Run("rest-lattice", shovel, "cubic lattice of the pitch at which the law is at rest; 0.24 m wide",
            box(0.9, 0.22, 0.24) + [words(fill="rest-lattice", material="soil", radius="10 mm", depth="0.214 m", settle=REST)] + end),
        Run("printed-lattice", shovel, "printed lattice of 20.2 mm, settled; 0.24 m wide",
            box(0.9, 0.26, 0.24) + [words(**{**LATTICE, "depth": "0.25 m"}, settle=REST)] + end),
        Run("dense-wide", shovel, "dense, 0.72 m wide, 80 mm more of soil below the tip",
            box(0.9, 0.30, 0.72) + [words(**random, depth="0.294 m")] + end),
    ]


def locked(angle):
    """The shovel welded to the frame, turned by `angle` about H8 (-1.240, 0.570)."""
    c, s = math.cos(angle), math.sin(angle)
    x, y = 0.016, 0.365 - 0.570
    return (f"machine:\n  bodies:\n    shovel: {{at: {-1.240 + c * x - s * y:.6f} {0.570 + s * x + c * y:.6f} m, "
            f"angle: {angle:.6f} rad}}\n  joints:\n    H9: {{fixed: [frame, shovel], at: -1.240 0.840 m}}\n"
            "  forces:\n    H9:\noutput:\n  monitor:\n    spring force:\n")


def driven(angle, height):
    """The shovel on a straight path at this pose; its tip starts where the rig's does."""
    x = -0.98 - (math.cos(angle) * 0.244 + math.sin(angle) * 0.495)
    return [f"boundaries[0].at={x:.6f} {height:.6f} 0 m", f"boundaries[0].rotation.angle={angle:.6f} rad",
            f"boundaries[1].at={x:.6f} {height:.6f} 0 m", f"boundaries[1].rotation.angle={angle:.6f} rad"]


TOWED = -0.05058  # shovel against frame where the rig is towed clear of soil


def spring(out, pose=None):
    rig = CONFIGS / "1s300-towed-random.yaml"
    shovel = CONFIGS / "1s300-shovel.yaml"
    soil = box(LENGTH, 0.33, WIDTH)
    towed = soil + [f"time.end={(LEVEL[1] + 0.06) / 0.5 + 0.2:g} s"]
    pose = pose or loaded_pose(out)
    runs = []
    for seed in SEEDS:
        bed = lattice_bed(seed)
        runs.append(Run(f"free-{seed}", rig, "spring free", towed, GRIP, bed))
        runs.append(Run(f"locked-towed-{seed}", rig, "H9 welded at the angle it has when towed clear of soil", towed,
                        GRIP + locked(TOWED), bed))
        if pose:
            runs.append(Run(f"locked-loaded-{seed}", rig, f"H9 welded at its mean angle under load, {pose[0]:.3f} rad", towed,
                            GRIP + locked(pose[0]), bed))
            runs.append(Run(f"driven-{seed}", shovel, "shovel alone on a straight path at its mean pose and height under load",
                            soil + [f"time.end={(LEVEL[1] + 0.06) / 0.5:g} s"] + driven(pose[1], pose[2]), GRIP, bed))
    return runs


def loaded_pose(out):
    """Angle against the frame, angle and height of the shovel, means of the first bed's steady work."""
    if not (out / "free-1" / "summary.json").exists():
        return None
    s = series(out / "free-1")
    rows = steady_rows(s)
    mean = lambda f: sum(f(i) for i in rows) / len(rows)
    return (mean(lambda i: s["shovel.angle"][i] - s["frame.angle"][i]), mean(lambda i: s["shovel.angle"][i]),
            mean(lambda i: s["shovel.y"][i]))


def check(arguments):
    """Ends with an error where the program refuses a scenario of the study. Poses that earlier runs give are guessed."""
    checked = set()
    for run in runs_of(arguments.study, arguments.out, pose=(-0.11, -0.11, 0.33)):
        kind = run.name.rsplit("-", 1)[0] if run.bed else run.name
        if kind in checked:
            continue
        checked.add(kind)
        scenario = run.base
        if run.text:
            scenario = arguments.out / f"{run.name}.yaml"
            scenario.write_text(f"include: {run.base}\n{run.text}")
        of_bed = [s for s in run.bed.sets if s.startswith("soil.bed=")] if run.bed else []
        command = [arguments.program, "check", str(scenario), *(word for s in run.sets + of_bed for word in ("--set", s))]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"{run.name}: {done.stderr.strip()}")
    print(f"{arguments.study}: {len(checked)} kinds of scenarios are accepted")


def execute(arguments, run):
    out = arguments.out
    if done(out, run):
        return
    scenario, sets = run.base, list(run.sets)
    if run.text:
        scenario = out / f"{run.name}.yaml"
        scenario.write_text(f"include: {run.base}\n{run.text}")
    if run.bed:
        file = out / f"{run.bed.name}.h5"
        if not file.exists():
            sets_of_bed = run.bed.sets + ["time.end=1 ms", f"soil.bed.save={file}"]
            execute(arguments, Run(run.bed.name, run.bed.base, "", sets_of_bed, run.bed.text))
        # Other contact values have another overlap at rest: the bed comes to rest under them first.
        sets.append(f"soil.bed={{fill: file, material: soil, file: {file}, settle: {REST}}}")
    command = [arguments.program, "run", str(scenario), "--out", str(out / run.name), "--force", "--threads", "1"]
    for s in sets:
        command += ["--set", s]
    print(" ".join(command), flush=True)
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        print(f"{run.name}: exit {child.returncode}", file=sys.stderr)
    else:
        (out / run.name / "processor-time").write_text(f"{used.ru_utime + used.ru_stime:.1f} s\n")


# Numbers ------------------------------------------------------------------------------------------------------------

def series(directory):
    with open(directory / "series.csv", newline="") as file:
        rows = list(csv.reader(file))
    names = [label.rsplit(" [", 1)[0] for label in rows[0]]
    return {n: [float(r[i]) for r in rows[1:]] for i, n in enumerate(names)}


def tip(s, i):
    """x of the shovel's tip."""
    a = s["shovel.angle"][i]
    return s["shovel.x"][i] + math.cos(a) * 0.244 + math.sin(a) * 0.495


def steady_rows(s):
    """Rows in which the tip is LEVEL behind the bin's near face. Weights of equal travel are taken by `over_travel`."""
    return [i for i in range(len(s["time"])) if -0.92 + LEVEL[0] <= tip(s, i) <= -0.92 + LEVEL[1]]


def over_travel(s, value):
    """Mean of value(i) over the steady stretch, weighted by the tip's travel."""
    rows = steady_rows(s)
    weight = [tip(s, i) - tip(s, i - 1) for i in rows]
    return sum(w * value(i) for w, i in zip(weight, rows)) / sum(weight)


def statistic(values, kind):
    return {"largest": max(values), "least": min(values), "span": max(values) - min(values)}[kind]


def interval(values):
    """Mean and half width of its 95 % interval."""
    n = len(values)
    mean = sum(values) / n
    if n < 2:
        return mean, float("nan")
    deviation = math.sqrt(sum((v - mean) ** 2 for v in values) / (n - 1))
    return mean, STUDENT[n - 1] * deviation / math.sqrt(n)


def done(out, run):
    return (out / run.name / "summary.json").exists() and summary(out, run)["run"]["end"] != "interrupted"


def summary(out, run):
    return json.loads((out / run.name / "summary.json").read_text())


def processor_time(directory):
    """Seconds of a core, without the bed's."""
    file = directory / "processor-time"
    return float(file.read_text().split()[0]) if file.exists() else float("nan")


def note(out, run):
    s = summary(out, run)
    return "" if s["run"]["end"] == "reached" else f" (stopped at {s['run']['simulated [s]']:.3f} s)"


def six(s):
    return [(y, y / source) for column, kind, source in SOURCE for y in [statistic(s[column], kind)]]


def report_six(out, runs):
    print("| run | " + " | ".join(f"{c}, {k}" for c, k, _ in SOURCE) + " | within 20 % | what |")
    print("|---" * (len(SOURCE) + 3) + "|")
    print("| source | " + " | ".join(f"{v:g}" for _, _, v in SOURCE) + " | | |")
    for run in runs:
        if not done(out, run):
            continue
        numbers = six(series(out / run.name))
        cells = [f"{y:.0f} ({r:.2f})" if abs(y) > 10 else f"{y:.3f} ({r:.2f})" for y, r in numbers]
        within = sum(0.8 <= r <= 1.2 for _, r in numbers)
        print(f"| {run.name}{note(out, run)} | " + " | ".join(cells) + f" | {within} | {run.meaning} |")


def wall_share(s, begin, end, draft):
    """Part of the draft that side and end walls carry."""
    rows = window(s, begin, end)
    return sum(s[f"wall {w}.Fx"][i] for i in rows for w in ("-z", "+z", "+x")) / len(rows) / draft


def report_stiffness(out, runs):
    print("| change | beds | draft, mean (N) | 95 % interval | ratio, same beds | largest overlap (radii) | on walls (%) | processor time (s) |")
    print("|---|---|---|---|---|---|---|---|")
    begin, end = ((x + 0.06) / 0.5 for x in LEVEL)
    runs = {r.name: r for r in runs if done(out, r) and not note(out, r)}
    for name, (_, meaning) in STIFFNESS.items():
        seeds = [s for s in SEEDS if f"{name}-{s}" in runs]
        if not seeds:
            continue
        read = {s: series(out / f"{name}-{s}") for s in seeds}
        of = {s: rigid_draft(read[s], begin, end) for s in seeds}
        ratios = [of[s] / rigid_draft(series(out / f"printed-{s}"), begin, end) for s in seeds if f"printed-{s}" in runs]
        mean, half = interval(list(of.values()))
        ratio, half_ratio = interval(ratios) if ratios else (float("nan"),) * 2
        walls = sum(wall_share(read[s], begin, end, of[s]) for s in seeds) / len(seeds)
        overlap = max(summary(out, runs[f"{name}-{s}"])["run"]["largest overlap [share of a radius]"] for s in seeds)
        cost = sum(processor_time(out / f"{name}-{s}") for s in seeds) / len(seeds)
        print(f"| {meaning} | {len(seeds)} | {mean:.0f} | +- {half:.0f} | {ratio:.3f} +- {half_ratio:.3f} | {overlap:.2f} | "
              f"{100 * walls:.0f} | {cost:.0f} |")


def report_beds(out, runs):
    print("| bed | spheres | kg/m3 | draft 0.6 ... 0.85 s (N) | 0.7 ... 0.9 s | 1.0 ... 1.2 s | of it on sides and end (%) | largest overlap (radii) | what |")
    print("|---|---|---|---|---|---|---|---|---|")
    for run in runs:
        if not (out / run.name / "series.csv").exists():
            continue
        s, of = series(out / run.name), summary(out, run)
        mean = lambda begin, end: rigid_draft(s, begin, end)
        print(f"| {run.name}{note(out, run)} | {of['soil']['spheres']} | {of['soil']['bulk density [kg/m3]']:.0f} | {mean(0.6, 0.85):.0f} | "
              f"{mean(0.7, 0.9):.0f} | {mean(1.0, 1.2):.0f} | {100 * wall_share(s, 1.0, 1.2, mean(1.0, 1.2)):.0f} | {of['run']['largest overlap [share of a radius]']:.2f} | {run.meaning} |")


def rigid_draft(s, begin, end):
    """Mean draft of the shovel without a machine."""
    rows = [i for i, t in enumerate(s["time"]) if begin <= t <= end]
    return sum(s["share draft"][i] + s["shank draft"][i] for i in rows) / len(rows) if rows else float("nan")


def report_spring(out, runs):
    kinds = {}
    for run in runs:
        kinds.setdefault(run.name.rsplit("-", 1)[0], []).append(run)

    def numbers(run):
        s = series(out / run.name)
        if "shovel.x" in s:
            return {"draft": over_travel(s, lambda i: s["draft"][i]), "pull": over_travel(s, lambda i: s["pull"][i]),
                    "depth": over_travel(s, lambda i: tip_depth(s, i))}
        return {"draft": rigid_draft(s, *((x + 0.06) / 0.5 for x in LEVEL))}

    found = {k: {int(r.name.rsplit("-", 1)[1]): numbers(r) for r in of if done(out, r) and not note(out, r)} for k, of in kinds.items()}
    print("| shovel | beds | draft, mean (N) | 95 % interval | free over this, same beds | tip depth (mm) | what |")
    print("|---|---|---|---|---|---|---|")
    for kind, of in kinds.items():
        if not found[kind]:
            continue
        mean, half = interval([v["draft"] for v in found[kind].values()])
        common = [s for s in found[kind] if s in found["free"]]
        ratio, half_ratio = interval([found["free"][s]["draft"] / found[kind][s]["draft"] for s in common]) if common else (float("nan"),) * 2
        depths = [v["depth"] for v in found[kind].values() if "depth" in v]
        depth_cell = f"{1e3 * sum(depths) / len(depths):.0f}" if depths else "-"
        print(f"| {kind} | {len(found[kind])} | {mean:.0f} | +- {half:.0f} | {ratio:.3f} +- {half_ratio:.3f} | {depth_cell} | {of[0].meaning} |")
        print("<!-- " + ", ".join(f"bed {s}: {v['draft']:.0f}" for s, v in sorted(found[kind].items())) + " -->")


def tip_depth(s, i):
    a = s["shovel.angle"][i]
    return -(s["shovel.y"][i] + math.sin(a) * 0.244 - math.cos(a) * 0.495)


# The pass: figures 5 and 6 and conclusion 3 of the source -------------------------------------------------------------

def window(s, begin, end):
    return [i for i, t in enumerate(s["time"]) if begin <= t <= end]


def without_trend(times, values):
    n, mt, mv = len(values), sum(times) / len(times), sum(values) / len(values)
    slope = sum((t - mt) * (v - mv) for t, v in zip(times, values)) / sum((t - mt) ** 2 for t in times)
    return [v - mv - slope * (t - mt) for t, v in zip(times, values)]


def line(times, values, frequency):
    """Complex amplitude of a Hann-weighted record at a frequency: |a| is that of a pure line."""
    n = len(values)
    weights = [0.5 - 0.5 * math.cos(2 * math.pi * (i + 0.5) / n) for i in range(n)]
    total = sum(w * v * complex(math.cos(2 * math.pi * frequency * t), -math.sin(2 * math.pi * frequency * t))
                for w, t, v in zip(weights, times, values))
    return 2 * total / sum(weights)


def lines(times, values, highest=12.0, count=5):
    """The largest local maxima of the amplitude spectrum, from two periods in the record up."""
    step = 0.25 / (times[-1] - times[0])
    frequencies = [2 / (times[-1] - times[0]) + k * step for k in range(int(highest / step))]
    amplitude = [abs(line(times, values, f)) for f in frequencies]
    peaks = [(a, f) for k, (f, a) in enumerate(zip(frequencies, amplitude))
             if (k == 0 or a > amplitude[k - 1]) and (k + 1 == len(amplitude) or a >= amplitude[k + 1])]
    return sorted(peaks, reverse=True)[:count]


def blocks(s, name, rows, length=50):
    """Means over `length` rows."""
    values = [s[name][i] for i in rows]
    return [sum(values[k:k + length]) / length for k in range(0, len(values) - length + 1, length)]


def correlation(a, b):
    ma, mb = sum(a) / len(a), sum(b) / len(b)
    return (sum((x - ma) * (y - mb) for x, y in zip(a, b))
            / math.sqrt(sum((x - ma) ** 2 for x in a) * sum((y - mb) ** 2 for y in b)))


def report_pass(out, runs):
    report_six(out, runs)
    for run in runs:
        if not done(out, run):
            continue
        s = series(out / run.name)
        own = summary(out, run)["window"]
        print()
        for what, begin, end in (("with the entry", 0.6, 1e9), ("tip in the soil", 0.95, 1e9),
                                 ("window of steady work", own["from [s]"], own["until [s]"])):
            report_phase(s, window(s, begin, end), f"{run.name}, {what}")


def report_phase(s, rows, title):
    """Lines of spring force, pull and height; how the spring's energy goes with pull and draft."""
    times = [s["time"][i] for i in rows][::5]
    print(f"{title}, {times[0]:.2f} ... {times[-1]:.2f} s")
    for name in ("spring force", "pull", "height"):
        values = without_trend(times, [s[name][i] for i in rows][::5])
        print(f"- {name}: " + ", ".join(f"{f:.2f} Hz {a:.3g}" for a, f in lines(times, values)))
    energy, pull, draft = (blocks(s, n, rows) for n in ("energy.stored", "pull", "draft"))
    rises = lambda v: [b - a for a, b in zip(v, v[1:])]
    against = sum(e * p < 0 for e, p in zip(rises(energy), rises(pull))) / (len(energy) - 1)
    print(f"- {len(energy)} means over 50 ms: correlation of spring energy with pull {correlation(energy, pull):.2f}, with draft "
          f"{correlation(energy, draft):.2f}; one rises while the other falls, energy against pull, in {100 * against:.0f} % of the time")
    later = {k: correlation(energy[:len(energy) - k], pull[k:]) for k in range(9)}
    best = max(later, key=later.get)
    print(f"- with the pull {50 * best} ms later: {later[best]:.2f}, the largest of 0 ... 400 ms")
    e, p = (line(times, without_trend(times, [s[n][i] for i in rows][::5]), 1.0) for n in ("energy.stored", "pull"))
    degrees = math.degrees(math.atan2((e * p.conjugate()).imag, (e * p.conjugate()).real))
    print(f"- at 1 Hz spring energy leads pull by {degrees:.0f} deg")


# ---------------------------------------------------------------------------------------------------------------------

def runs_of(study, out, pose=None):
    if study == "pass":
        return [Run("pass", CONFIGS / "1s300.yaml", "the full bin")]
    return {"unprinted": unprinted, "stiffness": stiffness, "beds": beds, "spring": lambda: spring(out, pose)}[study]()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", choices=["unprinted", "stiffness", "beds", "spring", "pass"])
    parser.add_argument("--program", default=str(ROOT / "build" / "release" / "apps" / "subsoil"))
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out" / "study")
    parser.add_argument("--only", nargs="*", help="names of runs")
    parser.add_argument("--report", action="store_true")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--jobs", type=int, default=1, help="runs side by side")
    arguments = parser.parse_args()
    arguments.out = arguments.out.resolve()
    if arguments.check:
        arguments.out.mkdir(parents=True, exist_ok=True)
        return check(arguments)
    if not arguments.report:
        arguments.out.mkdir(parents=True, exist_ok=True)
        run_all(arguments)
    runs = runs_of(arguments.study, arguments.out)
    {"stiffness": report_stiffness, "beds": report_beds, "spring": report_spring, "pass": report_pass}.get(arguments.study, report_six)(arguments.out, runs)


def run_all(arguments):
    """In rounds, since the loaded pose of the study of the spring is known only after its first run."""
    tried = set()
    while True:
        runs = [r for r in runs_of(arguments.study, arguments.out) if not arguments.only or r.name in arguments.only]
        runs = [r for r in runs if r.name not in tried]
        if not runs:
            return
        if arguments.study == "spring" and not tried:
            runs = runs[:1]
        tried.update(r.name for r in runs)
        with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
            list(pool.map(lambda run: execute(arguments, run), runs))


if __name__ == "__main__":
    main()
