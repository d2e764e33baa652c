"""Random machines: bodies in a chain or a loop, with every joint, driver, force and measure of the declarations."""
import dataclasses
import math

from geometry import Name, Pair, Profile, Quantity, Text
from values import MACHINE, UnknownUnit, characteristic, function, scalar, unit_of

# Keys that need another one or a file, by name: left to scenarios of their own.
LEFT_OUT = {"controller", "controls", "track", "point", "points", "along angle", "face angle", "sensor lag", "delay", "free length", "free angle"}
ALWAYS = {"stiffness", "surface", "voltage", "maximum", "minimum", "radius", "guide", "supply pressure", "rated flow", "valve", "quadratic", "damping", "torque curve"}


# Equations of a joint; of others two. Too many keep a driver from a machine that has freedom for it, which is no loss.
ROWS = {"fixed": 3, "distance": 1, "point on line": 1, "disk on line": 1, "disk on disk": 1, "gear pair": 1, "gear ratio": 1, "rack and pinion": 1, "coupler": 1,
        "cam": 1, "flat-faced cam": 1, "point on curve": 1}
WITH_STATES = {"hydraulic cylinder", "electric motor", "joint friction"}


class MachineDraw:
    def __init__(self, rng, declarations, end):
        self.rng, self.declarations, self.end = rng, declarations, end
        self.bodies = {}      # name -> (x, y)
        self.angles = {"ground": 0.0}
        self.joint_kinds = {}  # name -> element
        self.used = []        # declared elements that were drawn

    def rounded(self, low, high):
        return float(f"{self.rng.uniform(low, high):.4g}")

    def near(self, body, reach=0.2):
        x, y = self.bodies.get(body, (0.0, 0.0))
        return (float(f"{x + self.rng.uniform(-reach, reach):.5g}"), float(f"{y + self.rng.uniform(-reach, reach):.5g}"))

    def pair(self):
        names = list(self.bodies)
        second = self.rng.choice(names)
        return self.rng.choice([n for n in ["ground", *names] if n != second]), second

    def element(self, path, name, pair):
        """The mapping of one element; pair: its two bodies, the second of which moves."""
        rng = self.rng
        head = self.declarations.sections["machine"][f"{path}.{name}"]
        rows = self.declarations.children(f"{path}.{name}")
        first, second = pair
        if name == "outline contact" and first == "ground":
            return None  # its outline would be given in the world's axes
        self.first, self.second = first, second
        if name == "coupler" and first == "ground":
            return None
        answer = {}
        if head.type.startswith("[name of a body"):
            answer[name] = [Name(first), Name(second)]
        elif head.type == "name of a body":
            answer[name] = Name(second)
        elif head.type == "name of a joint":
            wanted = [j for j, kind in self.joint_kinds.items() if kind in ("revolute", "translational")]
            if not wanted:
                return None
            joint = rng.choice(wanted)
            answer[name] = Name(joint)
        elif head.type.startswith("body.x"):
            suffix = rng.choice([".x", ".y", ".angle"])
            answer[name] = Name(second, suffix)
        else:
            return None
        a, b = self.near(first), self.near(second)
        if math.dist(a, b) < 0.05:
            b = (b[0] + 0.1, b[1])
        along = (float(f"{math.cos(0.7 * rng.randint(0, 8)):.6g}"), float(f"{math.sin(0.7 * rng.randint(0, 8)) + 0.01:.6g}"))
        inside = "inside" in rows and rng.random() < 0.3
        moved = [key for key in rows.values() if "function of time" in key.type]
        driven = path == "machine.drivers"
        chosen = driven and moved and rng.choice([key.name for key in moved if key.name != "position"])
        some = rng.random() < 0.6
        for key in rows.values():
            if key.name == "turn" and first == "ground":  # axes of the world that turn with it
                answer[key.name] = Quantity((self.rounded(-1, 1),), "rad", "attitude")
                continue
            optional = not key.required
            if key.name in LEFT_OUT or (optional and "instead of" in key.meaning and not driven):
                continue
            if driven and key in moved and key.name != chosen:
                continue
            if optional and key.name not in ALWAYS and key.name != chosen and not (some and rng.random() < 0.3):
                continue
            value = self.value(path, name, key, a, b, along, inside, answer)
            if value is not None:
                answer[key.name] = value
        self.pair_world_vectors(answer, rows)
        drop_without_effect(answer)
        return answer

    def pair_world_vectors(self, answer, rows):
        """Components `... x` and `... y` of a world vector become one leaf, which rotates."""
        if "axes" in answer and answer["axes"] == "body":
            if "along x" in answer:
                answer["along x"] = dataclasses.replace(answer["along x"], kind="own x")
            return
        for key in list(answer):
            other = key[:-1] + "y"
            if key.endswith(" x") and other in rows and "along" in key and "function of time" in rows[key].type:
                unit = unit_of(rows[key].type)
                y = answer.pop(other, None) or function(self.rng, self.declarations, unit, 1.0, "scalar", self.end, ["constant"])
                answer[key] = Pair((key, answer[key]), (other, y))
            elif key.endswith(" y") and "along" in key and key[:-1] + "x" in rows and key[:-1] + "x" not in answer:
                unit = unit_of(rows[key].type)
                x = function(self.rng, self.declarations, unit, 1.0, "scalar", self.end, ["constant"])
                answer[key] = Pair((key[:-1] + "x", x), (key, answer[key]))

    def value(self, path, element, key, a, b, along, inside, answer):
        rng, kind = self.rng, key.type
        if kind.startswith("body.x"):
            return Name(self.first, rng.choice([".x", ".y", ".angle"]))
        if element == "coupler":
            return coupling(rng, answer)
        if key.name == "radius" and "ends" in self.declarations.children(f"{path}.{element}") and path == "machine.joints":
            length = math.hypot(*along)
            gap = abs((b[0] - a[0]) * along[1] - (b[1] - a[1]) * along[0]) / length
            return Quantity((gap,), "m") if gap > 0.01 else None
        if key.name == "first radius":
            d = math.dist(a, b)
            # Disks of a joint touch; those of a contact do not, since rounding decides whether what touches has a slip.
            apart = 0.97 if path == "machine.forces" else 1.0
            return Quantity((1.5 / apart * d if inside else 0.4 * apart * d,), "m")
        if key.name == "second radius":
            d = math.dist(a, b)
            return Quantity((0.5 * d if inside else 0.6 * d,), "m")
        if key.name == "inside":
            return "yes" if inside else "no"
        if key.name == "side":
            return "outside"
        if key.name == "length":
            return Quantity((float(f"{math.dist(a, b):.12g}"),), "m")
        if key.name == "closed length":
            return Quantity((float(f"{0.5 * math.dist(a, b):.6g}"),), "m")
        if key.name in ("minimum", "maximum"):
            return self.stop(element, key, a, b)
        if "world of the start pose" in key.meaning or key.type.startswith("list of two points"):
            if kind.startswith("list of two points"):
                return [Quantity(a, "m", "point"), Quantity(b, "m", "point")]
            return Quantity(b, "m", "point")
        if kind == "2 numbers" and ("world vector" in key.meaning or "direction" in key.meaning):
            return Quantity(along, "", "side" if "left" in key.meaning else "direction")
        if kind.startswith("list of [rad, m]"):
            return self.profile(math.dist(a, b), self.first == "ground")
        if kind.startswith("list of 2 numbers m"):
            frame = "point" if self.first == "ground" else "own"
            return [Quantity((float(f"{0.1 * i - 0.2:.3g}"), float(f"{0.05 * math.sin(2 * i):.4g}")), "m", frame) for i in range(5)]
        if kind == "yes/no":
            return rng.choice(["yes", "no"])
        if kind == "word":
            return rng.choice(key.words)
        if kind.startswith("name of a body"):
            return Name("ground")
        if "function of time" in kind:
            unit = unit_of(kind)
            low, high = MACHINE.get(unit, (0.1, 1.0))
            frame = "turn" if unit in ("rad", "rad/s", "rad/s^2", "N m", "V") else "scalar"
            if element == "coordinate":
                target = answer["coordinate"].suffix
                # the declared unit is that of a length; of an angle it is rad
                unit = unit.replace("m", "rad", 1) if target == ".angle" else unit
                frame = {".x": "x", ".y": "y", ".angle": "turn"}[target]
            return function(rng, self.declarations, unit, math.sqrt(low * high), frame, self.end)
        if "characteristic" in kind:
            unit, argument = [part.strip() for part in kind.split(",")[0].split(" over ")]
            low, high = MACHINE[unit]
            # The torque of a motor falls with its speed: one that grows feeds the motion without bound.
            sense = -1.0 if key.name == "torque curve" else 1.0
            return characteristic(rng, self.declarations, unit, argument, sense * math.sqrt(low * high), 0.3, "turn" if unit == "N m" else "scalar")
        if kind == "one of the forms below":
            return self.form(f"{path}.{element}.{key.name}")
        if kind == "whole number":
            return rng.randint(2, 4)
        if kind == "text":
            return None
        if kind.startswith(("2 numbers", "3 numbers", "list")):
            return None
        value = scalar(rng, key, "" if kind == "number" else kind, MACHINE)
        if key.name in ("internal friction", "restitution from"):  # angles and rates without a sense
            return Quantity(value.values, value.unit)
        if key.name == "preload x":
            return Quantity(value.values, value.unit, "own x")
        if value.unit == "A":
            return Quantity(value.values, value.unit, "turn")
        if key.name == "surface":
            return Quantity((min(p[1] for p in self.bodies.values()) - 0.25,), "m", "height")
        if element == "gear ratio" or value.unit not in ("rad",):
            return Quantity(value.values, value.unit, value.kind if value.unit == "N m" else "scalar")
        return value

    def stop(self, element, key, a, b):
        unit = key.type
        if unit == "rad":
            relative = self.angles.get(self.second, 0.0) - self.angles.get(self.first, 0.0)
            return None if key.name == "minimum" else Quantity((float(f"{relative + 0.2:.6g}"),), "rad", "bound" if self.first == "ground" else "bound inside")
        if "distance" in element:
            d = math.dist(a, b)
            return Quantity((float(f"{d * (0.8 if key.name == 'minimum' else 1.2):.6g}"),), "m")
        return Quantity((-0.15 if key.name == "minimum" else 0.15,), "m")

    def profile(self, radius, of_ground=False):
        count = 9
        return Profile(tuple((-180 + 360 * i / (count - 1), radius * (1 + 0.03 * math.cos(4 * math.pi * i / (count - 1)))) for i in range(count)), of_ground)

    def form(self, path):
        """One of the forms of a key, such as the stiffness of a ground element."""
        forms = self.declarations.children(path)
        name = self.rng.choice(sorted(forms))
        head = forms[name]
        if head.type == "formula":
            return {name: "1e4*(1+z)"}
        if head.type.startswith("list of [m, N/m]"):
            return {name: [["0 m", "5 kN/m"], ["0.05 m", "8 kN/m"]]}
        if head.type.startswith("list of [rad, m]"):
            return {name: self.profile(0.08)}
        if head.type.startswith("list of 2 numbers m"):
            square = [(-0.06, -0.05), (0.06, -0.05), (0.06, 0.05), (-0.06, 0.05)]
            if "flank" in name:  # its left is free: mirrored and in the other order it is itself
                return {name: [Quantity(p, "m") for p in ((0.2, 0.0), (0.0, 0.02), (-0.2, 0.0))]}
            return {name: [Quantity(p, "m", "own") for p in square]}
        if head.type == "2 numbers m":
            return {name: Quantity((0.0, -0.05), "m", "own")}
        answer = {name: scalar(self.rng, head, "" if head.type == "number" else head.type, MACHINE)}
        for key in self.declarations.children(f"{path}.{name}").values():
            if key.required:
                answer[key.name] = scalar(self.rng, key, "" if key.type == "number" else key.type, MACHINE)
        return answer

    def draw(self, joints=None, forces=None):
        """The section `machine`."""
        rng = self.rng
        machine = {"bodies": {}, "joints": {}, "forces": {}, "drivers": {}}
        kinds = sorted(self.declarations.elements("machine.joints"))
        force_kinds = sorted(self.declarations.elements("machine.forces"))
        driver_kinds = sorted(self.declarations.elements("machine.drivers"))
        if joints is None and rng.random() < 0.08:
            return self.four_bar()
        for k in range(rng.choice([1, 2, 2, 3, 3, 4])):
            name = f"b{k}"
            self.bodies[name] = (self.rounded(-0.5, 0.5), self.rounded(-0.5, 0.5))
            mass = self.rounded(0.5, 4)
            self.angles[name] = rng.choice([0.0, self.rounded(-2, 2)])
            body = {"mass": Quantity((mass,), "kg"), "inertia": Quantity((float(f"{mass * rng.uniform(0.1, 0.3)**2:.4g}"),), "kg m^2"),
                    "at": Quantity(self.bodies[name], "m", "point"), "angle": Quantity((self.angles[name],), "rad", "attitude"),
                    "pose is": "about"}
            if rng.random() < 0.5:
                body["velocity"] = Quantity((self.rounded(-1, 1), self.rounded(-1, 1)), "m/s", "direction")
                body["angular velocity"] = Quantity((self.rounded(-2, 2),), "rad/s", "turn")
                body["velocity is"] = "about"
            machine["bodies"][Name(name)] = body
        names = list(self.bodies)
        for k, name in enumerate(names):
            if rng.random() < 0.12:
                continue
            kind = rng.choice(joints or (kinds + ["revolute"] * 8 + ["translational"] * 3))
            self.add(machine, "joints", f"j{k}", kind, (rng.choice(["ground", *names[:k]]), name))
        if len(names) > 2 and rng.random() < 0.2:
            self.add(machine, "joints", "loop", rng.choice(joints or kinds), (rng.choice(["ground", names[0]]), names[-1]))
        for k in range(rng.choice([0, 1, 1, 2, 3])):
            self.add(machine, "forces", f"f{k}", rng.choice(forces or force_kinds), self.pair())
        if rng.random() < 0.3:
            pair = self.pair()
            self.add(machine, "drivers", "d0", rng.choice(driver_kinds), pair)
        if rng.random() < 0.12:
            self.beam(machine)
        if rng.random() < 0.15:
            self.controller(machine)
        if machine["joints"] and rng.random() < 0.12:
            self.event(machine)
        self.free_drivers(machine)
        self.measures(machine)
        return {key: value for key, value in machine.items() if value}

    def free_drivers(self, machine):
        """Takes away what would drive a machine without freedom, or a body that is fixed to the one it is driven against."""
        rows = sum(ROWS.get(kind, 2) for kind in self.joint_kinds.values())
        held = {body for name, kind in self.joint_kinds.items() if kind == "fixed" for body in bodies_of(machine["joints"][Name(name)], machine)}
        for name, driver in list(machine["drivers"].items()):
            if 3 * len(self.bodies) - rows < 1 or held & set(bodies_of(driver, machine)):
                del machine["drivers"][name]
                self.used = [one for one in self.used if not one.startswith("machine.drivers.")]

    def driven_throughout(self, machine):
        """For `analysis: kinematics`: pins and slides in a chain, one driver for each, forces without states."""
        names = [name.text for name in machine["bodies"]]
        machine["joints"], machine["drivers"] = {}, {}
        for part in ("controllers", "beams", "events"):
            machine.pop(part, None)
        for force in [name for name, f in machine.get("forces", {}).items() if next(iter(f)) in WITH_STATES or {"controller", "stick stiffness"} & set(f)]:
            del machine["forces"][force]
        self.joint_kinds = {}
        for k, name in enumerate(names):
            pair = (self.rng.choice(["ground", *names[:k]]), name)
            kind, driver = self.rng.choice([("revolute", "angle"), ("translational", "slide")])
            self.add(machine, "joints", f"j{k}", kind, pair)
            self.add(machine, "drivers", f"d{k}", driver, pair)
            if kind == "translational":
                machine["drivers"][Name(f"d{k}")]["along"] = machine["joints"][Name(f"j{k}")]["along"]
        self.measures(machine)

    def four_bar(self):
        """A four-bar linkage that turns over and over; one in two is a parallelogram, which passes its flat pose."""
        rng = self.rng
        a, base, tilt = self.rounded(0.2, 0.5), self.rounded(0.6, 1.0), self.rounded(-1, 1)
        other = a if rng.random() < 0.5 else self.rounded(1.2, 1.6) * a
        reach = base if other == a else None
        crank = (a * math.cos(tilt), a * math.sin(tilt))
        far = (base + other * math.cos(tilt), other * math.sin(tilt)) if reach else (base, other)
        speed = self.rounded(5, 30)
        machine = {"bodies": {}, "joints": {}}
        for name, p, q in ("crank", (0.0, 0.0), crank), ("coupler", crank, far), ("rocker", (base, 0.0), far):
            self.bodies[name] = (0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1]))
            mass = self.rounded(0.5, 2)
            length = math.dist(p, q)
            machine["bodies"][Name(name)] = {"mass": Quantity((mass,), "kg"), "inertia": Quantity((mass * length**2 / 12,), "kg m^2"),
                                             "at": Quantity(self.bodies[name], "m", "point"), "velocity is": "about"}
        machine["bodies"][Name("crank")].update({"angular velocity": Quantity((speed,), "rad/s", "turn"), "velocity": Quantity(
            (-0.5 * speed * crank[1], 0.5 * speed * crank[0]), "m/s", "direction")})
        if reach:
            machine["bodies"][Name("rocker")].update({"angular velocity": Quantity((speed,), "rad/s", "turn"), "velocity": Quantity(
                (-0.5 * speed * crank[1], 0.5 * speed * crank[0]), "m/s", "direction")})
            machine["bodies"][Name("coupler")]["velocity"] = Quantity((-speed * crank[1], speed * crank[0]), "m/s", "direction")
        for name, pair, at in (("A0", ("ground", "crank"), (0.0, 0.0)), ("A", ("crank", "coupler"), crank), ("B", ("coupler", "rocker"), far),
                               ("B0", ("ground", "rocker"), (base, 0.0))):
            machine["joints"][Name(name)] = {"revolute": [Name(n) for n in pair], "at": Quantity(at, "m", "point")}
        machine["forces"] = {}
        self.measures(machine)
        self.used.append("four-bar")
        return {key: value for key, value in machine.items() if value}

    def add(self, machine, section, name, kind, pair):
        try:
            made = self.element(f"machine.{section}", kind, pair)
        except UnknownUnit:
            self.used.append(f"unknown unit: machine.{section}.{kind}")
            return
        if made is None:
            return
        machine[section][Name(name)] = made
        self.used.append(f"machine.{section}.{kind}")
        if section == "joints":
            self.joint_kinds[name] = kind

    def beam(self, machine):
        """An elastic beam, clamped to the ground, of a random section."""
        rows = self.declarations.children("machine.beams.<name>")
        start, turn = self.near("ground"), self.rng.uniform(0, 6)
        end = (float(f"{start[0] + 0.4 * math.cos(turn):.5g}"), float(f"{start[1] + 0.4 * math.sin(turn):.5g}"))
        forms = self.declarations.children("machine.beams.<name>.section")
        section = self.rng.choice(sorted(forms))
        numbers = {"m": (0.012,), "2 numbers m": (0.012, 0.02), "3 numbers m": (0.012, 0.02, 0.002), "m^2": (1e-4,)}[forms[section].type]
        if section == "tube":
            numbers = (0.012, 0.002)
        form = {section: Quantity(numbers, forms[section].type.split()[-1])}
        for key in self.declarations.children(f"machine.beams.<name>.section.{section}").values():
            if key.required:
                form[key.name] = scalar(self.rng, key, key.type, MACHINE)
        beam = {"points": [Quantity(start, "m", "point"), Quantity(end, "m", "point")], "section": form, "young's modulus": Quantity((2e8,), "Pa"),
                "density": Quantity((2000.0,), "kg/m^3"), "elements": self.rng.randint(2, 4), "damping ratio": 0.05}
        assert set(beam) <= set(rows)
        machine["beams"] = {Name("bar"): beam}
        machine["joints"][Name("clamp")] = {"fixed": [Name("ground"), Name("bar", " start")], "at": Quantity(start, "m", "point")}
        self.used.append(f"machine.beams.section.{section}")

    def controller(self, machine):
        """A controller of a distance that drives a spring between the same points."""
        body, at = list(self.bodies)[0], self.near("ground")
        machine["markers"] = {Name("post"): {"body": Name("ground"), "at": Quantity(at, "m", "point")}}
        kind = self.rng.choice(sorted(self.declarations.elements("machine.controllers")))
        make = {"pid": self.pid, "formula": self.formula, "transfer function": self.transfer_function, "table of two": self.table_of_two}.get(kind)
        if make is None:
            raise UnknownUnit(f"machine.controllers.{kind}: no drawing of it in tests/consistency/machine.py")
        machine["controllers"] = {Name("hold"): make()}
        machine["forces"][Name("pull")] = {"spring-damper": [Name("ground"), Name(body)], "ends": [Quantity(at, "m", "point"),
                                           Quantity(self.bodies[body], "m", "point")], "stiffness": Quantity((30.0,), "N/m"), "controller": Name("hold")}
        self.used.append(f"machine.controllers.{kind}")

    def formula(self):
        a, b = self.rounded(5, 30), self.rounded(1, 10)
        parts = self.rng.choice([(f"-{a}*", Name("gap"), f" + {b}*tanh(", Name("pace"), ")"), (f"{a}*sin(4*", Name("gap"), ")"),
                                 (f"{b}/(1+", Name("pace"), f"^2) - {a}*", Name("gap"))])
        return {"formula": Text(parts), "output in": "N"}

    def transfer_function(self):
        lag, gain = self.rounded(0.02, 0.2), self.rounded(2, 20)
        numerator = [gain] if self.rng.random() < 0.5 else [0.1 * gain, gain]
        return {"transfer function": Name("gap"), "measured in": "m", "output in": "N", "numerator": numerator, "denominator": [lag**2, lag, 1.0]}

    def table_of_two(self):
        rows, columns = [0.0, 0.3, 0.8, 1.5], [0.0, 0.5, 2.0]
        values = [float(f"{self.rng.uniform(-10, 10):.3g}") for _ in range(len(rows) * len(columns))]
        return {"table of two": [Name("gap"), Name("pace")], "first in": "m", "second in": "m/s", "output in": "N", "first": rows, "second": columns,
                "values": values}

    def pid(self):
        """With a filter, or sampled."""
        controller = {
            "pid": Name("gap"), "measured in": "m", "output in": "N", "set point": function(self.rng, self.declarations, "m", 0.3, "scalar", self.end),
            "proportional": Quantity((self.rounded(5, 50),), "N/m"), "integral": Quantity((self.rounded(0, 20),), "N/(m s)"),
            "derivative": Quantity((self.rounded(0, 3),), "N s/m"), "filter time": Quantity((0.02,), "s")}
        if self.rng.random() < 0.4:
            controller["sample time"] = Quantity((0.01,), "s")
            del controller["filter time"]
        return controller

    def event(self, machine):
        joint = self.rng.choice([name for name in machine["joints"]])
        machine["events"] = {Name("trip"): {"opens": Name(joint.text), "at": Quantity((float(f"{self.rng.uniform(0.2, 0.8) * self.end:.4g}"),), "s")}}
        self.used.append("machine.events")

    def measures(self, machine):
        """What every joint and force puts on every body, about its centre: enough to write Newton's and Euler's laws."""
        measures = {}
        for section, kind in ("joints", "reaction"), ("forces", "force"):
            for name, element in machine.get(section, {}).items():
                for body in bodies_of(element, machine):
                    measures[Name(f"on {body} by {name.text}")] = {kind: name, "on": Name(body), "about": Name(body)}
        if "controllers" in machine:
            measures[Name("gap")] = {"distance": [Name("post"), Name(list(self.bodies)[0])]}
            measures[Name("pace")] = {"velocity": Name(list(self.bodies)[0]), "component": "size"}
        machine["measures"] = measures


