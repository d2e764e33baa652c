#!/usr/bin/env python3
"""Builds and tests: the gate that every change passes, the daily suite, or everything. The last line is the number of
test cases: `N passed, N failed`; any failure makes the exit code 1.

  scripts/test              the gate: builds, runs every short test case, of the long ones a third in turn and those that
                            the change touches, unit tests under the address and undefined-behaviour sanitizers: of one
                            library in turn and of those that the change touches, and readers of foreign files that the
                            change touches fuzzed for a minute each (scripts/fuzz); random scenarios of fixed seeds for
                            two minutes (tests/consistency)
  scripts/test --quick      the daily suite: builds, runs all but the cases that take a second or more (`long`)
  scripts/test --all        every test case, all unit tests under the sanitizers with all kernels of this machine, and
                            every reader of foreign files fuzzed for a minute; random scenarios of new seeds for
                            thirty minutes
  scripts/test -R PATTERN   only cases whose name has PATTERN (`Heaps`, `Search.Misses*`, `*/4`), no sanitizers

Turns: by the number of commits modulo 3 (`git rev-list --count HEAD`; without git or in a shallow clone, by the day), so
three commits in a row sanitize libdem, libmbd and coupling and run every long case. A change touches files that differ from
the merge base with main (on main itself: from the commit before) or are not committed; TOUCHED says which long cases it wakes.
Which cases are long: tests/CMakeLists.txt. Packages that are missing are installed first, by scripts/setup."""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Libraries whose unit tests the gate runs under the sanitizers: those that lay out memory by hand and work on it in
# parallel. `apps`, which has more to compile than all others, is sanitized by --all.
SANITIZED = ["libdem", "libmbd", "coupling"]
# Long cases that a change wakes whatever their turn: executable of the cases -> folders that they are about.
TOUCHED = {
    "unit_libdem": ("libdem/", "tests/unit/libdem/", "tests/tools/"),
    "unit_apps": ("libsim/run/", "libsim/fmu/", "examples/fmu/", "libsim/studies/laboratory/", "configs/", "tests/unit/apps/"),
    "unit_studies": ("libsim/io/", "libsim/studies/design/", "scripts/abuse", "tests/unit/studies/"),
    "unit_docs": ("docs/", "README.md", "apps/commands/", "configs/templates/", "python/", "tests/docs/"),
    "verification_mechanisms": ("libmbd/", "tests/verification/mechanisms/"),
    "verification_particles": ("libdem/laws/", "tests/verification/particles/"),
    "properties": ("libdem/", "tests/properties/"),
    "regression": ("coupling/", "tests/regression/"),
    "optional": ("libsim/io/", "libsim/fmu/", "libsim/report/", "libsim/view/", "python/", "tests/optional/"),
    "verification_scenarios": ("coupling/", "configs/1s300", "configs/parts/", "tests/verification/scenarios/"),
}
# Targets of scripts/fuzz that a change wakes -> beginnings of the sources that they read foreign bytes with.
FUZZED = {
    "scenario": ("libsim/document/document", "libsim/document/yaml_", "libsim/base/input_limits"),
    "unit": ("libsim/document/units", "libsim/document/quantity", "libsim/document/grammar"),
    "value": ("libsim/document/arithmetic", "libsim/document/quantity", "libsim/document/units", "libsim/document/grammar"),
    "formula": ("libsim/document/expression", "libsim/document/formula", "libsim/document/grammar", "libsim/document/jet"),
    "mesh": ("libsim/scenario/shapes/mesh", "libdem/geometry/mesh_builders", "libdem/geometry/triangle_mesh"),
    "bed": ("libsim/io/bed_file", "libsim/io/csv", "libsim/io/hdf5", "libsim/io/read_guard"),
    "series": ("libsim/io/series", "libsim/io/csv"),
    "state": ("libsim/run/restart", "libsim/io/state_file", "libsim/io/hdf5", "libsim/io/read_guard"),
    "frames": ("libsim/post/frames_file", "libsim/io/joined_frame", "libsim/io/hdf5", "libsim/io/read_guard"),
}
# Random scenarios (tests/consistency): wall time in s and seeds of the gate, wall time of --all, which takes new seeds. The
# seeds of the gate are those without a violation; README.md there lists what is open.
CONSISTENCY_GATE, CONSISTENCY_SEEDS, CONSISTENCY_ALL = 120, "2:17", 1800
# The portable kernel alone in the gate: of wider sets the sanitizer sees plain loads and stores only, no gather.
SANITIZED_SETS, ALL_SANITIZED_SETS = "portable", "native"


