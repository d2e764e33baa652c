"""Random beds of a few dozen spheres: every law, fill, shape and motion of the declarations."""
import math

from geometry import Box, Faces, Name, Quantity
from values import CONTACT, UnknownUnit, function, magnitude

# Optional keys of a law that it needs one of, by name.
ALWAYS = {"restitution", "K1", "at speed"}
# Keys that only act with a word of another key.
WITH = {
    "cohesion": {"linear": ["cohesion energy density"], "dmt": ["work of adhesion"], "linear-adhesion": ["adhesion force", "adhesion stiffness"],
                 "liquid-bridge": ["surface tension", "contact angle", "liquid volume"]},
    "bond": {"parallel": ["bond modulus", "bond tensile strength", "bond shear strength"]},
}
DEPENDENT = {"contact area", "bridge forms", "friction limit", "c_t", "e_t", "k_r", "c_r", "rolling rule", "rolling damping at limit",
             "tangential damping factor", "limiting force", "K2", "damping", "damping factor", "E_eff", "G_eff", "yield strength", "b", "c", "K_C"}
RADIUS = 0.01


class SoilDraw:
    def __init__(self, rng, declarations, end):
        self.rng, self.declarations, self.end = rng, declarations, end
        self.used = []

    def rounded(self, low, high, digits=4):
        return float(f"{self.rng.uniform(low, high):.{digits}g}")

    def materials(self):
        answer = {}
        for name, density in ("grain", (1.0, 100.0) if self.rng.random() < 0.1 else (1500, 3000)), ("steel", (7000, 8000)):
            answer[Name(name)] = {
                "density": Quantity((self.rounded(*density),), "kg/m^3"), "young's modulus": Quantity((self.rounded(1e6, 5e6, 3),), "Pa"),
                "poisson ratio": self.rounded(0.15, 0.4, 2), "yield strength": Quantity((self.rounded(1e4, 1e5, 3),), "Pa")}
        return answer

    def law(self):
        """The keys of one random law; the same law for all pairs, with its own numbers."""
        rng = self.rng
        name = rng.choice(sorted(n for n, k in self.declarations.children("contacts").items() if k.type == "type"))
        self.used.append(f"contacts.{name}")
        rows = self.declarations.children(f"contacts.{name}")
        answer = {"law": name}
        some = rng.random() < 0.6
        for key in rows.values():
            if not key.required and key.name not in ALWAYS and key.name not in ("mu_r", "mu_t"):
                if key.name in DEPENDENT or not some or rng.random() > 0.2 or "left out:" in key.meaning and key.type != "word":
                    continue
                if any(key.name in needed for words in WITH.values() for needed in words.values()) or key.name.startswith("bond "):
                    continue
            value = self.value(key)
            if value is not None:
                answer[key.name] = value
        for key, words in WITH.items():
            if key in answer:
                for needed in words.get(answer[key], []):
                    answer[needed] = self.value(rows[needed])
        if answer.get("rolling") == "none":  # which the program refuses beside a coefficient
            answer.pop("mu_r", None)
        if "bond" in answer:  # with other moment arms a bond would not keep angular momentum, which the program refuses
            for key in ("moment arm", "moment arm at surfaces", "slip moment arm"):
                answer.pop(key, None)
        if "k1" in answer and "k2" in answer and not answer["k2"].values[0] > answer["k1"].values[0]:
            answer["k2"] = Quantity((5 * answer["k1"].values[0],), answer["k2"].unit)
        if "c" in rows and "n" in answer and "c" not in answer:  # Hertz's stiffness is that of n = 1.5
            answer.pop("n")
        if "normal" in rows and answer.get("normal", "hertz") != "linear":
            answer.pop("k_n", None)
        elif "normal" in rows and "k_n" not in answer:
            answer["k_n"] = self.value(rows["k_n"])
        if name == "eepa":
            if not {"surface energy", "adhesive ratio"} & set(answer):
                answer["adhesive ratio"] = self.value(rows["adhesive ratio"])
            if "n" in answer and "k1" not in answer:  # Hertz's stiffness is that of n = 1.5
                answer["k1"] = Quantity((self.rounded(1e5, 1e7, 3),), f"N/m^{answer['n']:g}")
            answer.pop("chi", None)  # an adhesive ratio compares stiffnesses of one exponent
        return answer

    def value(self, key):
        if key.type == "word":
            return self.rng.choice(key.words)
        if key.type == "yes/no":
            return self.rng.choice(["yes", "no"])
        try:
            unit = "" if key.type == "number" else key.type
            value = magnitude(self.rng, key, unit, CONTACT)
        except UnknownUnit:
            if key.required:
                raise
            return None
        return value if not unit else Quantity((value,), unit)

    def particles(self, count, low, high):
        """Spheres on a jittered grid, some of them touching, with velocities."""
        rng = self.rng
        if rng.random() < 0.1:
            return self.roller(low, high)
        answer = []
        pitch = 2.04 * RADIUS
        cells = [max(1, int((h - l) / pitch)) for l, h in zip(low, high)]
        places = [(i, j, k) for j in range(cells[1]) for i in range(cells[0]) for k in range(cells[2])]
        for i, j, k in places[:count]:
            at = tuple(float(f"{l + pitch * (c + 0.5) + rng.uniform(-0.02, 0.02) * RADIUS:.6g}") for l, c in zip(low, (i, j, k)))
            one = {"position": Quantity(at, "m", "point"), "radius": Quantity((self.rounded(0.85 * RADIUS, RADIUS),), "m")}
            if rng.random() < 0.7:
                one["velocity"] = Quantity(tuple(self.rounded(-0.3, 0.3, 3) for _ in range(3)), "m/s", "direction")
            if rng.random() < 0.3:
                one["angular velocity"] = Quantity(tuple(self.rounded(-10, 10, 3) for _ in range(3)), "rad/s", "axial")
            if rng.random() < 0.05:
                one["fixed"] = Name("stone")
                one.pop("velocity", None)
                one.pop("angular velocity", None)
            answer.append(one)
        return answer

    def roller(self, low, high):
        """One sphere that rolls off a fixed one, of a size up to twenty times its own."""
        rng = self.rng
        ratio, tilt = rng.choice([1.0, 2.0, 4.0, 10.0, 20.0]), self.rounded(0.05, 0.5)
        middle = (0.5 * (low[0] + high[0]), 0.05, 0.0)
        small = RADIUS / ratio
        reach = (RADIUS + small) * (1 - 1e-5)  # pressed together: with a law that adheres rounding decides whether what only touches is in contact
        at = (middle[0] + reach * math.sin(tilt), middle[1] + reach * math.cos(tilt), 0.0)
        return [{"position": Quantity(middle, "m", "point"), "radius": Quantity((RADIUS,), "m"), "fixed": Name("stone")},
                {"position": Quantity(at, "m", "point"), "radius": Quantity((small,), "m")}]

    def shape(self, size):
        """One of the declared shapes, of some `size`; those from files are left to other tests."""
        rng = self.rng
        names = sorted(n for n, k in self.declarations.children("boundaries.shape").items() if k.type != "file")
        name = rng.choice(names)
        self.used.append(f"boundaries.shape.{name}")
        if name == "plane":
            return {"plane": {"point": Quantity((0.0, 0.0, 0.0), "m", "own"), "normal": Quantity((0.1 * self.rounded(-0.2, 0.2), 1.0, 0.0), "", "own")}}
        if name == "box":
            return {"box": Quantity(tuple(self.rounded(0.5 * size, size) for _ in range(3)), "m")}
        if name == "cylinder":
            return {"cylinder": {"radius": Quantity((self.rounded(0.3 * size, 0.5 * size),), "m"), "length": Quantity((self.rounded(size, 2 * size),), "m"),
                                 "axis": Quantity(rng.choice([(0.0, 0.0, 1.0), (1.0, 0.0, 0.0)]), "", "own")}}
        if name == "extrude":
            outline = [(-0.5 * size, -0.5 * size), (0.5 * size, -0.4 * size), (0.3 * size, 0.5 * size)]
            return {"extrude": [Quantity(p, "m", "own") for p in outline], "width": Quantity((size,), "m")}
        answer, rows = {}, self.declarations.children(f"boundaries.shape.{name}")
        head = self.declarations.sections["boundaries"][f"boundaries.shape.{name}"]
        if head.type != "section":
            count = int(head.type[0]) if head.type[:1].isdigit() else 1
            answer[name] = Quantity(tuple(self.rounded(0.5 * size, size) for _ in range(count)), "m")
        numbers = {key.name: Quantity((self.rounded(0.3 * size, 0.6 * size),), "m") for key in rows.values() if key.required and key.type == "m"}
        if head.type == "section":
            answer[name] = numbers
        else:
            answer.update(numbers)
        return answer

    def boundary(self, high):
        rng = self.rng
        size = 0.05
        shape = self.shape(size)
        at = (self.rounded(0.0, high[0]), high[1] + 0.05, 0.0)
        if "plane" in shape:
            at = (0.0, -abs(self.rounded(-0.004, 0.004, 2)), 0.0)
        answer = {"name": Name("plate"), "material": Name("steel"), "shape": shape, "at": Quantity(at, "m", "point")}
        if "plane" not in shape and rng.random() < 0.5:
            answer["rotation"] = {"angle": Quantity((self.rounded(-1, 1),), "rad", "turn")}
        if rng.random() < 0.8:
            moves = {"velocity": Quantity((self.rounded(-0.3, 0.3), self.rounded(-0.4, 0.0), 0.0) if "plane" not in shape else (0.0, 0.0, 0.0), "m/s", "direction")}
            if rng.random() < 0.4 and "plane" not in shape:
                moves["angular velocity"] = Quantity((0.0, 0.0, self.rounded(-3, 3)), "rad/s", "axial")
            if rng.random() < 0.4:
                moves["profile"] = function(rng, self.declarations, "1", 1.0, "scalar", self.end)
            answer["moves"] = [moves]
        return answer

    def draw(self, listed=False):
        """Sections materials, contacts, soil, boundaries. listed: spheres one by one, which every transformation can move."""
        rng = self.rng
        size = (self.rounded(0.08, 0.16), 0.2, self.rounded(0.05, 0.08))
        low = (self.rounded(-0.1, 0.1), 0.0, -0.5 * size[2])
        high = (low[0] + size[0], 0.09, low[2] + size[2])
        contacts, base = [], self.law()
        for pair in ("grain", "grain"), ("grain", "steel"):
            law = dict(base)
            if pair[1] == "steel" and "bond" in law:
                for key in [k for k in law if k.startswith("bond")]:
                    law.pop(key)
            contacts.append({"between": [Name(pair[0]), Name(pair[1])], **law})
        faces = rng.choice([("+y",), ("+y",), ("+y", "-x"), ("+y", "+x", "-z")])
        container = {"container": None}
        container = {**box(size, low), "open": Faces(faces), "material": Name("steel")}
        fills = sorted(set(self.declarations.sections["soil"]["soil.bed.fill"].words) - {"file"})
        fill = "particles" if listed else rng.choice(fills)
        if fill != "particles":  # nothing falls for ever beside the bed
            faces = ("+y",)
            container["open"] = Faces(faces)
        self.used.append(f"soil.bed.fill.{fill}")
        bed = {"fill": fill, "material": Name("grain")}
        if fill == "particles":
            bed["particles"] = self.particles(rng.choice([1, 2, 3, 8, 40]), low, high)
        else:
            bed["radius"] = Quantity((RADIUS,), "m")
            bed["depth"] = Quantity((rng.choice([0.03, 0.05]),), "m")
            if fill == "lattice":
                bed["jitter"] = rng.choice([0, 0.01])
            if fill == "random":
                bed["seed"] = rng.randint(1, 99)
        soil = {"container": container, "bed": bed}
        if rng.random() < 0.2 and faces == ("+y",) and fill in ("particles", "random"):
            container["periodic"] = Faces(("z",))
        if fill == "particles" and rng.random() < 0.25:
            self.clumps(soil, high)
        if rng.random() < 0.15 and fill != "particles":
            soil["surface"] = Quantity((0.0,), "m", "height")
        answer = {"materials": self.materials(), "contacts": contacts, "soil": soil}
        if rng.random() < 0.5:
            answer["boundaries"] = [self.boundary(high)]
        return answer

    def more(self, tree, rng):
        """What stands beside beds: soil that sleeps, layers, an inlet, straw, a window that goes with the plate. `rng` is another than that of
        the bed, so that a bed stays what it was when this list grows."""
        soil, bed = tree["soil"], tree["soil"]["bed"]
        made = bed["fill"] in ("lattice", "random")
        fixed = any("fixed" in one for one in bed.get("particles", []))
        plain = not fixed and "clumps" not in soil and not any(key.startswith("bond") for law in tree["contacts"] for key in law)
        ways = [self.sleeping] if not fixed and "clumps" not in soil else []
        ways += [self.inlet] if plain else []
        ways += [self.mixture] if plain and bed["fill"] == "random" else []
        if made and plain and "periodic" not in soil["container"]:
            ways = [self.layers, self.straw, *ways]
            if self.may_go_on(tree):
                ways = [self.moving]
        if ways and rng.random() < (0.9 if ways == [self.moving] else 0.35):
            self.rng = rng
            way = rng.choice(ways)
            way(tree)
            self.used.append(f"beside the bed: {way.__name__}")

    def sleeping(self, tree):
        tree["soil"]["active"] = {"within": Quantity((self.rounded(0, 0.05),), "m"), "below": Quantity((self.rounded(0.005, 0.05),), "m/s")}

    def another_material(self, tree, name, density, own=()):
        """A soil material with the grains' law to all others; own: keys of its contact with itself."""
        tree["materials"][Name(name)] = {**tree["materials"][Name("grain")], "density": Quantity((density,), "kg/m^3")}
        law = {key: value for key, value in tree["contacts"][0].items() if key != "between"}
        tree["contacts"] += [{"between": [Name(name), Name(other)], **law} for other in ("grain", "steel")]
        tree["contacts"].append({"between": [Name(name), Name(name)], **(own or law)})

    def layers(self, tree):
        bed = tree["soil"]["bed"]
        self.another_material(tree, "clay", self.rounded(1500, 3000))
        bed["depth"] = Quantity((0.05,), "m")
        bed["layers"] = [{"material": Name("clay"), "thickness": Quantity((self.rounded(0.021, 0.029),), "m")}, {"material": Name("grain")}]
        del bed["material"]

    def inlet(self, tree):
        size, low = tree["soil"]["container"]["@box"].size, tree["soil"]["container"]["@box"].at
        edge = (0.05, 0.025, 0.04)
        at = tuple(float(f"{l + self.rng.uniform(0.1, 0.9) * (s - e):.5g}") for l, s, e in zip(low, size, edge))
        tree["soil"]["inlets"] = {Name("spout"): {
            "box": {"@box": Box(edge, (at[0], low[1] + size[1] - edge[1] - 0.005, at[2]))}, "rate": Quantity((self.rounded(50, 400),), "1/s"),
            "radius": Quantity((self.rounded(0.5 * RADIUS, RADIUS),), "m"), "velocity": Quantity((0.0, -self.rounded(0.1, 0.5), 0.0), "m/s", "direction"),
            "seed": self.rng.randint(1, 99)}}

    def mixture(self, tree):
        """Clumps among the grains of a bed, which may go on, or lie between periodic sides or on a rough floor."""
        if self.may_go_on(tree) and "periodic" not in tree["soil"]["container"] and self.rng.random() < 0.5:
            self.moving(tree)
        elif self.rng.random() < 0.3:
            tree["soil"]["bed"]["rough floor"] = Quantity((0.013,), "m")
        tree["soil"]["clumps"] = {Name("pair"): {"spheres": [
            {"at": Quantity((-0.004, 0.0, 0.0), "m", "own"), "radius": Quantity((0.008,), "m")},
            {"at": Quantity((0.005, 0.001, 0.0), "m", "own"), "radius": Quantity((0.006,), "m")}]}}
        tree["soil"]["bed"]["clumps"] = [{"shape": Name("pair"), "share": self.rounded(0.2, 0.8)}]

    def straw(self, tree):
        bond = {"law": "linear", "k_n": Quantity((self.rounded(2e3, 1e4),), "N/m"), "restitution": self.rounded(0.2, 0.8), "mu": self.rounded(0.1, 0.6), "bond": "fibre",
                "bond modulus": Quantity((self.rounded(1e6, 1e7),), "Pa"), "bond tensile strength": Quantity((self.rounded(1e5, 1e7),), "Pa"),
                "bond shear strength": Quantity((self.rounded(1e5, 1e7),), "Pa")}
        self.another_material(tree, "straw", self.rounded(200, 800), bond)
        tree["soil"]["bed"]["fibres"] = {Name("stalk"): {"material": Name("straw"), "length": Quantity((0.032,), "m"), "diameter": Quantity((0.008,), "m"),
                                         "count": self.rng.randint(1, 3), "orientation": self.rng.choice(["horizontal", "random", "x", "z"]), "seed": self.rng.randint(1, 99)}}

    @staticmethod
    def may_go_on(tree):
        """Only a plate that moves along, and nothing that stands in the way."""
        plates = tree.get("boundaries", [])
        return len(plates) == 1 and "plane" not in plates[0]["shape"] and "moves" in plates[0] and "machine" not in tree and tree["soil"]["bed"]["fill"] == "random"

    def moving(self, tree):
        container = tree["soil"]["container"]
        block = 0.06
        container["@box"] = Box((3 * block, container["@box"].size[1], container["@box"].size[2]), container["@box"].at)
        plate = tree["boundaries"][0]
        plate["at"] = Quantity((container["@box"].at[0] + 1.1 * block, plate["at"].values[1], 0.0), "m", "point")
        plate["moves"] = [{"velocity": Quantity((2.5, 0.0, 0.0), "m/s", "direction")}]
        tree["soil"]["moving"] = {"follows": Name("plate"), "block": Quantity((block,), "m")}

    def clumps(self, soil, high):
        rng = self.rng
        soil["clumps"] = {Name("pair"): {"spheres": [
            {"at": Quantity((-0.006, 0.0, 0.0), "m", "own"), "radius": Quantity((0.008,), "m")},
            {"at": Quantity((0.006, 0.001, 0.0), "m", "own"), "radius": Quantity((0.007,), "m")}]}}
        soil["bed"]["placed"] = [{"shape": Name("pair"), "position": Quantity((0.5 * (high[0] + high[0] - 0.08), high[1] + 0.04, 0.0), "m", "point"),
                                  "velocity": Quantity((self.rounded(-0.2, 0.2), -0.3, 0.0), "m/s", "direction"),
                                  "angular velocity": Quantity((0.0, 0.0, self.rounded(-5, 5)), "rad/s", "axial")}]


def depth_below(shape):
    """How far a shape of `SoilDraw.shape` reaches below its place."""
    if "box" in shape:
        return 0.5 * shape["box"].values[1]
    if "extrude" in shape:
        return -min(p.values[1] for p in shape["extrude"])
    if "cylinder" in shape:  # its axes are level
        return shape["cylinder"]["radius"].values[0]
    return 0.06  # the largest number that `shape` gives of a size of 0.05 m, and room


def box(size, at):
    """The keys size and at of a container or region, which transform together."""
    return {"@box": Box(tuple(size), tuple(at))}
