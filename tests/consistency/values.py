"""Random values of declared keys: magnitudes by unit, relations between keys by their names, functions of time."""
import math

from geometry import Function, Name, Quantity

# Magnitudes of a machine of some 1 kg and 0.5 m, by unit: least and largest, drawn evenly by their logarithm.
MACHINE = {
    "": (0.1, 1.5), "1": (0.1, 1.5), "m": (0.02, 0.3), "rad": (0.05, 1.0), "s": (0.005, 0.1), "kg": (0.3, 5), "kg m^2": (0.005, 0.5),
    "N": (1, 20), "N m": (0.1, 3), "N/m": (20, 5e3), "N s/m": (0.2, 10), "N m/rad": (1, 50), "N m s/rad": (0.02, 0.5), "m/s": (0.05, 1),
    "rad/s": (0.2, 3), "Pa": (1e5, 1e7), "m^2": (1e-4, 1e-2), "m^3": (1e-6, 1e-4), "m^4": (1e-10, 1e-8), "N s^2/m^2": (0.05, 2),
    "N m s^2/rad^2": (0.002, 0.1), "s/m": (0.05, 1), "s/rad": (0.05, 1), "m^3/s": (1e-5, 1e-3), "N m^2": (5, 200), "kg/m^3": (500, 8000),
    "N/m^(n)": (1e3, 1e5), "N m/rad^(n)": (10, 1e3), "N/m^(n+1)": (1e3, 1e5), "N/m^(n+2)": (1e4, 1e6), "N m/A": (0.02, 0.5),
    "ohm": (0.2, 5), "H": (1e-3, 0.05), "A": (0.1, 2), "V": (1, 24), "m/s^2": (0.1, 2), "rad/s^2": (0.2, 4), "m^3/(s Pa)": (1e-13, 1e-11),
}
# Likewise of contacts of spheres of some 10 mm and 10 g.
CONTACT = dict(MACHINE, **{
    "": (0.05, 0.9), "1": (0.05, 0.9), "m": (1e-5, 3e-4), "N/m": (1e3, 2e4), "N s/m": (0.1, 2), "Pa": (1e5, 5e6), "J/m^2": (0.01, 1),
    "J/m^3": (1e3, 1e5), "rad": (0.1, 1), "m^3": (1e-11, 3e-10), "N": (1e-3, 0.1), "s/m": (0.05, 0.5), "N m/rad": (0.01, 0.3),
    "N m s/rad": (1e-4, 1e-3), "N/m^(n)": (1e5, 1e7), "s": (0.001, 0.02),
})
# Dimensions of a key that its name tells better than its unit, in both.
NAMED = {
    "young's modulus": (1e6, 1e7), "poisson ratio": (0.1, 0.4), "density": (1500, 4000), "elements": (2, 5), "rtol": (1e-10, 1e-8),
    "bulk modulus": (1e7, 1e8), "bore": (0.02, 0.05), "stroke": (0.3, 0.5), "supply pressure": (1e5, 1e6), "tank pressure": (1e3, 5e4), "rated flow": (1e-5, 1e-4),
    "regularisation speed": (0.01, 0.1), "slip speed": (0.01, 0.1), "Stribeck speed": (0.01, 0.1), "ratio": (0.5, 2), "friction": (0.1, 0.5),
    "shear area": (1e-5, 1e-4), "height": (0.005, 0.02), "damping ratio": (0.01, 0.3), "axial stiffness": (1e4, 1e5),
    "shear stiffness": (1e4, 1e5), "n": (1.0, 1.5), "restitution": (0.2, 1.0), "restitution from": (0.01, 0.05), "cohesion": (100, 5e3), "K2": (1e5, 2e5), "stop stiffness": (1e4, 1e5),
}


class UnknownUnit(Exception):
    """A declared unit for which this file has no magnitude."""