def fail(text):
    sys.exit(f"test: {text}")


def output_of(*command):
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    return done.stdout if done.returncode == 0 else None


def commit_number():
    if (output_of("git", "rev-parse", "--is-shallow-repository") or "").strip() == "false":
        count = output_of("git", "rev-list", "--count", "HEAD")
        if count:
            return int(count)
    return int(time.time() // 86400)


def changed_files():
    """Relative to the merge base with main, or to the commit before; with what is not committed."""
    head = (output_of("git", "rev-parse", "HEAD") or "").strip()
    for other in "origin/main", "main":
        base = (output_of("git", "merge-base", "HEAD", other) or "").strip()
        if base and base != head:
            break
    else:
        base = "HEAD~1"
    differing = output_of("git", "diff", "--name-only", base)
    if differing is None:
        return []
    return (differing + (output_of("git", "ls-files", "--others", "--exclude-standard") or "")).split()


def listed(preset):
    """Tests that ctest knows: name, labels, command."""
    answer = subprocess.run(["ctest", "--preset", preset, "--show-only=json-v1"], cwd=ROOT, capture_output=True, text=True)
    if answer.returncode:
        fail(f"ctest lists no tests:\n{answer.stdout}{answer.stderr}")
    tests = []
    for test in json.loads(answer.stdout)["tests"]:
        properties = {one["name"]: one["value"] for one in test.get("properties", [])}
        tests.append({"name": test["name"], "labels": properties.get("LABELS", []),
                      "command": test.get("command", [])})
    return tests


class Session:
    def __init__(self):
        self.start = time.monotonic()
        self.cores = str(os.cpu_count() or 1)
        self.passed = self.failed = self.skipped = 0
        # Tests that are about threads ask for their number; the others take one each, so that `ctest -j` fills the
        # cores. Waiting threads sleep: some tests ask for more threads than there are cores.
        self.environment = dict(os.environ, OMP_NUM_THREADS="1", OMP_WAIT_POLICY="passive",
                                UBSAN_OPTIONS="print_stacktrace=1")

    def say(self, text):
        print(f"== {text} ({time.monotonic() - self.start:.0f} s so far)", flush=True)

    def build(self, preset, targets=(), options=()):
        """Configures and builds; a build that breaks is a failure too."""
        self.say(f"{preset}: configure and build")
        steps = [["cmake", "--preset", preset, *options],
                 ["cmake", "--build", "--preset", preset, "-j", self.cores, *(["--target", *targets] if targets else [])]]
        for command in steps:
            done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            lines = done.stdout.splitlines()
            if done.returncode:
                print(done.stdout, file=sys.stderr)
                self.failed += 1
                return False
            for k in (k for k, line in enumerate(lines) if "warning:" in line):
                print("\n".join(lines[k:k + 6]))
        return True

    def count(self, preset, test):
        """Cases of one ctest from the results that it left; without them it crashed and counts as one failure."""
        try:
            results = json.loads((ROOT / "build" / preset / "results" / f"{test['name']}.json").read_text())
        except (OSError, ValueError):
            print(f"test: {test['name']} left no results", file=sys.stderr)
            self.failed += 1
            return
        cases = [case for suite in results["testsuites"] for case in suite["testsuite"] if case["status"] == "RUN"]
        failed = sum("failures" in case for case in cases)
        skipped = sum(case["result"] == "SKIPPED" for case in cases)
        self.passed += len(cases) - failed - skipped
        self.skipped += skipped
        self.failed += failed

    def run(self, preset, tests):
        if not tests:
            print(f"test: preset {preset} knows no tests to run", file=sys.stderr)
            self.failed += 1
            return
        for test in tests:
            (ROOT / "build" / preset / "results" / f"{test['name']}.json").unlink(missing_ok=True)
        names = "^(" + "|".join(re.escape(test["name"]) for test in tests) + ")$"
        command = ["ctest", "--preset", preset, "-j", self.cores, "-R", names]
        before = self.failed
        code = subprocess.run(command, cwd=ROOT, env=self.environment).returncode
        for test in tests:
            self.count(preset, test)
        if code and self.failed == before:
            self.failed += 1  # a ctest failed although each of its cases passed

    def run_pattern(self, pattern):
        """The cases of each executable by its own filter; the others' results are not asked for."""
        wide = pattern if "*" in pattern else f"*{pattern}*"
        executables = sorted({test["command"][0] for test in listed("release") if test["command"]})
        ran = 0
        for executable in executables:
            answer = ROOT / "build" / "release" / "results" / "pattern.json"
            answer.unlink(missing_ok=True)
            listing = subprocess.run([executable, "--gtest_list_tests", f"--gtest_filter={wide}"], capture_output=True, text=True)
            if not re.search(r"^  \S", listing.stdout, re.M):
                continue
            ran += 1
            subprocess.run([executable, f"--gtest_filter={wide}", "--gtest_output=json:" + str(answer)],
                           cwd=ROOT, env=self.environment)
            self.count("release", {"name": "pattern"})
        if ran == 0:
            print(f"test: no case has {pattern} in its name", file=sys.stderr)
            self.failed += 1

    def examples(self):
        """The programs of examples/, built against the installed libraries; a case each."""
        self.say("examples: install, build and run")
        done = subprocess.run(["scripts/examples"], cwd=ROOT, env=self.environment, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True)
        passed = len(re.findall(r"^ *\d+/\d+ Test .* Passed", done.stdout, re.M))
        failed = len(re.findall(r"^ *\d+/\d+ Test .*\*\*\*", done.stdout, re.M))
        self.passed += passed
        self.failed += failed
        if done.returncode or passed == 0:
            print(done.stdout, file=sys.stderr)
            self.failed += failed == 0  # the build broke

    def sanitize(self, libraries, sets):
        targets = [f"unit_{library}" for library in libraries]
        if self.build("sanitize", targets, [f"-DSUBSOIL_SIMD={sets}"]):
            tests = [test for test in listed("sanitize") if set(targets) & set(test["labels"])]
            self.say(f"sanitize: {', '.join(targets)}")
            self.run("sanitize", tests)

    def fuzz(self, names):
        """A case for each of these targets of scripts/fuzz, with clang, which the other suites do not need."""
        if not names:
            return
        self.say(f"fuzz: {', '.join(names)}")
        for command in ["scripts/setup", "--fuzz"], ["scripts/fuzz", "--seed", "1", *names]:
            done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            print(done.stdout, end="")
        clean = sum(re.search(rf"^{name} .*clean$", done.stdout, re.M) is not None for name in names)
        self.passed += clean
        self.failed += len(names) - clean

    def consistency(self, seeds, seconds):
        """The tests of the random machine, then its scenarios: a case for each relation held against one."""
        self.say(f"consistency: seeds {seeds}, {seconds} s")
        folder = "tests/consistency"
        python = next((one for one in (sys.executable, "/usr/bin/python3")
                       if subprocess.run([one, "-c", "import numpy, h5py, yaml"], capture_output=True).returncode == 0), None)
        if python is None:
            print("test: tests/consistency needs NumPy, h5py and PyYAML (scripts/setup)", file=sys.stderr)
            self.failed += 1
            return
        done = subprocess.run([python, f"{folder}/test_consistency.py"], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        ran = re.search(r"^Ran (\d+) tests", done.stdout, re.M)
        if done.returncode or not ran:
            print(done.stdout)
            self.failed += 1
        else:
            self.passed += int(ran[1])
        command = [python, folder, "--program", "build/release/apps/subsoil", "--seeds", seeds, "--seconds", str(seconds)]
        done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        print(done.stdout, end="")
        counts = re.search(r"^(\d+) passed, (\d+) failed$", done.stdout, re.M)
        if counts is None or (done.returncode != 0) != (int(counts[2]) > 0):
            self.failed += 1  # it stopped before its end, or no scenario ran
        if counts:
            self.passed += int(counts[1])
            self.failed += int(counts[2])

    def end(self):
        took = time.monotonic() - self.start
        print(f"took {took:.0f} s" + (f"; {self.skipped} cases say that they have nothing to test here" if self.skipped else ""))
        print(f"{self.passed} passed, {self.failed} failed")
        return 1 if self.failed else 0


def sanitized(changed, number):
    """The library whose turn it is and those that the change touches."""
    turn = SANITIZED[number % len(SANITIZED)]
    return [one for one in SANITIZED
            if one == turn or any(file.startswith((one + "/", f"tests/unit/{one}/")) for file in changed)]


def fuzzed(changed):
    """The targets whose readers the change touches."""
    listing = output_of("scripts/fuzz", "--list") or fail("scripts/fuzz lists no targets")
    if set(listing.split()) != set(FUZZED):
        fail("FUZZED of scripts/run_tests.py and the targets of scripts/fuzz differ")
    return [name for name, sources in FUZZED.items()
            if any(file.startswith((*sources, "tests/fuzz/targets", f"tests/fuzz/corpus/{name}/")) for file in changed)]


def in_turn(tests, changed, number):
    """The short cases, the long ones whose turn it is, and those that the change wakes."""
    def woken(test):
        folders = [TOUCHED.get(label) for label in test["labels"] if label != "long"]
        if None in folders:
            fail(f"TOUCHED of scripts/run_tests.py does not say which folders {test['name']} is about")
        return any(file.startswith(tuple(named)) for named in folders for file in changed)

    long = [test for test in tests if "long" in test["labels"]]
    turn = {test["name"]: k % 3 for k, test in enumerate(sorted(long, key=lambda test: test["name"]))}
    return [test for test in tests if test["name"] not in turn or turn[test["name"]] == number % 3 or woken(test)]


def options():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--quick", action="store_true", help="the daily suite")
    group.add_argument("--all", action="store_true", help="every case, all unit tests under the sanitizers")
    group.add_argument("-R", metavar="PATTERN", help="only cases of this name")
    return parser.parse_args()


def main():
    o = options()
    session = Session()
    python = "ON" if (ROOT / "build/venv/requirements.txt").exists() else "OFF"  # scripts/setup --python, by the network
    changed, number = changed_files(), commit_number()
    sanitizes = SANITIZED if o.all else [] if o.quick or o.R else sanitized(changed, number)
    # The portable kernels take a tenth of the build: the gate compiles them when the sanitizers are libdem's. Benchmarks are
    # compiled and not run.
    sets = "native" if o.all or "libdem" in sanitizes else "machine"
    built = session.build("release", options=["-DSUBSOIL_BENCH=ON", f"-DSUBSOIL_SIMD={sets}", f"-DSUBSOIL_PYTHON={python}"])
    if built and o.R:
        session.run_pattern(o.R)
    elif built:
        known = listed("release")
        if o.quick:
            tests = [test for test in known if "quick" in test["labels"]]
        else:
            session.environment |= {"SUBSOIL_LONG_BLOCKS": "1"} if o.all else {}
            tests = known if o.all else in_turn(known, changed, number)
        session.say(f"release: {len(tests)} of {len(known)} groups of test cases")
        session.run("release", tests)
    if built and not o.quick and not o.R:
        session.examples()
    if o.all:
        session.sanitize([*sanitizes, "apps"], ALL_SANITIZED_SETS)
        session.fuzz(list(FUZZED))
        session.consistency(f"{int(time.time())}:", CONSISTENCY_ALL)
    elif not o.quick and not o.R:
        session.sanitize(sanitizes, SANITIZED_SETS)
        session.fuzz(fuzzed(changed))
        session.consistency(CONSISTENCY_SEEDS, CONSISTENCY_GATE)
    return session.end()


if __name__ == "__main__":
    sys.exit(main())
