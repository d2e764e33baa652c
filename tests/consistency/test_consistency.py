#!/usr/bin/env python3
"""Tests of this tool: every relation holds of an honest miniature program and fails of one with a planted fault."""
import math
import pathlib
import random
import sys
import types
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import numpy  # noqa: E402

import balances  # noqa: E402
import compare  # noqa: E402
import degenerate  # noqa: E402
import similar  # noqa: E402
from declarations import Declarations  # noqa: E402
from geometry import Box, Faces, Function, Name, NotTransformable, Pair, Quantity, View, render  # noqa: E402
from miniature import Miniature  # noqa: E402
from relations import RELATIONS, Case  # noqa: E402
from scenario import Scenario, draw  # noqa: E402
from shrink import places, shrink  # noqa: E402

REFERENCE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "reference" / "keys.md"


def machine():
    body = {"mass": Quantity((2.0,), "kg"), "inertia": Quantity((0.1,), "kg m^2"), "angle": Quantity((0.3,), "rad", "attitude"),
            "velocity": Quantity((0.5, 1.0), "m/s", "direction"), "angular velocity": Quantity((2.0,), "rad/s", "turn")}
    return Scenario(1, "machine", {
        "subsoil": 1, "gravity": Quantity((0.0, -9.81, 0.0), "m/s^2", "direction"),
        "machine": {"bodies": {Name("a"): {**body, "at": Quantity((0.1, 0.2), "m", "point")}, Name("b"): {**body, "at": Quantity((-0.3, 0.25), "m", "point")}}},
        "time": {"end": Quantity((0.5,), "s")},
        "output": {"every": Quantity((0.25,), "s"), "series every": Quantity((0.05,), "s")}}, [])


def soil():
    return Scenario(1, "soil", {
        "subsoil": 1, "gravity": Quantity((0.0, -9.81, 0.0), "m/s^2", "direction"), "materials": {Name("grain"): {"density": Quantity((2000.0,), "kg/m^3")}},
        "soil": {"container": {"@box": Box((0.2, 0.2, 0.1), (-0.1, 0.0, -0.05)), "open": Faces(("+y", "-x"))},
                 "bed": {"fill": "particles", "particles": [
                     {"position": Quantity((0.01 * k, 0.1, 0.0), "m", "point"), "velocity": Quantity((0.1, 0.0, 0.05 * k), "m/s", "direction"),
                      "angular velocity": Quantity((0.0, 5.0, 0.0), "rad/s", "axial"), "radius": Quantity((0.005,), "m")} for k in range(3)]}},
        "time": {"end": Quantity((0.1,), "s")},
        "output": {"every": Quantity((0.05,), "s"), "series every": Quantity((0.01,), "s")}}, [])


def driven():
    scenario = machine()
    scenario.tree["machine"]["drivers"] = {Name("d"): {"coordinate": Name("a", ".x")}}
    return scenario


def balanced():
    scenario = machine()
    scenario.tree["analysis"] = "equilibrium"
    for body in scenario.tree["machine"]["bodies"].values():
        body["angular velocity"] = Quantity((0.0,), "rad/s", "turn")
    return scenario


def stones():
    """A fixed sphere and one that overlaps it."""
    scenario = soil()
    first, second = scenario.tree["soil"]["bed"]["particles"][:2]
    del first["velocity"], first["angular velocity"]
    first["fixed"] = Name("stone")
    second["velocity"] = Quantity((0.0, 1.0, 0.0), "m/s", "direction")
    first["position"] = Quantity((0.01, 0.148, 0.0), "m", "point")
    scenario.tree["soil"]["bed"]["particles"] = [first, second]
    return scenario


def coupled():
    return Scenario(1, "coupled", {**machine().tree, "soil": soil().tree["soil"], "materials": soil().tree["materials"]}, [])


