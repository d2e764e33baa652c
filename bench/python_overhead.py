#!/usr/bin/python3
"""Cost of calls from Python, by processor time, interleaved.

    bench/python_overhead.py [--rounds 40] [--runs 5] [--scenario configs/1s300-reduced.yaml]

1. One simulation takes blocks of steps: in one call; in a call for each coupling window that reads the wrench on each surface
   and a body; with a controller at 1 kHz that reads a body and sets a force. Then the calls alone, without steps.
2. The program runs the scenario to `--end`, and so does a simulation in process with a call for each window; both with the
   bed's preparation.
Ratios are those of neighbours: their median and quartiles."""
import argparse
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "python"))
import subsoil
import yaml


def ratio(a, b):
    """Median of the ratios of neighbours, with the quartiles."""
    low, middle, high = statistics.quantiles([x / y for x, y in zip(a, b)], n=4)
    return f"{middle:.4f} (quartiles {low:.4f} and {high:.4f})"


def read(sim):
    """What a controller or another simulator reads of a window."""
    for name in sim.surfaces:
        sim.wrench(name)
    sim.body(sim.bodies[0])


def windows(sim, steps, count):
    """A call for each window of `count` steps."""
    for _ in range(steps // count):
        sim.step(count)
        read(sim)


def in_process(options):
    sim = subsoil.Simulation(options.scenario, threads=1, forces_on=[options.body])
    print(f"{len(sim.id)} spheres, step {sim.step_length:.3g} s, {len(sim.surfaces)} surfaces", flush=True)
    sim.run_until(options.begin)
    count = int(yaml.safe_load(sim.scenario)["time"].get("machine", {}).get("soil steps per machine step", 1))
    times = {"one call": [], f"a call for each window of {count} steps": [], "controller at 1 kHz": []}
    names = list(times)

    def control(at):
        (x, y, angle), (vx, vy, omega) = at.body(options.body)
        at.set_force(options.body, 0.0, -1e-9 * y - 1e-9 * vy)

    for k in range(options.rounds):
        for name in names if k % 2 == 0 else names[::-1]:
            observer = sim.observe(control, every=1e-3) if name == names[2] else None
            begin = time.process_time()
            windows(sim, options.block, count) if name == names[1] else sim.step(options.block)
            times[name].append(time.process_time() - begin)
            if observer:
                sim.stop_observing(observer)
    step = statistics.median(times["one call"]) / options.block
    print(f"one call: {1e3 * step:.3f} ms a step")
    for name in names[1:]:
        print(f"{name}: ratio {ratio(times[name], times['one call'])}", flush=True)
    begin = time.process_time()
    for _ in range(2000):
        sim.step(0)
        read(sim)
    each = (time.process_time() - begin) / 2000
    print(f"calls of a window alone: {1e6 * each:.1f} us, {100 * each / (count * step):.2f} % of its steps")
    begin = time.process_time()
    for _ in range(2000):
        control(sim)
    each = (time.process_time() - begin) / 2000
    print(f"a controller's calls alone: {1e6 * each:.1f} us, {100 * each * sim.step_length / 1e-3 / step:.3f} % of 1 ms of steps")


def module_to_end(options):
    """Processor time of a child that steps in process."""
    sim = subsoil.Simulation(options.scenario, threads=1, sets=[f"time.end={options.end} s"])
    while sim.time < options.end - 0.5 * sim.step_length:
        windows(sim, 1, 1)


def beside_program(options):
    program, module, imports = [], [], []

    def spent(command):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    for _ in range(options.runs):
        with tempfile.TemporaryDirectory() as folder:
            program.append(spent([options.program, "run", options.scenario, "--out", folder + "/out", "--threads", "1",
                                  "--set", f"time.end={options.end} s", "--set", f"output.every={options.end} s"]))
        imports.append(spent([sys.executable, "-c", f"import sys; sys.path.insert(0, {str(ROOT / 'python')!r}); "
                              "import subsoil; subsoil.Simulation"]))
        module.append(spent([sys.executable, __file__, "--child", "--scenario", options.scenario, "--end", str(options.end)]))
    print(f"to {options.end} s: program {statistics.median(program):.2f} s, in process {statistics.median(module):.2f} s, "
          f"of which {statistics.median(imports):.2f} s import packages")
    print(f"without the import: ratio {ratio([m - i for m, i in zip(module, imports)], program)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=40, help="of measurements in one simulation")
    parser.add_argument("--block", type=int, default=26, help="steps of a measurement")
    parser.add_argument("--runs", type=int, default=5, help="of pairs beside the program")
    parser.add_argument("--begin", type=float, default=0.01, help="s, before the first measurement")
    parser.add_argument("--end", type=float, default=0.1, help="s, of runs beside the program")
    parser.add_argument("--scenario", default=str(ROOT / "configs/1s300-reduced.yaml"))
    parser.add_argument("--body", default="shovel", help="that the controller acts on")
    parser.add_argument("--program", default=str(ROOT / "build/release/apps/subsoil"))
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        return module_to_end(options)
    in_process(options)
    return beside_program(options)


if __name__ == "__main__":
    main()
