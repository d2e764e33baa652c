#!/usr/bin/python3
"""python/subsoil against closed forms and against the files read by hand: two spheres that fall past a plate on
a given path, and a rod that turns at a given rate. `python_module.py PROGRAM MODULES [unittest's arguments]`; python_test.cpp runs
it. Exit code 77: a package is missing."""
import contextlib
import csv
import importlib.util
import io
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

for package in "h5py", "numpy", "pandas", "yaml":
    if importlib.util.find_spec(package) is None:
        print(f"no {package}: scripts/setup")
        sys.exit(77)
import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python"))
import subsoil

PROGRAM = os.path.abspath(sys.argv.pop(1)) if __name__ == "__main__" else None
if __name__ == "__main__":
    sys.argv.pop(1)  # the folder of the compiled part, which results do not need
LAW = {"law": "linear", "k_n": "10 kN/m", "restitution": 0.5, "mu": np.float64(0.5)}
PAIRS = [("clay", "clay"), ("clay", "steel"), ("steel", "steel")]
FALL = {
    "subsoil": 1,
    "title": "two spheres fall, a plate moves",
    "gravity": "9.81 m/s^2",
    "materials": {"clay": {"density": "1800 kg/m^3"}, "steel": {"density": "7850 kg/m^3"}},
    "contacts": [{"between": pair, **LAW} for pair in PAIRS],
    "soil": {
        "container": {"size": "1 1 1 m", "at": "0 0 0 m", "material": "steel"},
        "bed": {"fill": "particles", "particles": [
            {"position": "0.3 0.8 0.5 m", "radius": "20 mm", "velocity": "0.5 0 0 m/s", "angular velocity": "0 3 0 rad/s", "material": "clay"},
            {"position": "0.6 0.7 0.5 m", "radius": "10 mm", "material": "steel"}]}},
    "boundaries": [{"name": "plate", "material": "steel", "shape": {"box": "60 10 40 mm"}, "at": "0.9 0.5 0.1 m",
                    "moves": [{"velocity": "0 0.2 0 m/s"}]}],
    "time": {"end": "100 ms"},
    "output": {"every": "25 ms", "series every": "10 ms", "precision": "double", "monitor": {"push": {"soil force": "plate", "along": "0 1"}}},
}
ROD = {
    "subsoil": 1,
    "machine": {
        "bodies": {"rod": {"mass": "1 kg", "inertia": "0.1 kg m^2", "at": "0.5 0 m", "outline": ["-0.5 -0.02 m", "0.5 0 m", "-0.5 0.02 m"]}},
        "joints": {"pin": {"revolute": ["ground", "rod"], "at": "0 0 m"}},
        "drivers": {"motor": {"coordinate": "rod.angle", "velocity": "2 rad/s"}},
        "markers": {"tip": {"body": "rod", "at": "1 0 m"}},
        "measures": {"path": {"position": "tip"}}},
    "time": {"end": "1 s"},
    "output": {"every": "0.1 s", "precision": "double"},
}


class Scratch(unittest.TestCase):
    """Works in a folder of its own, where one run lies in `fall`."""
    scenario = FALL

    @classmethod
    def setUpClass(cls):
        cls.before, cls.folder = os.getcwd(), tempfile.TemporaryDirectory()
        os.chdir(cls.folder.name)
        cls.run_ = subsoil.run(cls.scenario, "done", threads=1, program=PROGRAM)

    @classmethod
    def tearDownClass(cls):
        cls.run_.close()
        os.chdir(cls.before)
        cls.folder.cleanup()

    def says(self, *words):
        """An error that has all these words."""
        return self.assertRaisesRegex(subsoil.SubsoilError, "(?s)" + "".join(f"(?=.*{word})" for word in words))