# Relation -> (scenario, planted fault). A relation without an entry fails the test below.
PLANTED = {
    "translation": (machine, "far is rough"), "rotation": (machine, "gravity along y"), "start in another frame": (machine, "far is rough there"), "quarter turn": (soil, "gravity along y"),
    "mirror in x": (machine, "handed"), "mirror in z": (soil, "across"), "renaming": (machine, "names matter"), "reordering": (machine, "order matters"),
    "other units": (machine, "units misread"), "include": (machine, "include matters"), "set against file": (machine, "set ignored"),
    "own scenario": (machine, "defaults matter"), "threads": (soil, "threads matter"), "observation": (machine, "rows matter"),
    "continuation": (machine, "state lost"), "integrators": (machine, "method matters"), "half step": (soil, "step matters"), "sentences": (machine, "not a number"),
    "check against run": (machine, "check refuses"), "check predicts": (soil, "check predicts"), "extremes": (machine, "maximum"), "newton and euler": (machine, "handed"),
    "energy of machine": (machine, "energy"), "momentum of soil": (soil, "momentum"),
    "torque of soil": (soil, "torque"), "mass and energy of soil": (soil, "mass"), "work at the interface": (coupled, "interface"),
    "impulse of machine": (coupled, "impulse"), "watches": (machine, "integral"), "work of driver": (driven, "driver"), "losses": (machine, "losses"),
    "python module": (machine, "python"),
    "equilibrium is at rest": (balanced, "equilibrium"), "counts": (machine, "counts"), "report": (machine, "report"), "resume": (machine, "resume"),
    "similar scale": (machine, "handed"), "fixed spheres": (stones, "fixed moves"), "overlaps are felt": (stones, "contacts"),
}


def violations(name, make, *faults):
    program = Miniature(*faults)
    case = Case(program, make())

    def opened(_):  # as python/subsoil, of which this is no test
        series = {n: numpy.array(v) * (1.01 if "python" in faults else 1.0) for n, v in case.base.table().items()}
        return types.SimpleNamespace(series={n: types.SimpleNamespace(to_numpy=lambda v=v: v) for n, v in series.items()}, frames=[])

    sys.modules["subsoil"] = types.SimpleNamespace(open=opened)
    try:
        return RELATIONS[name][1](case)
    finally:
        del sys.modules["subsoil"]
        program.close()


class Relations(unittest.TestCase):
    def test_each_has_a_planted_fault(self):
        self.assertEqual(set(RELATIONS), set(PLANTED))

    def test_each_holds_of_an_honest_program(self):
        for name, (make, _) in PLANTED.items():
            with self.subTest(name):
                self.assertEqual(violations(name, make), [])

    def test_each_finds_its_planted_fault(self):
        for name, (make, fault) in PLANTED.items():
            with self.subTest(name):
                self.assertNotEqual(violations(name, make, fault), [])

    def test_a_crash_and_a_silent_refusal_are_found(self):
        for fault in "crash", "silent refusal":
            self.assertNotEqual(violations("sentences", machine, fault), [])


class Surfaces(unittest.TestCase):
    def test_depths(self):
        points = numpy.array([(0.0, 0.4, 0.0), (0.0, 1.0, 0.0), (2.0, 0.9, 0.0), (0.0, 0.0, 1.1)])
        box = {"box": Quantity((2.0, 1.0, 2.0), "m")}
        numpy.testing.assert_allclose(balances.depth_in(box, points), [0.1, -0.5, -math.hypot(1.0, 0.4), -0.1], atol=1e-15)
        roll = {"cylinder": {"radius": Quantity((0.5,), "m"), "length": Quantity((2.0,), "m"), "axis": Quantity((0.0, 0.0, 1.0), "", "own")}}
        numpy.testing.assert_allclose(balances.depth_in(roll, points), [0.1, -0.5, 0.5 - math.hypot(2.0, 0.9), -0.1], atol=1e-15)

    def test_a_tool_is_where_its_body_is(self):
        """Turned by a quarter and moved by 1 m along x: its long side stands upright."""
        tree = {"soil": soil().tree["soil"], "machine": {"surfaces": {Name("blade"): {"body": Name("a"), "box": Quantity((2.0, 1.0, 1.0), "m")}}}}
        table = {"time": numpy.array([0.0, 1.0]), "a.x": numpy.array([0.0, 1.0]), "a.y": numpy.zeros(2), "a.angle": numpy.array([0.0, 0.5 * math.pi])}
        case = types.SimpleNamespace(tree=tree, base=types.SimpleNamespace(table=lambda: table))
        depth, moves = list(balances.surfaces(case, 1.0))[-1]
        self.assertTrue(moves)
        numpy.testing.assert_allclose(depth(numpy.array([(1.0, 0.9, 0.0), (1.9, 0.0, 0.0)])), [0.1, -0.4], atol=1e-12)

    def test_a_draft_of_the_other_sign_is_a_difference(self):
        table = {"soil.draft": numpy.array([0.0, 2.0]), "other": numpy.array([0.0, 2.0])}
        apart = compare.differences(table, {name: -v for name, v in table.items()}, {}, View(mirror_x=True))
        self.assertEqual(apart, {"soil.draft": 2.0, "other": 0.0})


