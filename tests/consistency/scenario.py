"""Random whole scenarios: machine alone, soil alone, both; the analyses, time, output and watches."""
import dataclasses
import random

from geometry import Name, Quantity
from machine import MachineDraw
from soil import SoilDraw, depth_below
from values import constant

INTEGRATORS = ("auto", "adams-moulton", "cvode", "ida")


@dataclasses.dataclass
class Scenario:
    seed: int
    kind: str          # machine, soil, coupled
    tree: dict
    used: list         # declared elements in it

    @property
    def analysis(self):
        return self.tree.get("analysis", "dynamics")

    @property
    def integrator(self):
        return self.tree.get("time", {}).get("machine", {}).get("integrator", "auto")


def draw(seed, declarations, kind=None):
    rng, beside = random.Random(seed), random.Random(f"beside {seed}")
    kind = kind or rng.choice(["machine", "machine", "machine", "soil", "soil", "coupled"])
    tree, used = {"subsoil": 1}, []
    end = rng.choice([0.05, 0.1, 0.3]) if kind == "machine" else rng.choice([0.02, 0.04])
    gravity = (0.0, -9.81, 0.0) if rng.random() < 0.9 else (0.0, 0.0, 0.0)
    if kind == "machine":
        draw_ = MachineDraw(rng, declarations, end)
        tree["machine"] = draw_.draw()
        analyses = declarations.sections["Top level"]["analysis"].words
        if rng.random() < 0.25:
            tree["analysis"] = rng.choice(analyses)
            used.append(f"analysis.{tree['analysis']}")
            if tree["analysis"] == "kinematics":
                draw_.driven_throughout(tree["machine"])
            elif tree["analysis"] != "dynamics":  # at rest
                tree["machine"].pop("drivers", None)
        used += draw_.used
    else:
        soil = SoilDraw(rng, declarations, end)
        tree.update(soil.draw(listed=kind == "coupled" or rng.random() < 0.6))
        if kind == "coupled":
            # A tool and another surface do not feel each other, which ends a run.
            tree["boundaries"] = [one for one in tree.get("boundaries", []) if "plane" in one["shape"]]
            tree.update({} if tree["boundaries"] else {"boundaries": None})
            tree = {key: value for key, value in tree.items() if value is not None}
            tree["machine"], extra = coupled_machine(rng, declarations, soil, end, tree)
            used += extra
        soil.more(tree, beside)
        used += soil.used
    tree["gravity"] = Quantity(gravity, "m/s^2", "direction")
    tree["time"] = {"end": Quantity((end,), "s")}
    if kind == "machine" and rng.random() < 0.5:
        tree["time"]["machine"] = {"integrator": rng.choice(INTEGRATORS)}
    if kind == "machine" and "analysis" not in tree and beside.random() < 0.05:
        tree["machine"], more = towed_machine(beside, declarations, end)
        used[:] = [*more, "machine.start.towing equilibrium"]
    if kind == "coupled" and beside.random() < 0.3:
        tree["time"]["machine"] = {"soil steps per machine step": beside.randint(2, 5)}
        used.append("several soil steps per machine step")
    tree["output"] = {"every": Quantity((end / 4,), "s"), "series every": Quantity((end / 20,), "s"), "precision": "double"}
    if kind != "machine":  # alone it is written with all digits
        tree["output"]["series digits"] = "all"
    return Scenario(seed, kind, tree, used)


