"""Similarity: with lengths, masses, times and currents of a scenario times powers of two, outputs are the same times powers of two."""
import random
import re

import yaml

from case import Case, relation
from program import Dumper, Result

# Exponents of length, mass, time and current.
BASE = {"m": (1, 0, 0, 0), "kg": (0, 1, 0, 0), "s": (0, 0, 1, 0), "A": (0, 0, 0, 1), "N": (1, 1, -2, 0), "Pa": (-1, 1, -2, 0), "J": (2, 1, -2, 0),
        "W": (2, 1, -3, 0), "Hz": (0, 0, -1, 0), "V": (2, 1, -3, -1), "ohm": (2, 1, -3, -2), "H": (2, 1, -2, -2), "rad": (0, 0, 0, 0), "1": (0, 0, 0, 0)}
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
NUMBERS = re.compile(rf"^({NUMBER}(?:\s+{NUMBER})*)(?:\s+(1/.*|[A-Za-z(].*))?$")
FORMULAS = {"formula", "expression"}  # whose numbers have units that nothing tells

# Defaults without effect, which scenario.yaml states and another value of which the program refuses.
IDLE = [({"restitution from"}, lambda node: "restitution" not in node), ({"slip speed"}, lambda node: "stick stiffness" in node)]


class NoScale(Exception):
    """The scenario has numbers whose dimension is not known."""


def dimension(unit, n=None):
    """Exponents of a unit such as `N/m^(n+1)`, `m^3/(s Pa)`, `(N)/(m/s)^3`."""
    tokens = re.findall(r"\^\(n(?:\+\d+)?\)|\^[-+]?[\d.]+|[A-Za-z]+|1|[/()]", unit)
    answer, rest = product(tokens, n)
    if rest or re.sub(r"\s", "", unit) != "".join(tokens):
        raise NoScale(f"unit `{unit}`")
    return answer


def product(tokens, n):
    total, sign = (0.0,) * 4, 1
    while tokens and tokens[0] != ")":
        head, tokens = tokens[0], tokens[1:]
        if head == "/":
            sign = -1
            continue
        if head == "(":
            one, tokens = product(tokens, n)
            tokens = tokens[1:]
        elif head in BASE:
            one = BASE[head]
        else:
            raise NoScale(f"unit `{head}`")
        power = 1.0
        if tokens and tokens[0].startswith("^"):
            power, tokens = exponent(tokens[0][1:], n), tokens[1:]
        total = tuple(a + sign * power * b for a, b in zip(total, one))
        sign = 1
    return total, tokens


def exponent(text, n):
    if "n" not in text:
        return float(text)
    if n is None:
        raise NoScale("an exponent n that is not given")
    return n + float(text.strip("(n)") or 0)


def factor(unit, scale, n=None):
    """By which a number of this unit grows; scale: powers of two of length, mass, time, current."""
    return 2.0 ** sum(a * b for a, b in zip(dimension(unit, n), scale))


def scaled(node, scale, n=None):
    """The document (all scalars texts) with every number that has a unit in the other size."""
    if isinstance(node, dict):
        if FORMULAS & set(node):
            raise NoScale("a formula")
        node = {key: value for key, value in node.items() if not any(key in keys and there(node) for keys, there in IDLE)}
        n = float(node["n"]) if isinstance(node.get("n"), str) else n
        answer = {key: scaled(value, scale, n) for key, value in node.items()}
        return {**answer, **controller(node, scale)}
    if isinstance(node, list):
        return [scaled(one, scale, n) for one in node]
    found = NUMBERS.match(node) if isinstance(node, str) else None
    if not found or not found[2]:
        return node
    by = factor(found[2], scale, n)
    return " ".join(repr(float(x) * by) for x in found[1].split()) + " " + found[2]


def controller(node, scale):
    """Plain numbers of a controller, in the units that it names."""
    if "transfer function" in node:
        gain = factor(node["output in"], scale) / factor(node["measured in"], scale)
        return {key: [repr(float(x) * by * 2.0 ** (scale[2] * (len(node[key]) - 1 - k))) for k, x in enumerate(node[key])]
                for key, by in (("numerator", gain), ("denominator", 1.0))}
    if "table of two" in node:
        return {key: [repr(float(x) * factor(node[unit], scale)) for x in node[key]]
                for key, unit in (("first", "first in"), ("second", "second in"), ("values", "output in"))}
    return {}


class Scaled(Result):
    """A run of the other size, its outputs in the size of the first."""

    def __init__(self, run, scale):
        super().__init__(run.folder, run.code, run.stdout, run.stderr, run.scenario)
        self.scale = scale

    def table(self):
        if self._rows is None:
            rows = super().table()
            self._rows = {name: values / factor(self.units[name], self.scale) for name, values in rows.items()}
        return self._rows

    def spheres(self):
        return {name: values / factor("m/s" if "velocity" in name else "m", self.scale) for name, values in super().spheres().items()}

    def summary(self):
        answer = super().summary()
        for mode in answer.get("modes", []):
            for word in ("frequency [Hz]", "real part [1/s]"):
                mode[word] /= factor("1/s", self.scale)
        return answer


class Plain(Dumper):
    """Writes texts without quotes: numbers among them stay numbers."""


Plain.yaml_implicit_resolvers = {}


def text_of(document):
    return yaml.dump(document, Dumper=Plain, sort_keys=False, width=10**6, allow_unicode=True, default_flow_style=None)


def drawn_scale(seed):
    """Powers of two. A third of them keep density and gravity. Those of length are even: the root of a radius is exact."""
    rng = random.Random(f"similar {seed}")
    most = rng.choice([0, 3, 3])
    if not most:
        c = rng.choice([-5, -3, -1, 1, 3])
        return (2 * c, 6 * c, c, rng.randint(-3, 3))
    a, b, c, d = (rng.randint(-most, most) for _ in range(4))
    return (2 * (a // 2), b, c, d)


def document_of(run):
    """scenario.yaml of a run, its scalars as texts, with the defaults of settling, which it leaves out."""
    document = yaml.load((run.folder / "scenario.yaml").read_text(), yaml.BaseLoader)
    bed = document.get("soil", {}).get("bed")
    if bed and bed["fill"] == "random":
        bed["settle"] = {"at most": "5 s", "ramp": "0.1 s", **bed.get("settle", {})}
    return document


def with_steps(case, document):
    """The run with the steps given that it takes without: that of adams-moulton alone, and that of soil, whose speed of approach is 0.1 m/s at least."""
    if "soil" in case.tree:
        document["time"]["soil step"] = f"{case.base.summary()['run']['soil step [s]']!r} s"
    elif case.scenario.integrator == "adams-moulton":
        document["time"]["machine"]["step"] = "0.001 s"
    else:
        return case
    again = Case(case.program, case.scenario)
    again._base = case.program.run(text_of(document))
    return again


@relation("machine", "soil", "coupled")
def similar_scale(case):
    """With all lengths, masses, times and currents times powers of two the motion is the same times powers of two: no constant of the program has a unit."""
    if not case.base.ended:
        return []
    scale, document = drawn_scale(case.scenario.seed), document_of(case.base)
    try:
        scaled(document, scale)
    except NoScale:
        return []
    case = with_steps(case, document)
    if not case.base.ended:
        return [f"with the step given that it takes without: exit code {case.base.code}"]
    other = Scaled(case.program.run(text_of(scaled(document, scale))), scale)
    return case.same(other, floor=1e-9 if "soil" in case.tree else case.floor)