class Results(Scratch):
    def test_spheres_fall_as_spheres_do(self):
        frames = self.run_.frames
        np.testing.assert_allclose(frames.times, [0, 0.025, 0.05, 0.075, 0.1], atol=1e-12)
        for frame in frames:
            t = frame.time
            where = [[0.3 + 0.5 * t, 0.8 - 9.81 * t**2 / 2, 0.5], [0.6, 0.7 - 9.81 * t**2 / 2, 0.5]]
            # A frame between steps lies on the cubic, exact in free flight; sums of steps of 50 us round to 1e-13.
            np.testing.assert_allclose(frame.position, where, atol=1e-10)
            np.testing.assert_allclose(frame.spin, [[0, 3, 0], [0, 0, 0]], atol=1e-12)
            np.testing.assert_array_equal(frame.radius, [0.02, 0.01])
            np.testing.assert_allclose(frame.mass, [4 / 3 * math.pi * 0.02**3 * 1800, 4 / 3 * math.pi * 0.01**3 * 7850])
            self.assertEqual([frames.materials[m] for m in frame.material], ["clay", "steel"])
            self.assertEqual(len(frame), 2)

    def test_arrays_are_those_of_the_files(self):
        for frame in self.run_.frames[1:]:
            found = 0
            for file in pathlib.Path("done/frames").glob("0*.h5"):  # not by the links of run.h5
                with h5py.File(file, "r") as one:
                    if f"frames/{frame.index:06}" not in one:
                        continue
                    for name in "position", "velocity", "spin", "force", "torque", "contacts":
                        stored = one[f"frames/{frame.index:06}/{name}"]
                        self.assertEqual(frame[name].dtype, stored.dtype)
                        np.testing.assert_array_equal(frame[name], stored[()])
                        found += 1
            self.assertEqual(found, 6)
            self.assertIs(frame.position, frame.position)
            self.assertIs(frame.radius, self.run_.frames[0].radius)

    def test_frames_are_a_sequence(self):
        frames = self.run_.frames
        self.assertEqual(len(frames), 5)
        self.assertEqual([f.index for f in frames[::2]], [0, 2, 4])
        self.assertEqual([frames[-1].index, frames[np.int64(1)].index], [4, 1])
        for time, index in (-1, 0), (0.0124, 0), (0.0126, 1), (0.06, 2), (7, 4):
            self.assertEqual(frames.nearest(time).index, index)
        with self.assertRaisesRegex(ValueError, "the time is no number"):
            frames.nearest(float("nan"))
        with self.assertRaises(IndexError):
            frames[5]
        with self.says("no 'bonds'", "position, "):
            frames[0].bonds

    def test_plate_stands_where_its_path_is(self):
        for frame in self.run_.frames:
            p, turn = frame.pose("plate")
            np.testing.assert_allclose(p, [0.9, 0.5 + 0.2 * frame.time, 0.1], atol=1e-9)
            np.testing.assert_allclose(turn, np.eye(3), atol=1e-9)
            size = np.ptp(frame.surface("plate"), axis=0)
            np.testing.assert_allclose(size, [0.06, 0.01, 0.04], atol=1e-9)
        self.assertEqual(self.run_.frames.triangles("plate").shape, (12, 3))
        with self.says("no surface 'plough'", "plate"):
            self.run_.frames[0].surface("plough")

    def test_series_is_the_file(self):
        with open("done/series.csv", newline="", encoding="utf-8") as file:
            head, *rows = csv.reader(file)
        series = self.run_.series
        self.assertEqual([f"{n} [{series.attrs['units'][n]}]" for n in series.columns], head)
        np.testing.assert_array_equal(series.to_numpy(), [[float(x) for x in row] for row in rows])
        np.testing.assert_allclose(series["plate.y"], 0.5 + 0.2 * series["time"], atol=1e-9)
        self.assertEqual(series.attrs["units"]["push"], "N")

    def test_summary_scenario_and_states(self):
        self.assertEqual(self.run_.summary, json.loads(pathlib.Path("done/summary.json").read_text()))
        self.assertTrue(self.run_.complete)
        again = subsoil.run("done/scenario.yaml", "again", threads=1, program=PROGRAM)
        np.testing.assert_array_equal(again.series, self.run_.series)
        self.assertIn("plate", self.run_.scenario)
        self.assertEqual([p.exists() for p in self.run_.states], [True])