def drop_without_effect(answer):
    """Keys beside which another one acts, which the program refuses."""
    for given, others in ("restitution", ("damping",)), ("stick stiffness", ("slip speed",)):
        for other in others if given in answer else ():
            answer.pop(other, None)
    if not answer.get("friction"):
        answer.pop("stick stiffness", None)
    for needed, others in ("restitution", ("restitution from",)), ("stick stiffness", ("stick damping",)), ("shear displacement", ("cohesion",)):
        for other in others if needed not in answer and "joint friction" not in answer else ():
            answer.pop(other, None)
    if "flow given" in answer:  # in place of the valve
        for key in ("valve", "supply pressure", "start pressure b"):
            answer.pop(key, None)
    if "ground element" in answer and "length" in answer:  # a stamp, not a wheel
        answer.pop("radius", None)
    if "wheel on soil" in answer and not ("cohesion" in answer and "internal friction" in answer):
        for key in ("shear displacement", "cohesion", "internal friction"):
            answer.pop(key, None)


def coupling(rng, answer):
    """The ratio of a coupler: lengths over angles, and as a mirror has it."""
    one, other = (answer[key].suffix == ".angle" for key in ("coupler", "follows"))
    odd = sum(answer[key].suffix in (".x", ".angle") for key in ("coupler", "follows"))
    unit = "" if one == other else "rad/m" if one else "m/rad"
    if one and other:
        return Quantity((float(f"{rng.uniform(0.5, 2):.3g}"),), unit)
    return Quantity((float(f"{rng.uniform(0.5, 2):.3g}"),), unit, "axes turn" if odd == 1 else "axes")


def bodies_of(element, machine):
    """Moving bodies on which an element acts."""
    if "coupler" in element:
        return [element["follows"].text, element["coupler"].text]
    head = next(iter(element.values()))
    if isinstance(head, Name) and not head.suffix:
        if head.text in {n.text for n in machine["joints"]}:
            return bodies_of(machine["joints"][head], machine)
        named = [head]
    else:
        named = head if isinstance(head, list) else []
    carrier = element.get("carrier")
    if carrier:
        named = [*named, carrier]
    moving = {n.text for n in machine["bodies"]}
    return [n.text for n in named if isinstance(n, Name) and n.text in moving and not n.suffix]
