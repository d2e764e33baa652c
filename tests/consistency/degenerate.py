"""Degenerate inputs: a valid scenario with values at and beyond what any reader shall bear."""
import copy
import random

from geometry import Name, Quantity
from shrink import at, places, replaced

EXTREMES = (0.0, -1.0, 1e-30, 1e-12, 1e12, 1e30, float("inf"), float("nan"))


def mutated(tree, seed):
    """The tree with one to three faults in it, and what they are."""
    rng = random.Random(seed)
    faults = []
    for _ in range(rng.choice([1, 1, 2, 3])):
        paths = [p for p in places(tree) if p[0] not in ("subsoil", "output")]
        path = rng.choice(paths)
        value = at(tree, path)
        shown = "/".join(p.text if isinstance(p, Name) else str(p) for p in path)
        if isinstance(value, Quantity):
            way = rng.choice(["extreme", "extreme", "scaled", "equal", "unit", "short"])
            if not value.values:  # shortened to nothing before
                new = value
            elif way == "extreme":
                k = rng.randrange(len(value.values))
                new = Quantity(tuple(rng.choice(EXTREMES) if i == k else x for i, x in enumerate(value.values)), value.unit)
            elif way == "scaled":
                factor = 10.0 ** rng.choice([-9, -6, -3, 3, 6, 9])
                new = Quantity(tuple(factor * x for x in value.values), value.unit)
            elif way == "equal":  # coincident points, parallel directions
                alike = [at(tree, p) for p in paths if isinstance(at(tree, p), Quantity) and at(tree, p).unit == value.unit
                         and len(at(tree, p).values) == len(value.values)]
                new = Quantity(rng.choice(alike).values, value.unit)
            elif way == "unit":
                new = Quantity(value.values, rng.choice(["", "m", "kg", "s", "furlong", "N/m^(n)", "m^-1e9"]))
            else:
                new = Quantity(value.values[:-1], value.unit)
        elif isinstance(value, Name):
            names = sorted({p[-1].text for p in paths if isinstance(p[-1], Name)} | {"ground", "", "nobody"})
            new = Name(rng.choice(names), rng.choice([value.suffix, "", ".x"]))
        elif isinstance(value, list):
            new = rng.choice([[], value * 2, value[:1]])
        elif isinstance(value, dict):
            new = rng.choice([{}, None, [], "text"])
        elif isinstance(value, str):
            new = rng.choice(["", "nonsense", 7, [], {}, "yes"])
        else:
            new = rng.choice([None, -1, 0, 1e30, "text", []])
        tree = replaced(copy.deepcopy(tree), path, new)
        faults.append(f"{shown} = {getattr(new, 'values', new)!r}"[:100])
    return tree, faults
