#!/usr/bin/env python3
"""Draws global error against computing time of the machine integrators, one panel per mechanism.

    cmake --preset release -DSUBSOIL_BENCH=ON && cmake --build --preset release --target work_precision
    scripts/work_precision.py --program build/release/bench/work_precision     # measures (minutes), keeps the CSV, draws
    scripts/work_precision.py --table 1e-7                                     # times at equal error, as Markdown
    scripts/work_precision.py                                                  # draws what docs/verification/work-precision.csv holds
"""
import argparse
import csv
import math
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
METHODS = ["adams-moulton 2", "adams-moulton 4", "adams-moulton 6", "cvode", "ida", "ida index 1"]
COLOURS = ["#bbbbbb", "#66aadd", "#224488", "#dd7700", "#118844", "#99bb33"]


def style(i):
    return f"lc rgb '{COLOURS[i]}' pt {i + 4} lw 1.5"


def gnuplot_script(rows, picture, directory):
    """One data file per curve; gnuplot's own key stands in the panel that is left over."""
    mechanisms = list(dict.fromkeys(row["mechanism"] for row in rows))
    lines = ["set terminal pngcairo size 1500,1150 font 'sans,11'", f"set output '{picture}'",
             "set multiplot layout 3,4", "set logscale xy", "set format '10^{%L}'", "set grid",
             "set xlabel 'largest error'", "set ylabel 'time [s]'", "set xtics 100", "set key off"]
    for k, mechanism in enumerate(mechanisms):
        curves = []
        for i, method in enumerate(METHODS):
            points = [(float(r["error"]), float(r["seconds"])) for r in rows
                      if r["mechanism"] == mechanism and r["method"] == method and float(r["error"]) > 0]
            if not points:
                continue
            name = pathlib.Path(directory) / f"{k}-{i}.dat"
            name.write_text("".join(f"{e} {t}\n" for e, t in points))
            curves.append(f"'{name}' with linespoints {style(i)} title '{method}'")
        lines += [f"set title '{mechanism}'", "plot " + ", \\\n     ".join(curves)]
    keys = ", \\\n     ".join(f"NaN with linespoints {style(i)} title '{m}'" for i, m in enumerate(METHODS))
    lines += ["unset logscale", "unset tics", "unset border", "unset title", "unset xlabel", "unset ylabel",
              "set key center center", "set xrange [0:1]", "set yrange [0:1]", "plot " + keys, "unset multiplot"]
    return "\n".join(lines) + "\n"


def time_at_error(rows, mechanism, method, error):
    """Computing time of a method at that error, between its measured points (straight in logarithms), as text in ms; with
    a `<` that of its roughest run where even that errs less; empty where none errs so little."""
    runs = sorted((math.log(float(r["seconds"])), math.log(float(r["error"]))) for r in rows
                  if r["mechanism"] == mechanism and r["method"] == method and float(r["error"]) > 0)
    wanted = math.log(error)
    if runs and runs[0][1] <= wanted:
        return f"< {1e3 * math.exp(runs[0][0]):.3g}"
    for (t0, e0), (t1, e1) in zip(runs, runs[1:]):
        if e1 <= wanted < e0:
            return f"{1e3 * math.exp(t0 + (t1 - t0) * (wanted - e0) / (e1 - e0)):.3g}"
    return ""


def table(rows, error):
    """Markdown: time of each method at the same measured error, in ms."""
    out = [f"| time in ms at an error of {error:g} | " + " | ".join(METHODS) + " |", "|---" * (len(METHODS) + 1) + "|"]
    for mechanism in dict.fromkeys(row["mechanism"] for row in rows):
        times = [time_at_error(rows, mechanism, method, error) for method in METHODS]
        out.append(f"| {mechanism} | " + " | ".join(times) + " |")
    return "\n".join(out)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", help="the built benchmark; left out: draw what has been measured")
    parser.add_argument("--csv", type=pathlib.Path, default=ROOT / "docs" / "verification" / "work-precision.csv")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "docs" / "pictures" / "work-precision.png")
    parser.add_argument("--table", type=float, metavar="ERROR", help="print the times at that error, draw nothing")
    options = parser.parse_args()
    if options.program:
        options.csv.write_text(subprocess.run([options.program], check=True, capture_output=True, text=True).stdout)
    with open(options.csv, newline="") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        sys.exit(f"{options.csv} holds no measurement; give --program")
    if options.table:
        print(table(rows, options.table))
        return
    options.out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as directory:
        script = pathlib.Path(directory) / "plot.gp"
        script.write_text(gnuplot_script(rows, options.out, directory))
        subprocess.run(["gnuplot", str(script)], check=True)
    print(options.out)


if __name__ == "__main__":
    main()
