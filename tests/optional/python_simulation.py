#!/usr/bin/python3
"""The compiled part of the Python module against the program and closed forms. `python_simulation.py PROGRAM MODULES
[unittest's arguments]`; MODULES: the folder that holds subsoil/_core. Exit code 77: a package or the compiled part is
missing."""
import gc
import importlib.util
import os
import pathlib
import signal
import sys
import tempfile
import threading
import time
import unittest
import weakref

for package in "h5py", "numpy", "pandas", "yaml":
    if importlib.util.find_spec(package) is None:
        print(f"no {package}: scripts/setup")
        sys.exit(77)
PROGRAM, MODULES = os.path.abspath(sys.argv.pop(1)), pathlib.Path(sys.argv.pop(1)).absolute()
if not list(MODULES.glob("subsoil/_core*.so")):
    print("no compiled part of the Python module: `scripts/setup --python` needs the network once, then -DSUBSOIL_PYTHON=ON")
    sys.exit(77)
import h5py
import numpy as np

sys.path.insert(0, str(MODULES))
import subsoil

ROOT = pathlib.Path(__file__).resolve().parents[2]
CONTACTS = [{"between": ["soil", other], "law": "linear", "k_n": "40 kN/m", "restitution": 0.4, "mu": 0.5, "mu_r": 0.2}
            for other in ("soil", "steel")]
TRENCH = {
    "subsoil": 1,
    "materials": {"soil": {"density": "2600 kg/m^3"}, "steel": {"density": "7850 kg/m^3"}},
    "contacts": CONTACTS,
    "soil": {"container": {"size": "0.4 0.1 0.08 m", "at": "0 -0.1 -0.04 m", "material": "steel",
                           "open after settling": ["+x"]},
             "surface": "0 m",
             "bed": {"fill": "rest-lattice", "material": "soil", "radius": "10 mm", "depth": "60 mm",
                     "inside machine": "carve"}},
    "boundaries": [{"name": "tool", "material": "steel", "shape": {"box": "20 80 20 mm"}, "at": "60 10 0 mm",
                    "moves": [{"velocity": "0.4 0 0 m/s"}]}],
    "time": {"end": "80 ms"},
    "output": {"every": "20 ms", "series every": "1 ms", "series digits": "all", "precision": "double",
               "monitor": {"draft": {"soil force": "tool", "along": "-1 0"}}}}
# Periodic sides: images behind the spheres' records make the array grow between steps.
PERIODIC = {**TRENCH, "soil": {**TRENCH["soil"], "container": {"size": "0.4 0.1 0.08 m", "at": "0 -0.1 -0.04 m",
                                                               "material": "steel", "periodic": ["z"]}}}
# A moving window: spheres come and leave between steps.
WINDOW = {
    **TRENCH, "parameters": {"period": "0.4 m"},
    "soil": {"container": {"size": "0.4 0.2 0.08 m", "at": "0 -0.07 -0.04 m", "material": "steel"}, "surface": "0 m",
             "bed": {"fill": "random", "material": "soil", "radius": {"uniform": "9 10 mm"}, "depth": "60 mm", "seed": 1,
                     "inside machine": "carve"},
             "moving": {"follows": "tool", "block": "100 mm", "period": "period"}},
    "boundaries": [{"name": "tool", "material": "steel", "shape": {"box": "15 200 30 mm"}, "at": "0.11 0.07 0 m",
                    "moves": [{"velocity": "4 0 0 m/s"}]}]}
MIXED = {**TRENCH, "precision": "mixed"}
CART = {
    "subsoil": 1, "gravity": "0 m/s^2",
    "machine": {"bodies": {"cart": {"mass": "2 kg", "inertia": "1 kg m^2", "at": "0 0 m"}},
                "joints": {"rail": {"translational": ["ground", "cart"], "along": "1 0"}}},
    "time": {"end": "10 s"}}


