#!/usr/bin/env python3
"""Holds configs and mistakes against the schemas that the program prints: check_schema.py PROGRAM CONFIGS.

Validator and YAML reader are Debian's python3-jsonschema and python3-yaml. YAML is read as editors do (1.2: `on` is a
word). Every mistake must be refused by `subsoil check` too, so that the schema is no stricter than the reader.
"""
import copy
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import jsonschema
import yaml


class Loader(yaml.SafeLoader):
    """YAML 1.2: truth values are true and false alone; no dates, no numbers to the base 60."""


Loader.yaml_implicit_resolvers = {}
for tag, pattern, first in (("bool", r"true|false", "tf"), ("null", r"~|null|", "~n\0"), ("merge", r"<<", "<"),
                            ("int", r"[-+]?[0-9]+", "-+0123456789"),
                            ("float", r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", "-+.0123456789")):
    letters = [c.replace("\0", "") for c in first]
    Loader.add_implicit_resolver("tag:yaml.org,2002:" + tag, re.compile(f"^(?:{pattern})$"), letters)

program, configs = sys.argv[1], pathlib.Path(sys.argv[2])
of_folder = {"parts": "part", "impact": "impact", "calibrate": "calibrate", "sweep": "sweep",
             "optimise": "optimise", "sensitivity": "sensitivity"}
checkers = {}
faults = 0


def fault(text):
    global faults
    faults += 1
    print(text)


def checker(name):
    if name not in checkers:
        text = subprocess.run([program, "reference", "--schema", name], check=True, capture_output=True).stdout
        schema = json.loads(text)
        jsonschema.Draft7Validator.check_schema(schema)
        checkers[name] = jsonschema.Draft7Validator(schema)
    return checkers[name]


def load(path):
    return yaml.load(path.read_text(), Loader)


def errors(name, document):
    return [f"{'.'.join(map(str, e.absolute_path))}: {e.message[:150]}" for e in checker(name).iter_errors(document)]


def check_configs():
    files = [f for f in sorted(configs.rglob("*.yaml")) if f.parent.name != "materials"]  # the library is no scenario
    for file in files:
        for error in errors(of_folder.get(file.parent.name, "scenario"), load(file))[:3]:
            fault(f"{file.relative_to(configs)}: refused: {error}")
    return len(files)


def reader_refuses(document):
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "case.yaml"
        file.write_text(yaml.safe_dump(document, sort_keys=False))
        return subprocess.run([program, "check", str(file)], capture_output=True).returncode == 2


GONE = object()
MISTAKES = (  # path in the template `tine`, what stands there instead
    ("outptu", {"every": "1 ms"}),  # a misspelt section
    ("soil.bed.fil", "random"),  # misspelt keys
    ("machine.bodies.tine.masss", "1 kg"),
    ("contacts.0.k_m", "50 kN/m"),
    ("contacts.0.law", "liner"),  # unknown words
    ("soil.bed.fill", "latice"),
    ("output.columns", ["position", "spinn"]),
    ("soil.container.open", ["+w"]),
    ("contacts.0.between", GONE),  # missing
    ("contacts.0.mu", GONE),
    ("machine.joints.guide.along", GONE),
    ("materials.soil.density", 2600),  # no unit
    ("soil.container.size", "0.6 0.12 0.2"),
    ("soil.container.size", "0.6 0.12 m"),  # too few numbers
    ("soil.bed", ["random"]),  # a list for a mapping
    ("contacts", {"law": "linear"}),  # a mapping for a list
    ("time.end", None),  # no value
    ("machine.joints.guide.revolute", ["ground", "tine"]),  # two types
    ("machine.joints.guide", {"revolut": ["ground", "tine"], "at": "0 0 m"}),  # no type
    ("machine.surfaces.shank.touches soil", "maybe"),
    ("machine.drivers.tow.velocity", {"ramp": {"too": "1 m/s"}}),  # inside a function of time
    ("contacts.0.K_X", "1 N/m"),  # a key of another law
    ("output.monitor.pull", {"driverr": "tow"}),
    ("limits.overlap", 7),  # out of range
    ("machine.bodies.ti/ne", {"mass": "1 kg", "inertia": "1 kg m^2"}),  # a name that files cannot bear
    ("subsoil", 2),
)
ACCEPTED = (  # the other ways of writing a value
    ("soil.bed.radius", {"normal": "10 mm", "deviation": "1 mm", "minimum": "8 mm", "maximum": "12 mm"}),
    ("soil.container.size", ["600 mm", "0.12 m", "0.2 m"]),
    ("machine.bodies.tine.mass", "2*10 kg"),
    ("machine.drivers.tow.velocity", {"table": [["0 s", "0 m/s"], ["1 s", "1 m/s"], ["2 s", "0 m/s"]]}),
    ("machine.drivers.tow.velocity", ["0.5 m/s", {"ramp": {"from": "0 m/s", "to": "1 m/s", "begin": "0 s",
                                                            "end": "1 s"}}]),
    ("machine.surfaces.shank.touches soil", "yes"),
    ("machine.surfaces.shank.touches soil", True),
    ("gravity", "0 -9.81 0 m/s^2"),
    ("title", 2026),
    ("materials.soil", "library sandy-loam-10mm"),
)


def changed(document, path, value):
    document = copy.deepcopy(document)
    *parents, last = path.split(".")
    node = document
    for key in parents:
        node = node[int(key)] if isinstance(node, list) else node.setdefault(key, {})
    if value is GONE:
        del node[last]
    else:
        node[last] = value
    return document


def check_mistakes():
    tine = changed(load(configs / "templates/tine.yaml"), "soil.bed.depth", "25 mm")  # few spheres: checked at once
    for path, value in MISTAKES:
        wrong = changed(tine, path, value)
        if not errors("scenario", wrong):
            fault(f"{path} = {value}: accepted")
        if not reader_refuses(wrong):
            fault(f"{path} = {value}: the reader accepts it")
    for path, value in ACCEPTED:
        right = changed(tine, path, value)
        for error in errors("scenario", right)[:2]:
            fault(f"{path} = {value}: refused: {error}")
        if reader_refuses(right):
            fault(f"{path} = {value}: the reader refuses it")
    return len(MISTAKES) + len(ACCEPTED)


def check_parts():
    """What an included file completes need not be whole, but its keys are known."""
    own = {"include": "rig.yaml", "machine": {"forces": {"H9": None}, "bodies": {"frame": {"mass": "70 kg"}}}}
    for error in errors("scenario", own):
        fault(f"a scenario that includes a part: refused: {error}")
    own["machine"]["bodies"]["frame"]["masss"] = "70 kg"
    if not errors("scenario", own):
        fault("a misspelt key beside `include`: accepted")
    if not errors("scenario", {"subsoil": 1, "machine": {"forces": {"H9": None}}}):
        fault("a key without value and without `include`: accepted")


count = check_configs() + check_mistakes()
check_parts()
print(f"{count} files and changes, {faults} faults")
sys.exit(1 if faults else 0)
