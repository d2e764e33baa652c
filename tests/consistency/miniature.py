"""A program of a hundred lines for the tests of this tool: free bodies and spheres under gravity, and faults to plant.

It reads the same documents and leaves the same files, so that each relation can be shown to hold of an honest program and
to fail of one with a certain fault.
"""
import csv
import json
import pathlib

import h5py
import numpy
import yaml

from geometry import View, render
from program import Program, Result, dump

FACTORS = {"mm": 1e-3, "cm": 1e-2, "m": 1, "kg": 1, "g": 1e-3, "t": 1e3, "s": 1, "ms": 1e-3, "m/s": 1, "mm/s": 1e-3, "cm/s": 1e-2, "rad": 1,
           "rad/s": 1, "m/s^2": 1, "mm/s^2": 1e-3, "kg m^2": 1, "kg/m^3": 1, "g/cm^3": 1e3}


STEP = 1e-4  # s, of the soil


def numbers(text, default=0.0):
    if text is None:
        return default
    words = str(text).split()
    values = []
    while words:
        try:
            values.append(float(words[0]))
        except ValueError:
            break
        words.pop(0)
    factor = FACTORS[" ".join(words)] if words else 1.0
    return numpy.array([v * factor for v in values])


def read(path):
    """The document with its includes."""
    document = yaml.safe_load(path.read_text())
    for name in document.get("include", []):
        document = {**read(path.parent / name), **document}
    return document