class Loads(Scratch):
    """A ball that slides without friction along a strip: its weight is what one contact carries."""
    scenario = {
        "subsoil": 1,
        "materials": FALL["materials"],
        "contacts": [{"between": pair, **LAW, "k_n": "100 kN/m", "mu": 0} for pair in PAIRS],
        "soil": {"bed": {"fill": "particles", "particles": [
            {"position": "100 10 3 mm", "radius": "10 mm", "velocity": "0.5 0 0 m/s", "material": "clay"}]}},
        "boundaries": [{"name": "strip", "material": "steel", "shape": {"box": "0.6 0.02 0.1 m"}, "at": "0.3 -0.01 0 m",
                        "wear": {"coefficient": 1e-4, "hardness": "2 GPa"}}],
        "time": {"end": "0.2 s"},
        "output": {"every": "0.1 s", "contact forces": True, "precision": "double"},
    }
    weight = 1800 * 4 / 3 * math.pi * 1e-6 * 9.81

    def test_contact_forces_are_lines(self):
        held = self.run_.frames[-1].contact_forces
        self.assertEqual(held["ids"].tolist(), [[0, -1]])
        np.testing.assert_allclose(held["force"], [[0, self.weight, 0]], atol=1e-3 * self.weight)
        np.testing.assert_allclose(held["normal force"], [self.weight], rtol=1e-3)
        np.testing.assert_allclose(held["ends"][0], [[0.2, 0.01, 0.003], [0.2, 0, 0.003]], atol=1e-4)

    def test_loads_are_of_triangles(self):
        loads = self.run_.frames[-1].loads("strip")
        self.assertEqual(len(loads["mean pressure"]), len(self.run_.frames.triangles("strip")))
        worn = float((loads["Archard wear depth"] * 0.03).sum())  # each triangle of the top has 0.03 m^2
        self.assertAlmostEqual(worn / (1e-4 / 2e9 * self.weight * 0.5 * 0.2), 1, delta=5e-3)
        self.assertNotIn("loads", self.run_.frames[-1].columns)
        with self.says("no loads of 'plate'", "wear"):
            self.run_.frames[-1].loads("plate")


class Machine(Scratch):
    scenario = ROD

    def test_rod_turns_as_it_is_driven(self):
        self.assertEqual(len(self.run_.frames), 11)
        for frame in self.run_.frames:
            c, s = math.cos(2 * frame.time), math.sin(2 * frame.time)
            p, turn = frame.pose("rod outline")
            np.testing.assert_allclose(p, [0.5 * c, 0.5 * s, 0], atol=1e-7)
            np.testing.assert_allclose(turn, [[c, -s, 0], [s, c, 0], [0, 0, 1]], atol=1e-7)
            np.testing.assert_allclose([frame.values["path.x"], frame.values["path.y"]], [c, s], atol=1e-7)
            self.assertEqual(len(frame), 0)
            np.testing.assert_allclose(frame.surface("machine markers"), [[c, s, 0]], atol=1e-7)
            with self.says("machine markers", "no pose"):
                frame.pose("machine markers")
        self.assertEqual(self.run_.frames.value_units, {"path.x": "m", "path.y": "m"})
        self.assertEqual(self.run_.frames.segments("rod outline").tolist(), [[0, 1], [1, 2], [2, 0]])


