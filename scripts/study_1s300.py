#!/usr/bin/env python3
"""Runs the reduced 1S-300 pass with one cause changed at a time and prints the tables of docs/1s300.md.

    scripts/study_1s300.py --program build/release/apps/subsoil --out out/study            # run what is missing
    scripts/study_1s300.py --out out/study --report                                        # print the tables
    scripts/study_1s300.py ... --only base per-body                                        # some of them
    scripts/study_1s300.py ... --only full --threads 2                                     # the full pass: an hour or more
    scripts/study_1s300.py ... --jobs 2                                                    # two at a time, a thread each
"""
import argparse
import concurrent.futures
import csv
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
REDUCED = ROOT / "configs" / "1s300-reduced.yaml"
LOCKED = ROOT / "configs" / "1s300-reduced-locked.yaml"
FULL = ROOT / "configs" / "1s300.yaml"
PER_BODY = ["contacts.soil-soil.values=per-body", "contacts.soil-steel.values=per-body"]
# Variants of the per-body reading stop at 1 s. What is compared is a window that every run reaches: a locked tip stopped at
# 0.853 s at the limit of the overlap.
WINDOW = (0.6, 0.85)
SHORT = PER_BODY + ["time.end=1 s"]
RANDOM = ["soil.bed.fill=random", "soil.bed.depth=0.234 m", "soil.bed.settle.at most=10 s"]
SHALLOW = [  # shovel, hinge and spring 50 mm higher: 0.13 m under load
    "machine.bodies.shovel.at=-1.224 0.415 m",
    "machine.joints.H8.at=-1.240 0.620 m",
    "machine.forces.H9.ends=[-1.240 0.890 m, -0.900 0.890 m]",
]
VARIANTS = {
    "base": (REDUCED, [], "as in configs/1s300-reduced.yaml: pair values, rest lattice, 0.18 m"),
    "per-body": (REDUCED, PER_BODY, "Table 3's values taken as each body's: stiffness, damping and attraction halved"),
    "shallow": (REDUCED, SHORT + SHALLOW, "per-body, depth 0.13 m under load"),
    "no-damper": (REDUCED, SHORT + ["machine.forces.H9.damping=0 N s/m"], "per-body, H9 without its damper"),
    "locked": (LOCKED, SHORT, "per-body, H9 replaced by a weld of shovel and frame"),
}
for seed in (1, 2, 3):
    VARIANTS[f"random-{seed}"] = (REDUCED, SHORT + RANDOM + [f"soil.bed.seed={seed}"], f"per-body, random bed, seed {seed}")
    VARIANTS[f"random-{seed}-locked"] = (LOCKED, SHORT + RANDOM + [f"soil.bed.seed={seed}"],
                                         f"per-body, random bed, seed {seed}, H9 welded")
VARIANTS["full"] = (FULL, [], "the source's bin at rest pitch, pair values; only when named")


def run(program, out, name, threads):
    config, sets, _ = VARIANTS[name]
    directory = out / name
    if (directory / "summary.json").exists():
        return
    command = [program, "run", str(config), "--out", str(directory), "--force", "--threads", str(threads)]
    for s in sets:
        command += ["--set", s]
    print(" ".join(command), flush=True)
    code = subprocess.run(command, stdout=subprocess.DEVNULL).returncode
    if code != 0:
        print(f"{name}: exit {code}", file=sys.stderr)


def series(directory):
    with open(directory / "series.csv", newline="") as file:
        rows = list(csv.reader(file))
    names = [label.rsplit(" [", 1)[0] for label in rows[0]]
    return {n: [float(r[i]) for r in rows[1:]] for i, n in enumerate(names)}


def within(s, name, window):
    return [v for t, v in zip(s["time"], s[name]) if window[0] <= t <= window[1]]


def report(out):
    print("| run | draft, mean (N) | pull, mean (N) | draft, range (N) | spring force, range (N) | pitch (rad) "
          "| height span (mm) | spheres | density (kg/m3) | largest overlap (r) | closure |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    for name in VARIANTS:
        directory = out / name
        if not (directory / "summary.json").exists():
            continue
        summary = json.loads((directory / "summary.json").read_text())
        s = series(directory)
        end = summary["run"]["simulated [s]"]
        if end < WINDOW[1]:
            print(f"| {name} | {summary['run'].get('failure', 'stopped')} |" + " |" * 9)
            continue
        label = name if summary["run"]["end"] == "reached" else f"{name} (stopped at {end:.3f} s)"
        window = (summary["window"]["from [s]"], summary["window"]["until [s]"]) if name == "full" else WINDOW
        mean = lambda n: sum(within(s, n, window)) / len(within(s, n, window))
        span = lambda n, f: "-" if n not in s else (f + " ... " + f).format(min(within(s, n, (0, 9))), max(within(s, n, (0, 9))))
        height = within(s, "height", (0, 9))
        print(f"| {label} | {mean('draft'):.0f} | {mean('pull'):.0f} | {span('draft', '{:.0f}')} | "
              f"{span('spring force', '{:.0f}')} | {span('pitch', '{:.3f}')} | {1e3 * (max(height) - min(height)):.1f} | "
              f"{summary['soil']['spheres']} | {summary['soil']['bulk density [kg/m3]']:.0f} | "
              f"{summary['run']['largest overlap [share of a radius]']:.2f} | "
              f"{100 * summary['energy']['closure over work put in']:.3f} % |")
    print(f"\nMeans are over {WINDOW[0]} ... {WINDOW[1]} s (full: over its summary's window), ranges over the whole run, of "
          "1 ms means.")
    for kind in ("", "-locked"):
        runs = [out / f"random-{seed}{kind}" for seed in (1, 2, 3)]
        runs = [r for r in runs if (r / "summary.json").exists()]
        means = [sum(within(series(r), "draft", WINDOW)) / len(within(series(r), "draft", WINDOW)) for r in runs]
        if len(means) > 1:
            mean = sum(means) / len(means)
            spread = (sum((m - mean) ** 2 for m in means) / (len(means) - 1)) ** 0.5
            print(f"\nRandom beds, {'H9 welded' if kind else 'spring free'}: draft {mean:.0f} N, standard deviation "
                  f"{spread:.0f} N over {len(means)} beds.")
    print()
    for name, (config, sets, meaning) in VARIANTS.items():
        print(f"- `{name}`: {meaning}: `{config.name}`" + "".join(f" `--set \"{s}\"`" for s in sets))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build" / "release" / "apps" / "subsoil"))
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out" / "study")
    parser.add_argument("--only", nargs="*", choices=list(VARIANTS))
    parser.add_argument("--report", action="store_true")
    parser.add_argument("--jobs", type=int, default=1, help="variants run side by side (default 1)")
    parser.add_argument("--threads", type=int, default=1, help="threads of each (default 1: small beds gain little from two)")
    arguments = parser.parse_args()
    if not arguments.report:
        arguments.out.mkdir(parents=True, exist_ok=True)
        names = arguments.only or [name for name in VARIANTS if name != "full"]
        with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
            list(pool.map(lambda name: run(arguments.program, arguments.out, name, arguments.threads), names))
    report(arguments.out)


if __name__ == "__main__":
    main()