def states_equal(test, a, b):
    """What two HDF5 files of states hold of time, bed and coupling."""
    found = ["time"]
    for group in "bed", "soil", "coupling":
        a[group].visititems(lambda name, one: found.append(f"{group}/{name}") if isinstance(one, h5py.Dataset) else None)
    test.assertGreater(len(found), 20)
    for name in found:
        np.testing.assert_array_equal(a[name][()], b[name][()], err_msg=name)


class Bits(unittest.TestCase):
    """Simulations beside runs of the program."""

    def test_a_state_is_that_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            run = subsoil.run(TRENCH, out=folder + "/run", program=PROGRAM, threads=1)
            with h5py.File(run.states[-1], "r") as of_program:
                sim = subsoil.Simulation(TRENCH, threads=2)
                sim.observe(lambda at: (at.position, at.value("draft")))  # to look changes no bit
                sim.run_until(0.08)
                mine = pathlib.Path(folder, "mine.h5")
                mine.write_bytes(sim.save().to_bytes())
                with h5py.File(mine, "r") as in_process:
                    states_equal(self, of_program, in_process)

    def test_wrench_is_the_row_of_the_series(self):
        """Rows hold the mean force since the row before (output.forces), as wrench() does over a call."""
        steps = ["time.soil step=20 us"]  # 50 of them between rows
        with tempfile.TemporaryDirectory() as folder:
            series = subsoil.run(TRENCH, out=folder + "/run", program=PROGRAM, threads=1, sets=steps).series
        sim = subsoil.Simulation(TRENCH, threads=1, sets=steps)
        drafts, largest = [], series["draft"].abs().max()
        self.assertGreater(largest, 1)
        for t in series["time"].iloc[1:]:
            sim.run_until(t)
            self.assertAlmostEqual(sim.time, t, delta=1e-12)
            (fx, _, _), _ = sim.wrench("tool")
            drafts.append(-fx)
            (fx, _, _), _ = sim.wrench("tool", mean=False)
            self.assertEqual(sim.value("draft"), -fx)
        # Steps are weighed by their share of a row's interval, whose ends are rounded to 1e-17 s of 20 us.
        np.testing.assert_allclose(drafts, series["draft"].iloc[1:], rtol=0, atol=1e-11 * largest)

    def test_mean_wrench_is_the_impulse(self):
        sim = subsoil.Simulation(TRENCH, threads=1)
        forces = []
        for _ in range(40):
            sim.step()
            forces.append(sim.wrench("tool")[0])
        other = subsoil.Simulation(TRENCH, threads=1)
        other.step(40)
        force, moment = other.wrench("tool")
        np.testing.assert_allclose(force, np.mean(forces, axis=0), rtol=0, atol=1e-12 * np.abs(forces).max())
        # Moved by r, the moment changes by -r x F.
        r = np.array([0.1, -0.2, 0.3])
        np.testing.assert_allclose(other.wrench("tool", about=r)[1], moment - np.cross(r, force), atol=1e-12 * np.abs(moment).max())

    def test_a_state_is_exact(self):
        sim = subsoil.Simulation(TRENCH, threads=1)
        sim.run_until(0.02)
        state = sim.save()
        sim.step(100)
        first = sim.position
        sim.restore(subsoil.State.from_bytes(state.to_bytes()))
        self.assertAlmostEqual(sim.time, state.time, delta=0)
        sim.step(100)
        np.testing.assert_array_equal(first, sim.position)


    def test_a_bed_starts_from_a_file(self):
        sim = subsoil.Simulation(TRENCH, threads=1)
        sim.step(50)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "bed.h5")
            file.write_bytes(sim.save().to_bytes())
            other = subsoil.Simulation(TRENCH, threads=1, start=file)
            order, same = np.argsort(sim.id), np.argsort(other.id)
            np.testing.assert_array_equal(other.position[same], sim.position[order])
            self.assertTrue(other.step(5))
            stiffer = subsoil.Simulation(TRENCH, sets=["contacts[0].k_n=60 kN/m"], threads=1, start=file)
            np.testing.assert_array_equal(stiffer.position[np.argsort(stiffer.id)], sim.position[order])
            for other_bed in "soil.bed.radius=9 mm", "materials.soil.density=5000 kg/m^3":
                with self.assertRaisesRegex(subsoil.SubsoilError, "its bed was made with"):
                    subsoil.Simulation(TRENCH, sets=[other_bed], start=file)
            with self.assertRaisesRegex(subsoil.SubsoilError, "nowhere.h5"):
                subsoil.Simulation(TRENCH, start=folder + "/nowhere.h5")