class Transformations(unittest.TestCase):
    def test_a_table_comes_back_from_every_view(self):
        table = {"a.x": numpy.array([1.0, 2.0]), "a.y": numpy.array([0.5, -1.0]), "a.angle": numpy.array([0.1, 0.2]), "time": numpy.array([0.0, 1.0])}
        view = View(angle=0.7, shift=(3.0, -2.0, 0.0), names={"a": "z"})
        moved = {"time": table["time"], "z.angle": table["a.angle"] + 0.7,
                 "z.x": math.cos(0.7) * table["a.x"] - math.sin(0.7) * table["a.y"] + 3.0,
                 "z.y": math.sin(0.7) * table["a.x"] + math.cos(0.7) * table["a.y"] - 2.0}
        back = compare.back(moved, view)
        self.assertLess(max(compare.differences(table, back, {}, view).values()), 1e-12)

    def test_walls_change_places_and_moments_their_point(self):
        one = numpy.array([1.0])
        table = {"wall -x.Fx": 2 * one, "wall -x.Fy": 0 * one, "wall -x.Fz": 0 * one, "wall -x.Mx": 0 * one, "wall -x.My": 0 * one, "wall -x.Mz": 3 * one}
        mirrored = {"wall +x.Fx": -2 * one, "wall +x.Fy": 0 * one, "wall +x.Fz": 0 * one, "wall +x.Mx": 0 * one, "wall +x.My": 0 * one, "wall +x.Mz": -3 * one}
        self.assertEqual(compare.back(mirrored, View(mirror_x=True)), table)
        moved = {**table, "wall -x.Mz": table["wall -x.Mz"] - 5.0 * 2}  # r x F of a shift by 5 m along y
        self.assertEqual(compare.back(moved, View(shift=(0.0, 5.0, 0.0))), table)

    def test_kinds(self):
        view = View(mirror_x=True)
        self.assertEqual(render(Quantity((1.0, 2.0), "m", "point"), view), "-1 2 m")
        self.assertEqual(render(Quantity((1.0,), "rad/s", "turn"), view), "-1 rad/s")
        self.assertEqual(render(Quantity((1.0, 2.0, 3.0), "rad/s", "axial"), View(mirror_z=True)), "-1 -2 3 rad/s")
        self.assertEqual(render(Faces(("+x", "-y", "z")), View(angle=math.pi / 2)), ["+y", "+x", "z"])
        self.assertEqual(render({"@": Box((1.0, 2.0, 3.0), (0.0, 0.0, 0.0))}, view), {"size": "1 2 3 m", "at": "-1 0 0 m"})
        with self.assertRaises(NotTransformable):
            render(Quantity((1.0,), "m", "height"), View(angle=0.1))

    def test_a_pair_of_components_rotates(self):
        f = Function("constant", (("value", Quantity((2.0,), "N")),), (("value", 1, 0),), "N")
        g = Function("constant", (("value", Quantity((0.0,), "N")),), (("value", 1, 0),), "N")
        turned = render({"@": Pair(("along x", f), ("along y", g))}, View(angle=math.pi / 3))
        self.assertAlmostEqual(float(turned["along y"][0]["constant"]["value"].split()[0]), 2 * math.sin(math.pi / 3))

    def test_units_keep_the_number(self):
        for seed in range(20):
            text = render(Quantity((0.1234,), "m"), View(units=random.Random(seed)))
            value, unit = text.split()
            self.assertAlmostEqual(float(value) * {"mm": 1e-3, "cm": 1e-2, "m": 1}[unit], 0.1234, places=15)


