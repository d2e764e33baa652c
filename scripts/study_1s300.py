#!/usr/bin/env python3
"""Runs the reduced 1S-300 pass with one cause changed at a time and prints the tables of docs/1s300.md.

    scripts/study_1s300.py --program build/release/apps/subsoil --out out/study            # run what is missing
    scripts/study_1s300.py --out out/study --report                                        # print the tables
    scripts/study_1s300.py ... --only base per-body                                        # some of them
"""
import argparse
import csv
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
REDUCED = ROOT / "configs" / "1s300-reduced.yaml"
LOCKED = ROOT / "configs" / "1s300-reduced-locked.yaml"
RANDOM = ["soil.bed.fill=random", "soil.bed.depth=0.234 m", "soil.bed.settle.at most=10 s"]
SHALLOW = [  # shovel, hinge and spring 50 mm higher: 0.13 m under load
    "machine.bodies.shovel.at=-1.224 0.415 m",
    "machine.joints.H8.at=-1.240 0.620 m",
    "machine.forces.H9.ends=[-1.240 0.890 m, -0.900 0.890 m]",
]
VARIANTS = {
    "base": (REDUCED, [], "as in configs/1s300-reduced.yaml: pair values, rest lattice, 0.18 m"),
    "per-body": (REDUCED, ["contacts.soil-soil.values=per-body", "contacts.soil-steel.values=per-body"],
                 "Table 3's values taken as each body's: all stiffness, damping and attraction halved"),
    "no-damper": (REDUCED, ["machine.forces.H9.damping=0 N s/m"], "H9 without its damper"),
    "shallow": (REDUCED, SHALLOW, "depth 0.13 m under load"),
    "locked": (LOCKED, [], "H9 replaced by a weld of shovel and frame"),
}
for seed in (1, 2, 3):
    VARIANTS[f"random-{seed}"] = (REDUCED, RANDOM + [f"soil.bed.seed={seed}"], f"random bed, seed {seed}")
    VARIANTS[f"random-{seed}-locked"] = (LOCKED, RANDOM + [f"soil.bed.seed={seed}"], f"random bed, seed {seed}, H9 welded")


def run(program, out, name):
    config, sets, _ = VARIANTS[name]
    directory = out / name
    if (directory / "summary.json").exists():
        return
    command = [program, "run", str(config), "--out", str(directory), "--force"]
    for s in sets:
        command += ["--set", s]
    print(" ".join(command), flush=True)
    code = subprocess.run(command).returncode
    if code != 0:
        print(f"{name}: exit {code}", file=sys.stderr)


def series(directory):
    with open(directory / "series.csv", newline="") as file:
        rows = list(csv.reader(file))
    names = [label.rsplit(" [", 1)[0] for label in rows[0]]
    return {n: [float(r[i]) for r in rows[1:]] for i, n in enumerate(names)}


def swing(s, name, since):
    values = [v for t, v in zip(s["time"], s[name]) if t >= since]
    return min(values), max(values)


def entry_time(s):
    return next((t for t, d in zip(s["time"], s.get("draft", s.get("soil.draft", []))) if abs(d) > 20), 0.0)


def report(out):
    print("| run | draft, mean (N) | pull, mean (N) | pull, 1 ms means (N) | spring force, 1 ms means (N) | pitch (rad) "
          "| height span (mm) | spheres | density (kg/m3) | wall share | closure |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for name in VARIANTS:
        directory = out / name
        if not (directory / "summary.json").exists():
            continue
        summary = json.loads((directory / "summary.json").read_text())
        if summary["run"]["end"] != "reached":
            print(f"| {name} | {summary['run'].get('failure', 'stopped')} |" + " |" * 9)
            continue
        s = series(directory)
        start = entry_time(s)
        columns = summary["columns"]
        mean = lambda n: columns[n]["mean in window"] if n in columns else None
        text = lambda v, f="{:.0f}": "-" if v is None else f.format(v)
        span = lambda n, f: "-" if n not in s else (f + " ... " + f).format(*swing(s, n, start))
        height = swing(s, "height", start)
        shares = summary.get("wall shares", summary.get("walls", {}))
        worst = "-"
        numbers = [v["share"] if isinstance(v, dict) and "share" in v else v for v in shares.values()]
        numbers = [v for v in numbers if isinstance(v, (int, float))]
        if numbers:
            worst = f"{100 * max(numbers):.1f} %"
        print(f"| {name} | {text(mean('draft'))} | {text(mean('pull'))} | {span('pull', '{:.0f}')} | "
              f"{span('spring force', '{:.0f}')} | {span('pitch', '{:.3f}')} | {1e3 * (height[1] - height[0]):.1f} | "
              f"{summary['soil']['spheres']} | {summary['soil']['bulk density [kg/m3]']:.0f} | {worst} | "
              f"{100 * summary['energy']['closure over work put in']:.3f} % |")
    print()
    for name, (_, sets, meaning) in VARIANTS.items():
        print(f"- `{name}`: {meaning}" + (f" (`--set {' --set '.join(repr(s) for s in sets)}`)" if sets else ""))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build" / "release" / "apps" / "subsoil"))
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out" / "study")
    parser.add_argument("--only", nargs="*", choices=list(VARIANTS))
    parser.add_argument("--report", action="store_true")
    arguments = parser.parse_args()
    if not arguments.report:
        arguments.out.mkdir(parents=True, exist_ok=True)
        for name in arguments.only or VARIANTS:
            run(arguments.program, arguments.out, name)
    report(arguments.out)


if __name__ == "__main__":
    main()