class Arrays(unittest.TestCase):
    """Arrays share the engine's memory and hold the instant at which they are read."""

    def test_they_are_views(self):
        sim = subsoil.Simulation(TRENCH, threads=1)
        position = sim.position
        self.assertEqual((position.shape, position.dtype), ((len(sim.id), 3), np.float64))
        self.assertFalse(position.flags.owndata)
        self.assertFalse(position.flags.writeable)
        self.assertEqual(position.strides, (96, 8))
        self.assertEqual(sim.velocity.ctypes.data - position.ctypes.data, 32)
        self.assertTrue((sim.radius == 0.01).all())
        self.assertEqual(len(set(sim.id)), len(position))
        with self.assertRaises(ValueError):
            position[0, 0] = 1
        address = position.ctypes.data
        del position
        sim.step(3)  # no one reads: the engine stays where it is
        self.assertEqual(sim.position.ctypes.data, address)

    def held(self, scenario, steps, chunk, **options):
        """Keeps arrays of many instants, compares them with copies of then, and the end with a simulation without readers."""
        sim = subsoil.Simulation(scenario, threads=2, **options)
        kept = []
        for _ in range(steps // chunk):
            arrays = [sim.position, sim.velocity, sim.angular_velocity, sim.radius, sim.id, sim.material]
            part = arrays[0][3:7, 1]  # a view of a view
            kept.append((arrays + [part], [array.copy() for array in arrays + [part]]))
            sim.step(chunk)
        for arrays, copies in kept:
            for array, copy in zip(arrays, copies):
                np.testing.assert_array_equal(array, copy)
        self.assertFalse(np.array_equal(kept[0][1][0], kept[-1][1][0]))
        other = subsoil.Simulation(scenario, threads=1, **options)
        other.step(steps // chunk * chunk)
        for name in "position", "velocity", "angular_velocity", "id":
            np.testing.assert_array_equal(getattr(sim, name), getattr(other, name), err_msg=name)
        return sim, kept

    def test_they_hold_their_instant(self):
        sim, kept = self.held(TRENCH, 60, 7)
        last, copy = sim.position, sim.position.copy()
        del sim
        gc.collect()
        np.testing.assert_array_equal(last, copy)
        np.testing.assert_array_equal(kept[2][0][0], kept[2][1][0])

    def test_in_mixed_precision(self):
        self.held(MIXED, 60, 7)

    def test_beside_periodic_sides(self):
        self.held(PERIODIC, 400, 40)

    def test_in_a_moving_window(self):
        sim, kept = self.held(WINDOW, 2400, 200)
        self.assertGreater(len({frozenset(copies[4]) for _, copies in kept}), 1)  # spheres came and left

    def test_they_survive_a_restored_state(self):
        sim = subsoil.Simulation(TRENCH, threads=1)
        state = sim.save()
        sim.step(20)
        position, copy = sim.position, sim.position.copy()
        sim.restore(state)
        np.testing.assert_array_equal(position, copy)
        self.assertFalse(np.array_equal(sim.position, copy))

    def test_of_a_machine_alone(self):
        sim = subsoil.Simulation(CART)
        self.assertEqual((sim.position.shape, sim.id.shape), ((0, 3), (0,)))
        self.assertEqual((sim.has_bed, sim.has_machine), (False, True))


class Control(unittest.TestCase):
    def test_a_servo_moves_its_boundary_alone(self):
        pressed = {**TRENCH["boundaries"][0], "servo": {"load": "20 N", "along": "0 -1 0", "speed limit": "0.1 m/s"}}
        sim = subsoil.Simulation({**TRENCH, "boundaries": [pressed]}, threads=1)
        with self.assertRaisesRegex(ValueError, "its servo moves it"):
            sim.set_motion("tool", position=(0.06, 0.01, 0))

    def test_a_call_ends_at_the_time_asked_for(self):
        sim = subsoil.Simulation(CART, forces_on=["cart"])
        sim.run_until(1.5)  # 1500 steps of 1 ms add up to less
        self.assertEqual(sim.time, 1.5)

    def test_motion_and_wrench(self):
        sim = subsoil.Simulation(TRENCH, threads=1)
        sim.set_motion("tool", position=(0.06, 0.01, 0), velocity=(0.3, 0, 0))
        sim.run_until(0.08)
        position, attitude = sim.pose("tool")
        self.assertAlmostEqual(position[0], 0.06 + 0.3 * sim.time, delta=1e-12)
        np.testing.assert_array_equal(attitude, [1, 0, 0, 0])
        self.assertLess(sim.wrench("tool")[0][0], 0)  # mean of the call

    def test_a_force_is_a_spring_and_a_damper(self):
        sim = subsoil.Simulation(CART, forces_on=["cart"])
        times = []

        def control(at):  # u = -k x - d v
            times.append(at.time)
            (x, _, _), (v, _, _) = at.body("cart")
            at.set_force("cart", -200 * (x - 1) - 60 * v, 0)

        sim.observe(control, every=1e-3)
        sim.run_until(1)
        np.testing.assert_allclose(times, np.arange(1000) * 1e-3, atol=1e-9)
        # 2 x'' + 60 x' + 200 (x - 1) = 0 from rest at 0; the held force errs by the first order of 1 ms.
        a, b = np.roots([2, 60, 200])
        self.assertAlmostEqual(sim.body("cart")[0][0], 1 + (b * np.exp(a) - a * np.exp(b)) / (a - b), delta=2e-3)

    def test_a_controller_is_that_of_the_scenario(self):
        """A sampled PID with bounds and anti-windup, as docs state its formula, in Python and in the scenario."""
        period, least, largest = 2e-3, -6.0, 6.0
        kp, ki, kd, tf = 80.0, 40.0, 12.0, 4e-3
        pid = {"pid": "x", "measured in": "m", "output in": "N", "set point": "0.5 m", "proportional": "80 N/m",
               "integral": "40 N/(m s)", "derivative": "12 N s/m", "filter time": "4 ms", "minimum": "-6 N", "maximum": "6 N",
               "sample time": "2 ms"}
        measured = {**CART["machine"], "measures": {"x": {"position": "cart", "component": "x"}}}
        given = subsoil.Simulation({**CART, "machine": {**measured, "forces": {"push": {"force": "cart", "controller": "c"}},
                                                        "controllers": {"c": pid}}})
        sim = subsoil.Simulation({**CART, "machine": measured}, forces_on=["cart"])
        state = {"i": 0.0, "d": 0.0, "w": None}

        def control(at):
            e = 0.5 - at.body("cart")[0][0]
            if state["w"] is not None:
                state["d"] = (tf * state["d"] + kd * (e - state["w"])) / (tf + period)
                state["i"] += period * ki * e
            state["w"] = e
            v = kp * e + state["i"] + state["d"]
            u = min(max(v, least), largest)
            state["i"] += min(1.0, period / (kp / ki)) * (u - v)
            at.set_force("cart", u, 0)

        sim.observe(control, every=period)
        for t in np.arange(1, 41) * 0.05:
            given.run_until(t), sim.run_until(t)
            # Both are integrated to the default tolerance, 1e-8 of the motion of 0.5 m a step, over 1000 samples of a
            # stable loop, whose errors die away.
            np.testing.assert_allclose(sim.body("cart"), given.body("cart"), atol=2e-6)
        self.assertAlmostEqual(sim.body("cart")[0][0], 0.5, delta=0.05)

    def test_a_set_point(self):
        driven = {**CART, "machine": {**CART["machine"], "drivers": {"feed": {"coordinate": "cart.x", "velocity": "0.1 m/s"}}}}
        self.assertIn("machine.drivers.feed.velocity", subsoil.available_inputs(driven))
        sim = subsoil.Simulation(driven, inputs=["machine.drivers.feed.velocity"])
        self.assertEqual(sim.inputs, {"machine.drivers.feed.velocity": (0.1, "m/s")})
        sim.run_until(0.5)
        sim.set_input("machine.drivers.feed.velocity", 0.1, rate=-0.2)
        sim.run_until(1.5)
        self.assertAlmostEqual(sim.body("cart")[0][0], 0.1 * 0.5 + 0.1 - 0.2 / 2, delta=1e-7)
        self.assertAlmostEqual(sim.inputs["machine.drivers.feed.velocity"][0], -0.1, delta=1e-9)

    def test_set_points_add_up_from_the_start(self):
        """A driver of a velocity that is set again and again, first at the start: the position is its integral."""
        driven = {**CART, "machine": {**CART["machine"], "drivers": {"feed": {"coordinate": "cart.x", "velocity": "0 m/s"}}}}
        for method in "cvode", "adams-moulton", "ida":
            sim = subsoil.Simulation(driven, inputs=["machine.drivers.feed.velocity"],
                                     sets=[f"time.machine.integrator={method}"])
            x = v = 0.0
            for aim in -2, -2, -1, 0, 0.3, 0.3, 0.1:
                rate = (aim - v) / 0.02
                sim.set_input("machine.drivers.feed.velocity", v, rate=rate)
                begin = sim.time
                sim.run_until(begin + 0.02)
                took = sim.time - begin
                x, v = x + took * v + rate * took**2 / 2, v + rate * took
                np.testing.assert_allclose(sim.body("cart"), [[x, 0, 0], [v, 0, 0]], atol=1e-9, err_msg=method)

    def test_settling_is_observed_and_ended(self):
        rain = {**TRENCH, "soil": {**TRENCH["soil"], "bed": {**TRENCH["soil"]["bed"], "fill": "random", "seed": 1}}}
        seen = []
        subsoil.Simulation(rain, threads=1, settling=lambda t, rms: seen.append((t, rms)) or len(seen) < 3)
        self.assertEqual(len(seen), 3)
        self.assertTrue(all(t > 0 and rms > 0 for t, rms in seen[1:]))
        with self.assertRaises(ZeroDivisionError):
            subsoil.Simulation(rain, threads=1, settling=lambda t, rms: 1 / 0)

    def test_columns_have_units(self):
        sim = subsoil.Simulation(TRENCH, threads=1, energies=True)
        self.assertEqual(sim.columns["draft"], "N")
        sim.step(5)
        values = sim.values()
        self.assertEqual(list(values), list(sim.columns))
        self.assertFalse(any(np.isnan(value) for value in values.values()))
        self.assertEqual(values["draft"], sim.value("draft"))


class Calls(unittest.TestCase):
    """Observers, threads, signals, collected memory."""

    def test_an_observer_ends_and_raises(self):
        sim = subsoil.Simulation(TRENCH, threads=1)
        number = sim.observe(lambda at: at.steps < 5)
        self.assertFalse(sim.step(20))
        self.assertEqual(sim.steps, 5)
        sim.stop_observing(number)
        with self.assertRaisesRegex(ValueError, f"observer {number}: there is none"):
            sim.stop_observing(number)
        sim.observe(lambda at: 1 / 0)
        with self.assertRaises(ZeroDivisionError):
            sim.step()
        with self.assertRaisesRegex(TypeError, "callable"):
            sim.observe(3)

    def test_an_observer_does_not_step(self):
        sim = subsoil.Simulation(TRENCH, threads=1)
        for call in (lambda at: at.step()), (lambda at: at.run_until(1)), (lambda at: at.restore(at.save())):
            number = sim.observe(call)
            with self.assertRaisesRegex(RuntimeError, "an observer cannot call it; return False"):
                sim.step()
            sim.stop_observing(number)
        self.assertTrue(sim.step())

    def test_an_observer_may_end_itself(self):
        sim = subsoil.Simulation(TRENCH, threads=1)
        seen = []
        number = sim.observe(lambda at: (seen.append(at.steps), at.stop_observing(number)) and None)
        sim.step(5)
        self.assertEqual(seen, [0])

    def test_other_threads_run_and_are_refused(self):
        sim = subsoil.Simulation(TRENCH, threads=1)
        ticks, refused, ends = [], [], threading.Event()

        def other():
            while not ends.is_set():
                ticks.append(time.perf_counter())
                try:
                    sim.position
                except RuntimeError as error:
                    refused.append(str(error))
                time.sleep(1e-3)

        thread = threading.Thread(target=other)
        thread.start()
        begin = time.perf_counter()
        count = 0
        while time.perf_counter() < begin + 0.3:  # one call of a length that does not follow the machine
            first = time.perf_counter()
            sim.step(2000)
            last = time.perf_counter()
            count += sum(first + 0.1 * (last - first) < tick < last - 0.1 * (last - first) for tick in ticks)
        ends.set(), thread.join()
        self.assertGreater(count, 10)
        self.assertIn("another thread steps it", refused[0])

    def test_an_interrupt_ends_a_call(self):
        sim = subsoil.Simulation(TRENCH, threads=1)
        timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            sim.run_until(1e4)
        self.assertGreater(sim.steps, 0)
        self.assertTrue(sim.step())

    def test_a_cycle_is_collected(self):
        class Logger:
            pass

        sim, logger = subsoil.Simulation(TRENCH, threads=1), Logger()
        logger.sim = sim
        sim.observe(lambda at: logger.sim.time)
        sim.step()
        dead = weakref.ref(sim)
        del sim, logger
        gc.collect()
        self.assertIsNone(dead())


class Faults(unittest.TestCase):
    """Exceptions name place, value, rule and cure."""

    def test_bad_input(self):
        with self.assertRaises(subsoil.ScenarioError) as caught:
            subsoil.Simulation(TRENCH, sets=["time.end=-1 s", "time.ned=1 s"])
        error = caught.exception
        self.assertIsInstance(error, subsoil.SubsoilError), self.assertIsInstance(error, ValueError)
        self.assertEqual((len(error.lines), error.exit_code), (2, 2))
        self.assertEqual(error.lines[0], "--set time.end = -1 s: must be in (0, inf) s")
        self.assertRegex(error.lines[1], "time.ned.*did you mean `end`")
        wrong = {**TRENCH, "contacts": [{**CONTACTS[0], "restitution": 1.5}, CONTACTS[1]]}
        with self.assertRaisesRegex(subsoil.ScenarioError, r"^<dict>:\d+:\d+ contacts\[0\]\.restitution = 1\.5: must be in"):
            subsoil.Simulation(wrong)
        with self.assertRaisesRegex(subsoil.ScenarioError, "nowhere.yaml"):
            subsoil.Simulation("nowhere.yaml")
        with self.assertRaisesRegex(subsoil.SubsoilError, "nowhere.yaml: cannot be read.*name a scenario file"):
            subsoil.available_inputs("nowhere.yaml")
        with self.assertRaisesRegex(subsoil.ScenarioError, "analysis"):
            subsoil.Simulation(CART, sets=["analysis=modes"])
        with self.assertRaisesRegex(subsoil.ScenarioError, "machine.drivers.fed"):
            subsoil.Simulation(CART, inputs=["machine.drivers.fed.velocity"])

    def test_numbers_that_are_no_time_place_or_count(self):
        with self.assertRaisesRegex(subsoil.ScenarioError, r"threads = -1: must be in \[0, 1024\]"):
            subsoil.Simulation(CART, threads=-1)
        sim = subsoil.Simulation(TRENCH, threads=1, settle=False)
        for time in float("inf"), -float("inf"), float("nan"):
            with self.assertRaisesRegex(ValueError, "run_until: the time is "):
                sim.run_until(time)
        for mean in True, False:
            with self.assertRaisesRegex(ValueError, r"wrench: about \(0, 0, nan\) m is no place"):
                sim.wrench("tool", about=[0, 0, float("nan")], mean=mean)
        self.assertEqual(sim.time, 0)

    def test_yes_and_no_of_a_dict(self):
        """YAML 1.1 makes booleans of them; of `stages`, which takes auto, yes and no, too."""
        for stages in False, "no", True:
            bed = {**TRENCH["soil"]["bed"], "settle": {"for": "1 ms", "stages": stages}}
            subsoil.check({**TRENCH, "soil": {**TRENCH["soil"], "bed": bed}})
        bed = {**TRENCH["soil"]["bed"], "fill": False}
        with self.assertRaisesRegex(subsoil.ScenarioError, "unknown word"):
            subsoil.check({**TRENCH, "soil": {**TRENCH["soil"], "bed": bed}})

    def test_check(self):
        self.assertEqual(subsoil.check(CART), [])
        deep = {**TRENCH, "boundaries": [{**TRENCH["boundaries"][0], "at": "60 -70 0 mm"}]}
        self.assertRegex("\n".join(subsoil.check(deep)), "tool")
        with self.assertRaises(subsoil.ScenarioError):
            subsoil.check(TRENCH, sets=["time.end=0 s"])

    def test_names(self):
        sim = subsoil.Simulation(TRENCH, threads=1)
        for call in (lambda: sim.pose("tol")), (lambda: sim.wrench("tol")), (lambda: sim.set_motion("tol", (0, 0, 0))):
            with self.assertRaisesRegex(ValueError, "surface tol: the scenario has no such surface; did you mean `tool`"):
                call()
        with self.assertRaisesRegex(ValueError, "column draf: .*did you mean `draft`"):
            sim.value("draf")
        with self.assertRaisesRegex(ValueError, "attitude has the norm"):
            sim.set_motion("tool", (0, 0, 0), attitude=(1, 1, 0, 0))
        with self.assertRaisesRegex(ValueError, "must be at or above 0 s"):
            sim.observe(print, every=-1)
        cart = subsoil.Simulation(CART, forces_on=["cart"])
        with self.assertRaisesRegex(ValueError, "body car: .*did you mean `cart`"):
            cart.body("car")
        with self.assertRaisesRegex(ValueError, "value and rate must be finite"):
            cart.set_force("cart", float("nan"), 0)
        with self.assertRaisesRegex(ValueError, "name the body in `forces_on`"):
            subsoil.Simulation(CART).set_force("cart", 1, 0)
        with self.assertRaisesRegex(ValueError, "state: is of another scenario"):
            cart.restore(subsoil.Simulation(CART).save())

    def test_a_step_that_fails(self):
        sim = subsoil.Simulation(TRENCH, threads=1)
        sim.step(10)
        begin = sim.time
        sim.set_motion("tool", position=(0.16, 0.01, 0))
        with self.assertRaisesRegex(subsoil.SimulationFault, "^t = ") as caught:
            sim.step(2)
        error = caught.exception
        self.assertIsInstance(error, RuntimeError), self.assertEqual(error.exit_code, 3)
        self.assertTrue(begin <= error.time <= begin + 2 * sim.step_length)


class Wheel(unittest.TestCase):
    def test_stubs_and_docstrings(self):
        """Each public name has a docstring and a stub."""
        stub = (MODULES / "subsoil" / "_core.pyi").read_text()
        for name, one in vars(subsoil.Simulation.__mro__[1]).items():
            if not name.startswith("_"):
                self.assertTrue(one.__doc__ and len(one.__doc__) > 12, name)
                self.assertIn(f"def {name}(", stub)
        self.assertTrue((MODULES / "subsoil" / "py.typed").exists())


if __name__ == "__main__":
    unittest.main()
