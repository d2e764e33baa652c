"""Outputs against each other: what a run prints, its rows, its summary, `check`, watches, `report`."""
import json
import re

import numpy

import compare
from case import last_line, relation
from geometry import Quantity

@relation("machine", "soil", "coupled")
def sentences(case):
    """A refusal or a stopped run says why; an end in order leaves no number that is none."""
    base = case.base
    if base.code not in (0, 2, 3):
        return [f"exit code {base.code}: {last_line(base.text)}"]
    if base.code:
        return [] if len(last_line(base.text)) > 20 else [f"exit code {base.code} without a sentence"]
    bad = [name for name, values in base.table().items() if not numpy.isfinite(values).all()]
    return [f"{name} is not finite" for name in bad[:3]]


@relation("machine", "soil", "coupled")
def check_against_run(case):
    verdict = case.program.check(case.tree)
    if (verdict.code == 2) != (case.base.code == 2) or verdict.code not in (0, 2, 3):
        return [f"check ends with {verdict.code}, the run with {case.base.code}: {last_line(case.base.text)}"]
    return []


@relation("soil", "coupled")
def check_predicts(case):
    """`check` counts the spheres, the steps and the frames that a run then has, and gives the step that it takes."""
    if not case.base.ended:
        return []
    text, run, soil = case.program.check(case.tree).text, case.base.summary()["run"], case.base.summary()["soil"]
    found = {word: re.search(rf"^{word} .*?([0-9][0-9.e+-]*)", text, re.MULTILINE) for word in ("spheres", "soil step", "steps")}
    found["frames"] = re.search(r"^disk .* in ([0-9]+) frames", text, re.MULTILINE)
    missing = [word for word, one in found.items() if one is None]
    if missing:
        return [f"check prints no {', no '.join(missing)}"]
    bed, wide = case.tree["soil"]["bed"], 1e-3  # four digits are printed
    made = bed["fill"] == "random" or "fibres" in bed  # a lattice stands for what is poured and laid
    if "inlets" not in case.tree["soil"] and "moving" not in case.tree["soil"] and not made and int(found["spheres"][1]) != soil["spheres"]:
        return [f"check counts {found['spheres'][1]} spheres, the run has {soil['spheres']}"]
    answer = []
    for word, right in ("soil step", run["soil step [s]"]), ("steps", run["steps"]), ("frames", run["frames"]):
        if abs(float(found[word][1]) - right) > (0.3 if made and word != "frames" else wide) * right + (word == "steps"):
            answer.append(f"check says {word} {found[word][1]}, the run has {right:.6g}")
    return answer


@relation("machine", "soil", "coupled")
def extremes(case):
    """No row in the window lies beyond the extremes of the summary; means lie between them and are those of the rows."""
    if not case.base.ended or case.scenario.analysis != "dynamics":
        return []
    table, summary, answer = case.base.table(), case.base.summary(), []
    opens, closes = summary["window"]["from [s]"], summary["window"]["until [s]"]
    if opens is None or closes is None:
        return []
    times = table["time"]
    inside = (times >= opens - 1e-12) & (times <= closes + 1e-12)
    for name, entry in summary.get("columns", {}).items():
        found = entry.get("steps in window")
        if name not in table or not found or not inside.any():
            continue
        mean_rows = "soil" in case.tree and entry["unit"] in ("N", "N m")
        values = table[name][inside][1:] if mean_rows else table[name][inside]
        values = values[numpy.isfinite(values)]
        if not values.size:
            continue
        slack = 1e-6 * max(compare.size_of(values), abs(found["max"]), abs(found["min"]), 1e-300)
        if values.max() > found["max"] + slack:
            answer.append(f"{name}: a row has {values.max():.9g}, the summary's maximum of a step {found['max']:.9g}")
        if values.min() < found["min"] - slack:
            answer.append(f"{name}: a row has {values.min():.9g}, the summary's minimum of a step {found['min']:.9g}")
        mean = entry["mean in window"]
        if mean is not None and not found["min"] - slack <= mean <= found["max"] + slack:
            answer.append(f"{name}: mean {mean:.9g} beyond its extremes {found['min']:.9g} to {found['max']:.9g}")
        whole = opens <= times[0] + 1e-12 and closes >= times[-1] - 1e-12
        if mean is not None and mean_rows and whole and len(times) > 2:
            rows = float((table[name][1:] * numpy.diff(times)).sum() / (times[-1] - times[0]))
            if abs(rows - mean) > 1e-3 * max(compare.size_of(values), 1e-9):
                answer.append(f"{name}: mean of the summary {mean:.9g}, of the rows {rows:.9g}")
    return answer[:4]


def first_body(case):
    return next(iter(case.tree["machine"]["bodies"])).text


