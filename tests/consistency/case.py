"""One scenario with its runs, and the register of relations."""
import random

import numpy

import compare
from geometry import Quantity

RELATIONS = {}  # name -> (kinds of scenarios, function)


def relation(*kinds):
    def enter(function):
        RELATIONS[function.__name__.replace("_", " ")] = (kinds, function)
        return function
    return enter


class Case:
    """One scenario with its run, and further runs of its variants."""

    def __init__(self, program, scenario):
        self.program, self.scenario, self.tree = program, scenario, scenario.tree
        self.rng = random.Random(scenario.seed + 7)
        self._base = self._response = None

    @property
    def base(self):
        if self._base is None:
            self._base = self.program.run(self.tree)
        return self._base

    @property
    def listed(self):
        """Spheres given one by one: transformations move them all. Those of an inlet are drawn along the axes of the world."""
        return "soil" not in self.tree or self.tree["soil"]["bed"]["fill"] == "particles" and "inlets" not in self.tree["soil"]

    @property
    def guessed(self):
        """Bodies whose pose or velocity is only `about` right: the assembly chooses the start."""
        return any("about" in body.values() for body in self.tree.get("machine", {}).get("bodies", {}).values())

    @property
    def floor(self):
        """Share of a column's size by which runs may differ whose arithmetic differs: error of the integrator."""
        if "soil" in self.tree:
            return 1e-6
        if "beams" in self.tree["machine"]:
            return 1e-4
        return {"adams-moulton": 1e-3, "ida": 1e-4}.get(self.scenario.integrator, 1e-6)

    @property
    def says_unstable(self):
        """A load presses a contact deeper than the step is stable for, and the run warns of wrong forces."""
        return "is below the step of" in self.base.text

    def response(self):
        """Change of every column, as a share of its size, when all masses and stiffnesses change by 1e-9."""
        if self._response is None:
            other = self.program.run(nudged(self.tree, random.Random(1), 1e-9))
            self._response = None
            if other.ended and len(other.table()["time"]) == len(self.base.table()["time"]):
                pair = [{**run.table(), **(run.spheres() if "soil" in self.tree else {})} for run in (self.base, other)]
                self._response = compare.differences(*pair, self.base.units)
            self._response = self._response or {}
        return self._response

    def apart(self, one, view, other, beside):
        """Change of every column, as a share of its size, between runs in two views."""
        if not other.ended or len(one.table()["time"]) != len(other.table()["time"]):
            return {}
        pair = [{**compare.back(run.table(), v), **(spheres_back(run.spheres(), v) if "soil" in self.tree else {})} for run, v in ((one, view), (other, beside))]
        return compare.differences(*pair, self.base.units)

    def same(self, other, view=None, floor=None, skip=(), response=None):
        """Sentences about columns of `other`, a run of the same motion, that differ from the base run."""
        if {self.base.code, other.code} == {0, 3} and balances_on_a_tip(self.base if self.base.ended else other):
            return []  # the search comes upon it or not: what it stops with says so, and what it finds is called unstable
        if other.code != self.base.code:
            return [f"exit code {other.code} against {self.base.code}: {last_line(other.text)}"]
        if not self.base.ended:
            return []
        mine, theirs = self.base.table(), other.table()
        if view is not None:
            theirs = compare.back(theirs, view)
        missing = set(mine) ^ set(theirs)
        if missing:
            return [f"columns of one run only: {sorted(missing)[:3]}"]
        if len(mine["time"]) != len(theirs["time"]):
            return [f"{len(theirs['time'])} rows against {len(mine['time'])}"]
        floor = floor or self.floor
        if self.scenario.analysis == "modes":
            mine, theirs = {**mine, **modes_of(self.base)}, {**theirs, **modes_of(other)}
        if "soil" in self.tree and self.listed:
            mine, theirs = {**mine, **self.base.spheres()}, {**theirs, **spheres_back(other.spheres(), view)}
        apart = compare.differences(mine, theirs, self.base.units, view)
        nowhere = self.stressless(mine)
        wide = {name: share for name, share in apart.items() if share > floor and name not in skip and name not in nowhere}
        if not wide:
            return []
        moved = view is not None and (view.angle or view.mirror_x or any(view.shift))
        if moved and self.guessed and self.start_differs(mine, theirs, view):
            return []  # another start: relation `start in another frame` reports it
        most = 1e-3  # rounding of places far away that makes more is a fault
        response = {name: max(self.response().get(name, 0.0), min(share, most)) for name, share in response.items()} if response else self.response()
        wide = {name: share for name, share in wide.items() if share > 10 * response.get(name, 0.0)}
        return [f"{name} differs by {share:.3g} of its size" for name, share in sorted(wide.items(), key=lambda p: -p[1])[:4]]


    def stressless(self, table):
        """Places of a maximum stress that is rounding: below 1e-9 of Young's modulus there is none."""
        beams = self.tree.get("machine", {}).get("beams", {})
        return [f"{key.text}.stress at" for key, beam in beams.items()
                if "young's modulus" in beam and compare.size_of(table.get(f"{key.text}.stress", numpy.zeros(1))) < 1e-9 * beam["young's modulus"].values[0]]

    def start_differs(self, mine, theirs, view):
        """Bodies whose first row differs: the assembly of a pose or velocity that is only `about` right chose another one."""
        places = [n for n in mine if n.endswith((".x", ".y", ".vx", ".vy", ".spin")) and f"{n.rsplit('.', 1)[0]}.angle" in mine]
        first = [{n: t[n][:1] for n in places} for t in (mine, theirs)]
        apart = compare.differences(*first, self.base.units, view)
        return [f"{n} starts {share:.3g} of its size off" for n, share in apart.items() if share > max(1e-7, self.floor)]


def balances_on_a_tip(run):
    """Whether the equilibrium that a run found is unstable: no fall ends there, and Newton's method from afar may pass by."""
    summary = run.summary()
    return bool(summary.get("equilibrium", {}).get("unstable eigenvalues")) or any(m["real part [1/s]"] > 0 for m in summary.get("modes", []))


def modes_of(run):
    """Frequencies and rates of the modes as columns, one entry per mode."""
    modes = run.summary().get("modes", [])
    return {f"modes {word}": numpy.array([m[word] for m in modes], dtype=float) for word in ("frequency [Hz]", "real part [1/s]")}


def spheres_back(columns, view):
    """Places and velocities of spheres, as columns of the last frame, in the world of the run without the view."""
    if view is None:
        return columns
    answer = compare.turned_back({name: values - (view.shift["xyz".index(name[-1])] if "place" in name else 0.0)
                                  for name, values in columns.items()}, view)
    return answer


def nudged(node, rng, share):
    if isinstance(node, dict):
        return {key: nudged(value, rng, share) for key, value in node.items()}
    if isinstance(node, list):
        return [nudged(one, rng, share) for one in node]
    if isinstance(node, Quantity) and node.kind == "scalar" and node.unit in ("kg", "N/m", "kg/m^3", "N m/rad", "N/m^(n)", "Pa"):
        return Quantity(tuple(x * (1 + share * rng.uniform(0.5, 1)) for x in node.values), node.unit, node.kind)
    return node


def last_line(text):
    lines = [line for line in text.strip().splitlines() if line.strip() and not line.startswith("the run stops here")]
    return " | ".join(lines[-2:])[-400:] if lines else "(nothing printed)"