def magnitude(rng, key, unit, table):
    low, high = NAMED.get(key.name) or table.get(unit) or (None, None)
    if low is None:
        raise UnknownUnit(f"{key.path}: unit `{unit}` has no magnitude in tests/consistency/values.py")
    bounds = key.bounds()
    if bounds:
        least, largest, least_belongs, largest_belongs = bounds
        if largest < high:
            high = largest if largest_belongs else largest * 0.95
        if least > 0 and low < least:
            low = least
        if low > high:
            low = 0.3 * high
    value = math.exp(rng.uniform(math.log(low), math.log(high)))
    value = float(f"{value:.3g}")
    if bounds and bounds[0] < 0 and rng.random() < 0.3 and -value > bounds[0] and key.name not in NAMED:
        value = -value
    return value


def scalar(rng, key, unit, table):
    kind = "turn" if unit in ("rad", "rad/s", "N m", "rad/s^2") else "scalar"
    return Quantity((magnitude(rng, key, unit, table),), unit, kind)


def unit_of(type_text):
    """`m, constant or function of time` -> m."""
    return type_text.split(",")[0].strip()


def function(rng, declarations, unit, size, kind, end, types=None):
    """A random function of the declared types; of every type the value is of the order of `size`."""
    rows = declarations.children("function")
    name = types and rng.choice(types) or rng.choice(sorted(n for n, k in rows.items() if k.type in ("type", "formula")))
    keys, powers = [], []
    u = "" if unit == "1" else unit
    if rows[name].type == "formula":
        formula = rng.choice(["{a}*sin(3*t)", "{a}*t/(1+t^2)", "{a}*(1-exp(-2*t))", "{a}*cos(t)^2", "{a}*tanh(4*t)", "{a}*max(0, sin(2*t))"])
        keys.append((name, formula.format(a=f"({size:.3g})")))
        if u:
            keys.append(("unit", u))
        return Function(name, tuple(keys), (), u, kind)
    for key in declarations.below(f"function.{name}").values():
        own = key.type
        if own.startswith("list of [s, U]"):
            count = 5
            keys.append((key.name, tuple((end * i / (count - 1), float(f"{size * rng.uniform(-1, 1):.3g}")) for i in range(count))))
            continue
        if "U" in own:
            power = own.count("s^") and int(own[-1]) or (1 if own.endswith("/s") else 0)
            value = size * rng.uniform(-1, 1) / max(end, 0.1) ** power
            shown = f"({u or '1'})" + (f"/s^{power}" if power > 1 else "/s" if power else "") if power else u
            keys.append((key.name, Quantity((float(f"{value:.3g}"),), shown)))
            powers.append((key.name, 1, 0))
        elif own == "Hz":
            keys.append((key.name, Quantity((float(f"{rng.uniform(0.5, 2) / end:.3g}"),), "Hz")))
        elif own == "rad":
            keys.append((key.name, Quantity((float(f"{rng.uniform(-1, 1):.3g}"),), "rad")))
        elif own == "s":
            value = end * (0.1 if key.name == "begin" else 0.8)
            keys.append((key.name, Quantity((float(f"{value:.3g}"),), "s")))
        elif own == "word":
            keys.append((key.name, rng.choice(key.words)))
        elif own == "yes/no":
            continue  # `periodic` asks for a first value that is the last one
        else:
            raise UnknownUnit(f"function.{key.path}: type `{own}`")
    return Function(name, tuple(keys), tuple(powers), f"s|{u}", kind)


def constant(value, unit, kind):
    return Function("constant", (("value", Quantity((value,), unit)),), (("value", 1, 0),), f"s|{unit}", kind)


def characteristic(rng, declarations, unit, argument, size, reach, kind):
    """A force that grows with its argument, so that what it holds stays bounded."""
    name = rng.choice(sorted(n for n, k in declarations.children("characteristic").items() if k.type == "type"))
    odd = kind == "turn"
    if name == "table":
        rows = tuple((reach * x, size * y) for x, y in ((-1.0, -1.2), (-0.4, -0.3), (0.0, 0.0), (0.5, 0.4), (1.0, 1.1)))
        return Function(name, (("points", rows),), (), f"{argument}|{unit}", kind, odd)
    keys = (("c1", Quantity((size / reach,), f"({unit})/({argument})^1")), ("c3", Quantity((size / reach**3,), f"({unit})/({argument})^3")))
    return Function(name, keys, (("c1", 1, 1), ("c3", 1, 3)), f"{argument}|{unit}", kind, odd)


def named(text, suffix=""):
    return Name(text, suffix)