class Miniature(Program):
    """faults: words that `simulate` understands."""

    def __init__(self, *faults):
        super().__init__("/bin/false")
        self.faults = set(faults)

    def command(self, word, path, *options, limit=None, cwd=None):
        self.runs += 1
        if word == "report":
            return self.report(pathlib.Path(path), pathlib.Path(options[options.index("--out") + 1]))
        if word == "resume":
            return self.resume(pathlib.Path(path))
        document = read(pathlib.Path(path))
        out = pathlib.Path(options[options.index("--out") + 1]) if "--out" in options else pathlib.Path(path).parent / "none"
        for option, value in zip(options, options[1:]):
            if option == "--set" and "set ignored" not in self.faults:
                document["time"]["end"] = value.split("=", 1)[1]
        if "crash" in self.faults:
            return -11, "", ""
        if "silent refusal" in self.faults:
            return 2, "", ""
        if word == "check":
            return (2 if "check refuses" in self.faults else 0), self.foretold(document), "checked\n"
        self.simulate(document, out, [str(o) for o in options])
        return 0, "", ""

    def foretold(self, document):
        """What `check` prints of a run."""
        steps = float(numbers(document["time"]["end"])[0]) / STEP * (1.1 if "check predicts" in self.faults else 1.0)
        count = len(document.get("soil", {}).get("bed", {}).get("particles", []))
        return f"spheres         {count}\nsoil step       {STEP:.4g} s, 0.1 of the stable step\nsteps           {steps:.0f} for the run\ndisk            about 1 MB in 2 frames\n"

    def report(self, folder, path):
        columns = json.loads((folder / "summary.json").read_text())["columns"]
        share = 1.001 if "report" in self.faults else 1.0
        numbers = [{"quantity": name, "statistic": "mean", "value": entry["mean in window"] * share} for name, entry in columns.items()]
        path.write_text('{"numbers":' + json.dumps(numbers) + "}")
        return 0, "", ""

    def resume(self, folder):
        """Steps the whole again, which an honest program need not."""
        whole = folder.with_name(f"{folder.name} again")
        self.simulate(read(folder.parent / "scenario.yaml"), whole, [])
        rows = (whole / "series.csv").read_text().splitlines(keepends=True)
        (folder / "series.csv").write_text("".join(rows[:-1] if "resume" in self.faults else rows))
        (folder / "summary.json").write_text((whole / "summary.json").read_text())
        return 0, "", ""

    def run(self, tree, view=None, options=(), word="run", limit=None):
        document = tree if isinstance(tree, str) else render(tree, view or View())
        path = self.write(document)
        out = path.parent / "out"
        return Result(out, *self.command(word, path, *(["--out", out] if word == "run" else []), *options), document)

    def simulate(self, d, out, options):
        out.mkdir(parents=True)
        faults = self.faults
        end = float(numbers(d["time"]["end"])[0])
        every = float(numbers(d["output"]["series every"])[0])
        start = float(pathlib.Path(options[options.index("--from") + 1]).stem.split("-", 1)[1]) if "--from" in options else 0.0
        t = numpy.append(numpy.arange(round(end / every)) * every, end)
        t = t[t >= start - 1e-12]
        if d.get("machine", {}).get("start") and "equilibrium" not in faults:
            d["gravity"] = "0 0 0 m/s^2"
        g = numbers(d["gravity"])
        if "gravity along y" in faults:
            g = numpy.array([0.0, -numpy.linalg.norm(g), 0.0])
        method = d["time"].get("machine", {}).get("integrator", "auto")
        columns = {"time [s]": t}
        kinetic = 0.0
        for k, (name, body) in enumerate(d.get("machine", {}).get("bodies", {}).items()):
            a = g[:2].copy()
            if "names matter" in faults and name > "c":
                a *= 1.01
            if "order matters" in faults:
                a *= 1 + 0.01 * k
            if "rows matter" in faults:
                a *= 1 + every
            if "state lost" in faults and start:
                a *= 1.01
            if "method matters" in faults and method == "ida":
                a *= 1.01
            if "include matters" in faults and "include" in d:
                a *= 1.01
            if "defaults matter" in faults and d.get("defaults explicit"):
                a *= 1.01
            x = numbers(body["at"])
            if "far is rough" in faults:
                x = numpy.round(x, 1 if abs(x[0]) > 100 else 12)
            if "far is rough there" in faults and "0.0 0.0 m" not in str(body["at"]) and abs(x[0]) not in (0.1, 0.3):
                x = x + 0.01
            if "handed" in faults:
                a[0] += 0.01
            if "units misread" in faults and "mm" in str(body["at"]):
                x = 1.001 * x
            v, w = numbers(body.get("velocity"), numpy.zeros(2)), float(numpy.ravel(numbers(body.get("angular velocity"), numpy.zeros(1)))[0])
            m, inertia = float(numbers(body["mass"])[0]), float(numbers(body["inertia"])[0])
            position, velocity = x[:, None] + v[:, None] * t + 0.5 * a[:, None] * t**2, v[:, None] + a[:, None] * t
            columns.update({f"{name}.x [m]": position[0], f"{name}.y [m]": position[1],
                            f"{name}.angle [rad]": float(numpy.ravel(numbers(body.get("angle"), numpy.zeros(1)))[0]) + w * t,
                            f"{name}.vx [m/s]": velocity[0], f"{name}.vy [m/s]": velocity[1], f"{name}.spin [rad/s]": w + 0 * t,
                            f"{name}.ax [m/s^2]": a[0] + 0 * t, f"{name}.ay [m/s^2]": a[1] + 0 * t, f"{name}.alpha [rad/s^2]": 0 * t})
            kinetic = kinetic + 0.5 * m * (velocity**2).sum(axis=0) + 0.5 * inertia * w**2
        if "machine" in d:
            columns["energy.kinetic [J]"] = kinetic * (1.01 if "energy" in faults else 1.0)
            columns["energy.balance [J]"] = 0 * t
            self.machine_extras(d, columns, t)
        particles = d.get("soil", {}).get("bed", {}).get("particles", [])
        if particles:
            self.spheres(particles, d, t, g, out, columns, options)
        if "not a number" in faults:
            columns[list(columns)[-1]][-1] = float("nan")
        with open(out / "series.csv", "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(columns)
            writer.writerows([repr(float(x)) for x in row] for row in zip(*columns.values()))
        largest = numpy.mean if "maximum" in faults else numpy.max
        entries = {head.split(" [")[0]: {"unit": head[:-1].split(" [")[1], "mean in window": float(v.mean()),
                                         "steps in window": {"min": float(v.min()), "max": float(largest(v))}}
                   for head, v in columns.items() if head != "time [s]"}
        summary = {"columns": entries, "run": {"soil step [s]": STEP, "steps": round(end / STEP), "frames": 2}, "equilibrium": {"pose": {n: {} for n in d.get("machine", {}).get("bodies", {})}, "coordinates that nothing holds": 0, "unstable eigenvalues": 0},
                   "soil": getattr(self, "facts", {}), "window": {"from [s]": 0.0, "until [s]": end}}
        (out / "summary.json").write_text(json.dumps(summary))
        (out / "scenario.yaml").write_text(dump({**d, "defaults explicit": True}))
        for instant in (end / 2, end):
            (out / f"state-{instant!r}.h5").write_text("")

    def machine_extras(self, d, columns, t):
        """Watches, a driver that follows the motion, the exchange with soil that is not there."""
        faults = self.faults
        names = list(d["machine"]["bodies"])
        v = columns[f"{names[0]}.vx [m/s]"]
        way = columns[f"{names[0]}.x [m]"] - columns[f"{names[0]}.x [m]"][0]
        if "drivers" in d["machine"]:
            columns["energy.driver work [J]"] = columns["energy.kinetic [J]"] - columns["energy.kinetic [J]"][0]
        for name, watch in d["output"].get("monitor", {}).items():
            word = next(iter(watch))
            if word == "integral":
                values = way * (1.01 if "integral" in faults else 1.0) if watch[word] != "power" else columns["energy.driver work [J]"] * 1.0
                values = values * (1.01 if "driver" in faults else 1.0)
            elif word in ("maximum", "minimum"):
                values = numpy.maximum.accumulate(v) if word == "maximum" else numpy.minimum.accumulate(v)
                values = values * (0.99 if "extremes" in faults else 1.0)
            elif word == "mean":
                values = numpy.append(v[0], way[1:] / t[1:]) if t[0] == 0 else v
            else:
                values = v**2 + 1
            columns[f"{name} [{watch.get('unit', 'm')}]"] = values
        columns["rest.contacts [1]"] = 0 * t + 0.5 * ("counts" in faults)
        power = numbers(d["machine"]["bodies"][names[0]]["mass"])[0] * (numbers(d["gravity"]) ** 2).sum() * t[-1]
        columns["energy.lost [J]"] = power * (t[-1] - t if "losses" in faults else t)
        if "soil" in d:
            zero = 0 * t
            columns.update({"interface.on machine [J]": zero + ("interface" in faults) * t, "interface.on soil [J]": zero, "energy.external work [J]": zero})
            columns[f"{names[0]}.soil.Fx [N]"] = zero + ("impulse" in faults)
            columns[f"{names[0]}.soil.Fy [N]"] = zero

    def spheres(self, particles, d, t, g, out, columns, options):
        faults = self.faults
        x = numpy.array([numbers(p["position"]) for p in particles])
        v = numpy.array([numbers(p.get("velocity"), numpy.zeros(3)) for p in particles])
        r = numpy.array([float(numbers(p["radius"])[0]) for p in particles])
        rho = float(numbers(d["materials"]["grain"]["density"])[0])
        mass = rho * 4 / 3 * numpy.pi * r**3
        a = g * (1.01 if "threads matter" in faults and "--threads" in options else 1.0)
        if "across" in faults:
            a = a + numpy.array([0.0, 0.0, 0.01])
        if "step matters" in faults:
            a = a * (1 + (1e-5 / float(numpy.ravel(numbers(d["time"].get("soil step"), 1.0))[0]))**2)
        fixed = numpy.array(["fixed" in p for p in particles])
        with h5py.File(out / "run.h5", "w") as file:
            for name, values in ("radius", r), ("density", rho * (1.01 if "mass" in faults else 1.0) + 0 * r):
                file[f"particles/{name}"] = values
            for k, time in enumerate((0.0, t[-1])):
                moving = (v + a * time * (1.02 if "momentum" in faults else 1.0)) * ~fixed[:, None]
                spin = numpy.array([numbers(p.get("angular velocity"), numpy.zeros(3)) for p in particles]) * (1 + 1e5 * time * ("torque" in faults))
                place = file.create_group(f"frames/{k:06d}")
                place.attrs["time"] = time
                place["spin"] = spin
                place["position"] = x + (v * time + 0.5 * a * time**2) * ~fixed[:, None]
                if "fixed moves" in faults:
                    place["position"][...] += 0.1 * time
                place["contacts"] = numpy.zeros(len(r)) if "contacts" in faults else numpy.full(len(r), 3)
                file[f"frames/{k:06d}/velocity"] = moving
        free = ~fixed[:, None]
        drop = [(mass * ((v + 0.5 * a * time) * time @ g)).sum() for time in t]
        zero = 0 * t
        columns.update({"soil.spin [J]": zero, "soil.gravity [J]": -numpy.array(drop), "soil.stored [J]": zero, "soil.damped [J]": zero, "soil.slid [J]": zero,
                        "soil.rolled [J]": zero, "soil.removed [J]": zero, "soil.boundary work [J]": zero})
        self.facts = {"spheres": len(particles), "mass [kg]": float(mass.sum())}
        columns["soil.kinetic [J]"] = numpy.array([0.5 * (mass[:, None] * ((v + a * time) * free)**2).sum() for time in t])
