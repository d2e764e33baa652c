#!/usr/bin/env python3
"""FMUs of the program under FMPy, an importer of others; exit code 77 without it.

usage: fmu_fmpy.py PROGRAM FOLDER
"""
import pathlib
import shutil
import subprocess
import sys
import zipfile

try:
    import fmpy
    import numpy as np
    from lxml import etree
    from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu
    from fmpy.validation import validate_fmu
except ImportError as error:
    print(error)
    sys.exit(77)

PROGRAM, FOLDER = sys.argv[1], pathlib.Path(sys.argv[2])
EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples" / "fmu"
FORCE = [f"tools.plate.{kind}.{axis}" for kind in ("force", "moment") for axis in "xyz"]


def build(name, *options):
    out = FOLDER / f"{name}-{len(list(FOLDER.glob('*.fmu')))}.fmu"
    subprocess.run([PROGRAM, "fmu", EXAMPLES / f"{name}.yaml", "--out", out, *options], check=True)
    return out


class Open:
    """One instance, initialized; inputs and outputs by name."""

    def __init__(self, fmu):
        self.folder = extract(str(fmu))
        description = read_model_description(str(fmu))
        self.reference = {v.name: v.valueReference for v in description.modelVariables}
        self.three = description.fmiVersion.startswith("3")
        self.fmu = instantiate_fmu(self.folder, description, "CoSimulation")
        if not self.three:
            self.fmu.setupExperiment(startTime=0)
        self.fmu.enterInitializationMode(*([] if not self.three else [None, 0]))
        self.fmu.exitInitializationMode()
        self.time = 0.0

    def press(self, steps):
        """The plate goes down at 0.1 m/s; its wrench after every step of 0.1 ms."""
        out = []
        put, get = (self.fmu.setFloat64, self.fmu.getFloat64) if self.three else (self.fmu.setReal, self.fmu.getReal)
        for _ in range(steps):
            put([self.reference["tools.plate.position.y"], self.reference["tools.plate.velocity.y"]],
                [0.022 - 0.1 * self.time, -0.1])
            self.fmu.doStep(currentCommunicationPoint=self.time, communicationStepSize=1e-4)
            self.time += 1e-4
            out.append(get([self.reference[name] for name in FORCE]))
        return np.array(out)

    def state(self):
        return self.fmu.getFMUState(), self.time

    def restore(self, state):
        self.fmu.setFMUState(state[0])
        self.time = state[1]

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder, ignore_errors=True)


def check(condition, text):
    print(("ok " if condition else "FAILED ") + text)
    check.failed = check.failed or not condition


check.failed = False
soils = [build("four-spheres", "--fmi", version) for version in ("3", "2")]
machines = [build("light-plate", "--fmi", version, "--force-on", "plate", "--parameter", "machine.bodies.plate.mass")
            for version in ("3", "2")]
for fmu in soils + machines:
    found = validate_fmu(str(fmu))
    check(not found, f"{fmu.name}: no finding of the validation {found}")
    if fmu in (soils[0], machines[0]):
        # FMPy validates modelDescription.xml alone, and brings the schema of the terminals too.
        folder = pathlib.Path(fmpy.__file__).parent / "schema" / "fmi3"
        schema = etree.XMLSchema(etree.parse(str(folder / "fmi3TerminalsAndIcons.xsd")))
        with zipfile.ZipFile(fmu) as archive:
            terminals = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
            icon = archive.read("terminalsAndIcons/icon.png")
        check(schema.validate(terminals), f"{fmu.name}: terminals and icon are valid {schema.error_log}")
        check(icon[1:4] == b"PNG", f"{fmu.name}: has an icon")

wholes = []
for fmu in soils:
    one, other = Open(fmu), Open(fmu)
    both = [(one.press(1)[0], other.press(1)[0]) for _ in range(60)]
    check(all(np.array_equal(a, b) for a, b in both), f"{fmu.name}: two instances give the same bits")
    wholes.append(np.array([a for a, _ in both]))
    third = Open(fmu)
    third.press(30)
    state = third.state()
    first = third.press(30)
    third.restore(state)
    check(np.array_equal(third.press(30), first), f"{fmu.name}: a restored state continues with the same bits")
    check(np.array_equal(first, wholes[-1][30:]), f"{fmu.name}: taking a state changes no bit")
    data = third.fmu.serializeFMUState(state[0])
    other.restore((other.fmu.deserializeFMUState(data), state[1]))
    check(np.array_equal(other.press(30), first), f"{fmu.name}: a serialized state continues in another copy of the FMU")
    for instance in (one, other, third):
        instance.close()
check(np.array_equal(*wholes), "FMI 2.0 and 3.0 give the same bits")
check(wholes[0][-1][1] > 10, f"the spheres carry the plate: {wholes[0][-1][1]:.1f} N")

# FMPy's own simulation: free fall of the plate for 20 ms under a force of half its weight, x = -g t^2/4.
for fmu in machines:
    mass = 3.0
    signals = np.array([(0.0, 0.5 * mass * 9.81), (1.0, 0.5 * mass * 9.81)],
                       dtype=[("time", float), ("inputs.plate.fy", float)])
    result = simulate_fmu(str(fmu), stop_time=0.02, output_interval=1e-3, input=signals,
                          start_values={"machine.bodies.plate.mass": mass}, output=["bodies.plate.y"])
    fallen, expected = 0.022 - result["bodies.plate.y"][-1], 9.81 * 0.02**2 / 4
    check(len(result) == 21 and abs(fallen / expected - 1) < 1e-6, f"{fmu.name}: falls {fallen:.9f} m, expected {expected:.9f} m")
sys.exit(1 if check.failed else 0)