class Similarity(unittest.TestCase):
    def test_units(self):
        length, mass, time = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0))
        for unit, n, wanted in (("N/m^(n)", 1.5, (-0.5, 1, -2)), ("N/m^(n+1)", 1.0, (-1, 1, -2)), ("m^3/(s Pa)", None, (4, -1, 1)), ("(N)/(m/s)^3", None, (-2, 1, 1)),
                                ("N m s/rad", None, (2, 1, -1)), ("1/s", None, (0, 0, -1)), ("kg/m^3", None, (-3, 1, 0)), ("((1))/s^2", None, (0, 0, -2))):
            self.assertEqual(similar.dimension(unit, n)[:3], wanted, unit)  # of length, mass, time
        self.assertEqual([similar.factor("V", one) for one in (length, mass, time)], [4.0, 2.0, 0.125])
        self.assertEqual(similar.factor("ohm", (0, 0, 0, 1)), 0.25)
        for unit in "furlong", "N/m^(n)", "m?":
            with self.assertRaises(similar.NoScale):
                similar.dimension(unit)

    def test_a_document(self):
        kept = {"axis": "0 0 1", "mu": "0.3", "n": "2", "name": "b0"}
        document = {"at": "0.1 -2e-3 m", "rate": "200 1/s", "stiffness": "10 N/m^(n)", "points": [["1 s", "3 rad/s"]], **kept}
        self.assertEqual(similar.scaled(document, (2, 3, 1, 0)), {
            "at": "0.4 -0.008 m", "rate": "100.0 1/s", "stiffness": "5.0 N/m^(n)", "points": [["2.0 s", "1.5 rad/s"]], **kept})
        with self.assertRaises(similar.NoScale):
            similar.scaled({"force": {"expression": "2*t", "unit": "N"}}, (1, 0, 0, 0))

    def test_plain_numbers_of_controllers(self):
        """1 N per m of a lag of 1 s: halves of both, in a world of lengths twice and times four times as large."""
        lag = {"transfer function": "gap", "measured in": "m", "output in": "N", "numerator": ["1"], "denominator": ["1", "1"]}
        self.assertEqual(similar.scaled(lag, (1, 0, 2, 0)), {**lag, "numerator": ["0.0625"], "denominator": ["4.0", "1.0"]})

    def test_numbers_keep_their_bits_on_the_way_back(self):
        for seed in range(50):
            scale = similar.drawn_scale(seed)
            text = similar.scaled("0.1234567890123456 m", scale)
            self.assertEqual(float(text.split()[0]) / similar.factor("m", scale), 0.1234567890123456)

    def test_texts_are_written_without_quotes(self):
        self.assertEqual(similar.text_of({"n": "1.5", "closed": "no", "on": "b0"}), "{n: 1.5, closed: no, on: b0}\n")


class Comparison(unittest.TestCase):
    def test_one_bit_and_a_missing_number(self):
        a = {"x": numpy.array([1.0, 2.0])}
        self.assertEqual(compare.bits(a, {"x": a["x"].copy()}), [])
        self.assertEqual(len(compare.bits(a, {"x": numpy.array([1.0, numpy.nextafter(2.0, 3.0)])})), 1)
        self.assertEqual(compare.differences({"x": numpy.array([1.0, numpy.nan])}, {"x": numpy.array([1.0, 2.0])}, {})["x"], float("inf"))
        self.assertEqual(len(compare.bits(a, {"x": numpy.array([1.0])})), 1)


class Generator(unittest.TestCase):
    def setUp(self):
        self.declared = Declarations(REFERENCE.read_text())

    def test_draws_every_declared_element(self):
        drawn = set()
        for seed in range(1500):
            drawn |= set(draw(seed, self.declared).used)
        self.assertEqual([one for one in drawn if one.startswith("unknown unit")], [])
        wanted = {f"machine.{part}.{name}" for part in ("joints", "forces", "drivers") for name in self.declared.elements(f"machine.{part}")}
        wanted |= {f"contacts.{name}" for name, key in self.declared.children("contacts").items() if key.type == "type"}
        wanted |= {f"boundaries.shape.{name}" for name, key in self.declared.children("boundaries.shape").items() if key.type != "file"}
        wanted |= {f"analysis.{word}" for word in self.declared.sections["Top level"]["analysis"].words}
        wanted |= {f"beside the bed: {name}" for name in ("sleeping", "layers", "inlet", "straw", "moving")}
        wanted |= {"several soil steps per machine step", "machine.start.towing equilibrium"}
        self.assertEqual(wanted - drawn, set())

    def test_a_new_joint_is_drawn(self):
        text = REFERENCE.read_text().replace("| `machine.joints.revolute` |",
                                             "| `machine.joints.hinge of tests` | [name of a body, name of a body] | required |  | new |\n"
                                             "| `machine.joints.hinge of tests.at` | 2 numbers m | required |  | in the world of the start pose |\n"
                                             "| `machine.joints.revolute` |", 1)
        declared = Declarations(text)
        self.assertTrue(any("machine.joints.hinge of tests" in draw(seed, declared).used for seed in range(300)))

    def test_the_same_seed_gives_the_same_scenario(self):
        for seed in range(20):
            self.assertEqual(render(draw(seed, self.declared).tree), render(draw(seed, self.declared).tree))


class Reduction(unittest.TestCase):
    def test_keeps_what_the_violation_needs(self):
        tree = soil().tree
        small = shrink(tree, lambda t: any(p["position"].values[0] > 0.015 for p in t["soil"]["bed"]["particles"]))
        self.assertEqual(len(small["soil"]["bed"]["particles"]), 1)
        self.assertLess(len(list(places(small))), len(list(places(tree))))

    def test_degenerate_inputs_differ_from_the_valid_one(self):
        tree = machine().tree
        for seed in range(50):
            broken, faults = degenerate.mutated(tree, seed)
            self.assertTrue(faults)


if __name__ == "__main__":
    unittest.main()
