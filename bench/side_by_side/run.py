#!/usr/bin/python3
"""A tine, a wheel and a rig by subsoil, YADE, Kratos DEM and Exudyn: numbers, lines of user code, wall time.

    bench/side_by_side/run.py PROGRAM [--rounds 5] [--peers PYTHON] [--out FOLDER]

PYTHON is that of an environment with KratosDEMApplication and exudyn (PyPI); YADE is Debian's. What is not there is left out.
Rounds are interleaved, one thread each. Times are those of the steps; start-up and reading are left out, in subsoil too.
Forces are means from 0.03 s on. The ratio of times is that of neighbours in a round: median, minimum and maximum."""
import argparse
import csv
import json
import math
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "python"))
import subsoil

RADIUS, FROM = 8e-3, 0.03
HEIGHT = {"tine": 0.025, "wheel": 0.045}


def distance(case, x, y, z):
    """From a point to the tool at its start, m; below zero inside."""
    if case == "tine":
        d = [abs(x - 0.04) - 0.008, abs(y - HEIGHT[case]) - 0.06, abs(z) - 0.015]
    else:
        d = [math.hypot(x - 0.07, y - HEIGHT[case]) - 0.06, abs(z) - 0.03]
    return math.hypot(*[max(c, 0) for c in d]) + min(max(d), 0)


def settle(program, folder):
    """Places of the spheres of each case, without those inside its tool; returns the height of the floor."""
    run = subprocess.run([program, "run", HERE / "bed.yaml", "--out", folder / "bed", "--force"], capture_output=True, text=True)
    if run.returncode:
        sys.exit(run.stdout + run.stderr)
    places = subsoil.open(folder / "bed").frames[-1].position
    for case in HEIGHT:
        with open(folder / f"{case}.csv", "w", newline="") as out:
            rows = csv.writer(out)
            rows.writerow(["x [m]", "y [m]", "z [m]", "radius [mm]"])
            rows.writerows([*map(repr, map(float, p)), RADIUS * 1e3] for p in places if distance(case, *p) > RADIUS)
    return float(places[:, 1].min() - RADIUS)


def lines(*files):
    """Without empty ones and comments."""
    text = [line.strip() for file in files for line in (HERE / file).read_text().splitlines()]
    return sum(1 for line in text if line and not line.startswith("#"))


def result(command, folder, **environment):
    done = subprocess.run(command, cwd=folder, env={**os.environ, "OMP_NUM_THREADS": "1", **environment}, capture_output=True,
                          text=True)
    for line in done.stdout.splitlines():
        if line.startswith("RESULT "):
            return json.loads(line[7:])
    sys.exit(f"{command}:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")


def by_subsoil(program, case, folder, floor):
    for file in ("soil.yaml", f"{case}.yaml"):
        shutil.copy(HERE / file, folder)
    out = folder / f"{case}-subsoil"
    done = subprocess.run([program, "run", folder / f"{case}.yaml", "--out", out, "--force",
                           "--set", f"soil.container.at=0 {floor!r} -0.05 m"],
                          capture_output=True, text=True)
    if done.returncode:
        sys.exit(done.stdout + done.stderr)
    run = subsoil.open(out)
    after = run.series[run.series["time"] > FROM]
    return {"seconds": run.summary["run"]["wall time [s]"], "steps": run.summary["run"]["steps"],
            "draft": after["draft"].mean(), "lift": after["lift"].mean()}


def means(found):
    """Forces are taken every 50 steps of 20 us."""
    after = [f for k, f in enumerate(found["forces"]) if k * 1e-3 > FROM]
    return {**found, "draft": -statistics.fmean(f[0] for f in after), "lift": statistics.fmean(f[1] for f in after)}