class Failures(Scratch):
    def copy(self, name):
        shutil.copytree("done", name)
        return subsoil.open(name)

    def test_bad_input(self):
        with self.says("contacts.0..restitution = 1.5: must be in", "exit code 2", "<dict>:") as caught:
            subsoil.run({**FALL, "contacts": [{"between": p, **LAW, "restitution": 1.5} for p in PAIRS]}, "bad", program=PROGRAM)
        self.assertEqual((caught.exception.exit_code, caught.exception.run), (2, None))
        self.assertFalse(os.path.exists("bad"))
        wrong = pathlib.Path("wrong.yaml")
        wrong.write_text("subsoil: 1\ntime: {end: 1}\n")
        with self.assertRaisesRegex(subsoil.SubsoilError, f"^{wrong.absolute()}:1:1 (?s:.)*\\n{wrong.absolute()}:2:13 "):
            subsoil.run(wrong.absolute(), program=PROGRAM)
        with self.says("done", "not empty", "exit code 2"):
            subsoil.run(FALL, "done", program=PROGRAM)
        self.assertEqual([p for p in os.listdir(".") if p.startswith(".subsoil-")], [])

    def test_stopped_run_opens(self):
        with self.says("m/s", "exit code 3") as caught:
            subsoil.run(FALL, "stopped", sets=["limits.speed=0.7m/s"], threads=1, program=PROGRAM)
        error = caught.exception
        self.assertEqual(error.exit_code, 3)
        self.assertFalse(error.run.complete)
        stop = math.sqrt(0.7**2 - 0.5**2) / 9.81  # 49.9 ms: the sphere with 0.5 m/s sideways; a row comes every 10 ms
        self.assertTrue(stop - 0.0101 < error.run.series["time"].iloc[-1] < stop + 1e-3)
        self.assertGreater(len(error.run.frames), 1)

    def test_programs(self):
        with self.says("nowhere", "cannot be started"):
            subsoil.run(FALL, "none", program="./nowhere")
        with self.says("out="):
            subsoil.run(FALL)

    def test_no_results(self):
        os.mkdir("empty")
        for folder, words in ("empty", "holds none of"), ("nothing", "no such folder"), ("done/run.h5", "name the folder of the run, done"):
            with self.says(words):
                subsoil.open(folder)

    def test_killed_run(self):
        run = self.copy("killed")
        os.remove("killed/summary.json")
        whole = pathlib.Path("killed/series.csv").read_bytes()
        pathlib.Path("killed/series.csv").write_bytes(whole[:-5])
        self.assertFalse(run.complete)
        self.assertEqual(len(run.series), len(self.run_.series) - 1)
        self.assertEqual(len(run.frames), 5)
        with self.says("summary.json: is missing", "subsoil resume killed"):
            run.summary
        for end, words in (b"1,2\n", "columns|fields"), (b"a" + b",1" * (len(run.series.columns) - 1) + b"\n", "'a'"):
            pathlib.Path("killed/series.csv").write_bytes(whole + end)
            with self.says("series.csv", words):
                subsoil.open("killed").series

    def test_closed_run(self):
        with subsoil.open("done") as run:
            kept, other = run.frames[0], run.frames[1]
            self.assertEqual(kept.position.shape, (2, 3))
        self.assertEqual(kept.position.shape, (2, 3))
        with self.says("was closed"):
            other.position

    def test_missing_frames(self):
        run = self.copy("cut")
        os.remove("cut/frames/000001.h5")
        with self.says("cut/frames/000001.h5: is missing"):
            len(run.frames)
        os.remove("cut/run.h5")
        self.assertEqual(len(subsoil.open("cut").frames), 0)
        pathlib.Path("cut/run.h5").write_text("no HDF5")
        with self.says("run.h5", "HDF5"):
            subsoil.open("cut").frames


class Guide(unittest.TestCase):
    """The example of docs/reference/python.md."""

    def test_example(self):
        page = (pathlib.Path(__file__).resolve().parents[2] / "docs/reference/python.md").read_text(encoding="utf-8")
        example = page.split("```python\n")[1].split("```")[0]
        before, said = os.getcwd(), io.StringIO()
        with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(said):
            os.chdir(folder)
            os.environ["SUBSOIL"] = PROGRAM
            subprocess.run([PROGRAM, "new", "tine", "--out", "tine.yaml"], check=True, stdout=subprocess.DEVNULL)
            names = {}
            exec(example, names)
            names["run"].close()
            os.chdir(before)
        # Towed at 0.5 m/s from 0.08 m on, 0.1 m above the surface.
        np.testing.assert_allclose(names["position"], [0.08 + 0.5 * 0.2, 0.1, 0], atol=1e-5)
        self.assertIn("frame 10 at 0.2 s", said.getvalue())
        self.assertIn("exit code 2", said.getvalue())


if __name__ == "__main__":
    unittest.main()