@relation("machine", "coupled")
def watches(case):
    """Integrals, means, extremes and formulas over time agree with the columns that they follow; watching changes no bit."""
    if not case.base.ended or case.scenario.analysis != "dynamics":
        return []
    body = first_body(case)
    v = f"{body}.vx"
    watch = {"way": {"integral": v}, "top": {"maximum": v}, "bottom": {"minimum": v}, "average": {"mean": v},
             "square": {"formula": "v^2 + 1", "of": {"v": v}, "unit": "m^2/s^2"}, "late top": {"maximum": v, "within": "1 s"}}
    other = case.program.run({**case.tree, "output": {**case.tree["output"], "monitor": watch}})
    if not other.ended:
        return [f"with watches: exit code {other.code}: {last_line(other.text)}"]
    table = other.table()
    answer = compare.bits(*compare.common_rows(case.base.table(), table))[:2]
    t, speed, x = table["time"], table[v], table[f"{body}.x"]
    size = max(compare.size_of(speed), 1e-6)
    slack = max(1e-5, case.floor)
    if "soil" in case.tree:  # beside soil speeds are known at the ends of steps: an error of second order in the step
        slack = max(1e-3, (other.summary()["run"]["soil step [s]"] * compare.size_of(table[f"{body}.ax"]) / size) ** 2)
    opened = any(True for _ in case.tree["machine"].get("events", {}))
    if not opened and "beams" not in case.tree["machine"]:
        off = compare.spread(table["way"] - (x - x[0])) / max(compare.spread(x - x[0]), 1e-3 * size * t[-1])
        if off > slack:
            answer.append(f"integral of {v} is off the way by {off:.3g}")
    for name, sign in ("top", 1.0), ("bottom", -1.0), ("late top", 1.0):
        so_far = numpy.maximum.accumulate(sign * speed)
        if (sign * table[name] < so_far - 1e-9 * size).any():
            answer.append(f"{name}: {table[name][-1]:.9g} is passed by a row, {sign * so_far[-1]:.9g}")
        if name != "late top" and (numpy.diff(sign * table[name]) < -1e-12 * size).any():
            answer.append(f"{name} goes back")
    off = compare.spread(table["average"][1:] * (t[1:] - t[0]) - table["way"][1:]) / max(compare.size_of(table["way"]), 1e-3 * size * t[-1])
    if off > 1e-6:
        answer.append(f"mean times time is off the integral by {off:.3g}")
    off = compare.spread(table["square"] - (speed**2 + 1)) / (size**2 + 1)
    if off > 1e-9 and "soil" not in case.tree:
        answer.append(f"a formula is off its columns by {off:.3g}")
    return answer[:4]


@relation("machine", "coupled")
def work_of_driver(case):
    """The integral of a driver's force times the driven speed is the driver work of the energy balance."""
    drivers = case.tree.get("machine", {}).get("drivers", {})
    if not case.base.ended or case.scenario.analysis != "dynamics" or len(drivers) != 1:
        return []
    (name, driver), = drivers.items()
    if "coordinate" not in driver:
        return []
    target = driver["coordinate"]
    speed = {".x": "vx", ".y": "vy", ".angle": "spin"}[target.suffix]
    force = f"{name.text}.torque" if target.suffix == ".angle" else f"{name.text}.force"
    watch = {"power": {"formula": "F*v", "of": {"F": force, "v": f"{target.text}.{speed}"}, "unit": "W"}, "work": {"integral": "power"}}
    other = case.program.run({**case.tree, "output": {**case.tree["output"], "monitor": watch}})
    if not other.ended:
        return [f"with watches: exit code {other.code}: {last_line(other.text)}"]
    table = other.table()
    work = table["energy.driver work"]
    size = max(compare.size_of(work), compare.size_of(table["energy.kinetic"]), 1e-9)
    # Beside soil a reaction in the middle of a step is the mean of both its ends, of which the first knows the soil's force of the step before.
    run = case.base.summary()["run"]
    late = (run.get("machine step [s]", 0.0) if "soil step [s]" in run else 0.0) * compare.size_of(table["power"])
    off = compare.spread(table["work"] - work)
    return [f"driver work {work[-1]:.9g} J, integral of force times speed {table['work'][-1]:.9g} J"] if off > max(1e-4, case.floor) * size + late else []