def coupled_machine(rng, declarations, soil, end, tree):
    """A tool with one of the declared shapes that comes down into the spheres at a slant: on a slide, a pin or springs, or driven along x."""
    maker = MachineDraw(rng, declarations, end)
    shape = soil.shape(0.05)
    while "plane" in shape:
        shape = soil.shape(0.05)
    velocity = (maker.rounded(-1, 1), -maker.rounded(0.4, 1.2))
    at, below = above_the_bed(rng, tree["soil"]["bed"]["particles"], shape, velocity, end)
    if "fixed" not in below and rng.random() < 0.3:  # a stone in the tool's way
        below["fixed"] = Name("stone")
        below.pop("velocity", None)
        below.pop("angular velocity", None)
    maker.bodies["tool"] = at
    machine = {"bodies": {Name("tool"): {
        "mass": Quantity((maker.rounded(0.2, 3),), "kg"), "inertia": Quantity((maker.rounded(0.001, 0.02),), "kg m^2"), "at": Quantity(at, "m", "point"),
        "velocity": Quantity(velocity, "m/s", "direction"), "velocity is": "about"}}, "joints": {}, "forces": {}, "drivers": {}}
    way = rng.random()
    if way < 0.5:
        machine["joints"][Name("guide")] = {"translational": [Name("ground"), Name("tool")], "at": Quantity(at, "m", "point"),
                                           "along": Quantity(velocity, "", "direction")}
        if way < 0.15:
            machine["drivers"][Name("travel")] = {"coordinate": Name("tool", ".x"), "velocity": constant(velocity[0], "m/s", "x")}
        elif way < 0.25:  # strong enough to turn the tool round
            far = tuple(float(f"{a - 0.3 * v:.5g}") for a, v in zip(at, velocity))
            machine["forces"][Name("rebound")] = {"spring-damper": [Name("ground"), Name("tool")], "ends": [
                Quantity(far, "m", "point"), Quantity(at, "m", "point")], "stiffness": Quantity((maker.rounded(1e3, 2e4),), "N/m")}
    elif way < 0.7:
        machine["joints"][Name("guide")] = {"revolute": [Name("ground"), Name("tool")], "at": Quantity((at[0] - 0.1, at[1] + 0.02), "m", "point")}
    for k in range(rng.choice([0, 1, 2])):
        maker.add(machine, "forces", f"f{k}", rng.choice(sorted(declarations.elements("machine.forces"))), ("ground", "tool"))
    maker.measures(machine)
    machine["measures"][Name("soil on tool")] = {"soil force": Name("tool")}
    machine["surfaces"] = {Name("blade"): {"body": Name("tool"), "material": Name("steel"), **shape}}
    return {key: value for key, value in machine.items() if value}, maker.used


def towed_machine(rng, declarations, end):
    """A trolley on a level rail with an arm that hangs from it on a spring, and what pulls at the arm: it begins where all of it is at rest in the tow."""
    maker = MachineDraw(rng, declarations, end)
    maker.bodies.update(trolley=(0.0, 1.0), arm=(maker.rounded(-0.3, 0.3), 0.6))
    maker.angles.update(trolley=0.0, arm=0.0)
    machine = {"bodies": {}, "joints": {}, "forces": {}, "drivers": {}}
    for name, at in maker.bodies.items():
        mass = maker.rounded(0.5, 4)
        machine["bodies"][Name(name)] = {"mass": Quantity((mass,), "kg"), "inertia": Quantity((float(f"{0.04 * mass:.4g}"),), "kg m^2"),
                                         "at": Quantity(at, "m", "point"), "pose is": "about"}
    speed = maker.rounded(-1, 1)
    machine["joints"][Name("rail")] = {"translational": [Name("ground"), Name("trolley")], "at": Quantity((0.0, 1.0), "m", "point"), "along": Quantity((1.0, 0.0), "", "direction")}
    machine["joints"][Name("pin")] = {"revolute": [Name("trolley"), Name("arm")], "at": Quantity((0.0, 1.0), "m", "point")}
    machine["drivers"][Name("tow")] = {"coordinate": Name("trolley", ".x"), "velocity": constant(speed, "m/s", "x")}
    machine["forces"][Name("torsion")] = {"rotational spring-damper": [Name("trolley"), Name("arm")], "stiffness": Quantity((maker.rounded(10, 50),), "N m/rad"),
                                          "damping": Quantity((maker.rounded(0.1, 1),), "N m s/rad")}
    for k in range(rng.choice([0, 1, 1, 2])):
        maker.add(machine, "forces", f"f{k}", rng.choice(sorted(declarations.elements("machine.forces"))), rng.choice([("trolley", "arm"), ("ground", "arm")]))
    machine["start"] = {"towing equilibrium": Quantity((speed,), "m/s", "axes turn")}
    maker.measures(machine)
    return machine, maker.used


def above_the_bed(rng, spheres, shape, velocity, end):
    """Where a tool of this velocity stands that meets one of the upper spheres before the end; and that sphere."""
    def top(sphere):
        return sphere["position"].values[1] + sphere["radius"].values[0]

    highest = max(top(one) for one in spheres)
    below = rng.choice([one for one in spheres if top(one) > highest - 0.5 * one["radius"].values[0]])
    gap = rng.uniform(0.05, 0.5) * -velocity[1] * end
    x = below["position"].values[0] + velocity[0] / velocity[1] * gap
    return (float(f"{x:.5g}"), float(f"{highest + depth_below(shape) + gap:.5g}")), below