def tools(options, folder):
    floor = settle(options.program, folder)
    for case in HEIGHT:
        spheres = sum(1 for _ in open(folder / f"{case}.csv")) - 1
        given = {"HEIGHT": repr(HEIGHT[case]), "FLOOR": repr(floor)}
        bed = str(folder / f"{case}.csv")
        programs = {"subsoil": (lambda: by_subsoil(options.program, case, folder, floor), lines("soil.yaml", f"{case}.yaml"))}
        if shutil.which("yade"):
            command = ["yade", "-n", "-x", "-j1", str(HERE / "tool_yade.py"), case, bed]
            programs["YADE"] = (lambda c=command: means(result(c, folder, **given)), lines("tool_yade.py"))
        if options.peers and has(options.peers, "KratosMultiphysics.DEMApplication"):
            command = [options.peers, str(HERE / "tool_kratos.py"), case, bed]

            def kratos(c=command):
                with tempfile.TemporaryDirectory() as own:
                    return means(result(c, own, **given))
            programs["Kratos DEM"] = (kratos, lines("tool_kratos.py"))
        print(f"{case}: {spheres} spheres, {round(0.1 / 20e-6)} steps", flush=True)
        found = {name: [] for name in programs}
        for k in range(options.rounds):
            for name in list(programs)[::1 if k % 2 == 0 else -1]:
                found[name].append(programs[name][0]())
        for name, runs in found.items():
            ratios = sorted(a["seconds"] / b["seconds"] for a, b in zip(runs, found["subsoil"]))
            print(f"  {name:10} draft {runs[0]['draft']:7.2f} N   lift {runs[0]['lift']:7.2f} N   lines {programs[name][1]:3}   "
                  f"time {min(r['seconds'] for r in runs):7.2f} s   over subsoil {statistics.median(ratios):6.2f} "
                  f"({ratios[0]:.2f} to {ratios[-1]:.2f})", flush=True)


def has(python, module):
    return subprocess.run([python, "-c", f"import {module}"], capture_output=True).returncode == 0


def rig(options, folder):
    def ours(tolerance):
        out = folder / "rig"
        done = subprocess.run([options.program, "run", HERE / "rig.yaml", "--out", out, "--force", "--set",
                               f"time.machine.rtol={tolerance}", "--set", f"time.machine.atol={tolerance}"],
                              capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stdout + done.stderr)
        run = subsoil.open(out)
        last = run.series.iloc[-1]
        return {"seconds": run.summary["run"]["wall time [s]"], "end": [last["x"], last["y"]]}

    exact = ours("1e-14")["end"]
    programs = {"subsoil, 1e-8": (lambda: ours("1e-8"), lines("rig.yaml")),
                "subsoil, 1e-12": (lambda: ours("1e-12"), lines("rig.yaml"))}
    if options.peers and has(options.peers, "exudyn"):
        for steps in (2000, 20000):
            programs[f"Exudyn, {steps} steps"] = (
                lambda s=steps: result([options.peers, str(HERE / "rig_exudyn.py"), str(s)], folder), lines("rig_exudyn.py"))
    found = {name: [] for name in programs}
    for k in range(options.rounds):
        for name in list(programs)[::1 if k % 2 == 0 else -1]:
            found[name].append(programs[name][0]())
    print("rig: three rods, 2 s; error of the last rod's centre")
    for name, runs in found.items():
        end = runs[0]["end"]
        ratios = sorted(a["seconds"] / b["seconds"] for a, b in zip(runs, found["subsoil, 1e-8"]))
        print(f"  {name:20} error {math.dist(end[:2], exact):8.1e} m   lines {programs[name][1]:3}   "
              f"time {min(r['seconds'] for r in runs):7.4f} s   over subsoil, 1e-8 {statistics.median(ratios):6.2f} "
              f"({ratios[0]:.2f} to {ratios[-1]:.2f})", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--peers")
    parser.add_argument("--out", type=pathlib.Path)
    options = parser.parse_args()
    options.program = str(pathlib.Path(options.program).resolve())
    folder = (options.out or pathlib.Path(tempfile.mkdtemp(prefix="side-by-side-"))).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    rig(options, folder)
    tools(options, folder)


if __name__ == "__main__":
    main()