@relation("machine", "soil", "coupled")
def losses(case):
    """What is lost does not come back. Conventions of other programs may create energy, which counts as a negative loss in sliding.
    What the ground under a body gives back as it is unloaded, at most F^2/(2 q K'), counts against its loss."""
    if not case.base.ended or case.scenario.analysis != "dynamics" or case.says_unstable:
        return []
    creates = any(law.get("conventions", "own") != "own" or law.get("friction rule") == "spring-set-back" or law.get("rolling rule") == "spring-set-back"
                  or law.get("changing stiffness", "lossy") != "lossy" for law in case.tree.get("contacts", []))
    table = case.base.table()
    moved = max([compare.size_of(v - v[0]) for n, v in table.items() if n.startswith(("energy.", "soil.")) and case.base.units[n] == "J"] + [1e-12])
    given_back = {"energy.lost": ground_gives_back(case, table)}
    return [f"{name} falls by {-numpy.diff(table[name]).min():.3g} J of {moved:.3g} J moved" for name in ("energy.lost", "soil.damped", *(() if creates else ("soil.slid",)))
            if name in table and len(table[name]) > 1 and numpy.diff(table[name]).min() < -1e-4 * moved - given_back.get(name, 0.0)]


def ground_gives_back(case, table):
    """F^2/(2 q K') of all ground elements, K' = F/z where z is the maximum."""
    total = 0.0
    for key, force in case.tree.get("machine", {}).get("forces", {}).items():
        if "ground element" in force:
            q = force["unloading"].values[0] if "unloading" in force else 100.0
            total += compare.size_of(table[f"{key.text}.soil force"]) * compare.size_of(table[f"{key.text}.depth"]) / (2 * q)
    return total


@relation("machine", "soil", "coupled")
def python_module(case):
    """python/subsoil reads the same numbers."""
    import pathlib
    import sys
    if not case.base.ended:
        return []
    folder = str(pathlib.Path(__file__).resolve().parents[2] / "python")
    if folder not in sys.path:
        sys.path.insert(0, folder)
    try:
        import subsoil
    except ImportError:
        return []  # needs pandas
    run, table = subsoil.open(case.base.folder), case.base.table()
    answer = [f"{name}: other numbers in Python" for name in table
              if not numpy.array_equal(run.series[name].to_numpy(), table[name], equal_nan=True)]
    if "soil" in case.tree and len(run.frames):
        places = case.base.spheres()
        if places and not numpy.array_equal(run.frames[-1].position[:, 0], places["sphere place.x"]):
            answer.append("frames[-1].position: other numbers in Python")
    return answer[:3]


COUNTS = (".open", ".sticking", ".contacts", ".spheres", "soil.bonds", "soil.bonds broken in tension", "soil.bonds broken in shear", ".broken bonds", ".cut bonds", "soil.frozen spheres")


@relation("machine", "soil", "coupled")
def counts(case):
    """States of joints and friction, and numbers of contacts, bonds and spheres, are whole in every row."""
    if not case.base.ended:
        return []
    table = case.base.table()
    if "soil" in case.tree and any(name.endswith(COUNTS) for name in table):  # rows between the ends of nearly all steps
        every = 2.37 * case.base.summary()["run"]["soil step [s]"]
        other = case.program.run({**case.tree, "output": {**case.tree["output"], "series every": Quantity((every,), "s")}})
        table = other.table() if other.ended else table
    broken = {name: values for name, values in table.items() if name.endswith(COUNTS) and (values != numpy.round(values)).any()}
    return [f"{name}: {values[values != numpy.round(values)][0]!r} is no whole number" for name, values in broken.items()][:3]


@relation("machine", "soil", "coupled")
def report(case):
    """`report` gives the means and extremes of the window as the summary does, under the column's name."""
    if not case.base.ended or case.scenario.analysis != "dynamics":
        return []
    path = case.base.folder.parent / "report.html"
    code, stdout, stderr = case.program.command("report", case.base.folder, "--out", path)
    if code:
        return [f"report: exit code {code}: {last_line(stdout + stderr)}"]
    summary, answer = case.base.summary().get("columns", {}), []
    for number in embedded(path.read_text(), '"numbers":'):
        name, word = number["quantity"], number["statistic"]
        entry = summary.get(name) or summary.get({"draft": "soil.draft", "lift": "soil.lift"}.get(name))
        if entry is None or word not in ("mean", "least", "largest"):
            continue
        right = entry["mean in window"] if word == "mean" else (entry["steps in window"] or {}).get({"least": "min", "largest": "max"}[word])
        size = max(abs((entry["steps in window"] or {}).get(side, 0.0)) for side in ("min", "max"))
        # Six digits are printed, of numbers that may be small differences of large ones.
        if right is not None and abs(number["value"] - right) > 1e-5 * max(size, abs(right)):
            answer.append(f"{name}: {word} {number['value']:.6g} in the report, {right:.6g} in the summary")
    return answer[:3]


def embedded(text, key):
    """The JSON value that follows the key's first place in a page."""
    at = text.find(key)
    return json.JSONDecoder().raw_decode(text, at + len(key))[0] if at >= 0 else []
