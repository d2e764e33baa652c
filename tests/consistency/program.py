"""Runs the built program on a scenario and reads what it leaves."""
import csv
import json
import math
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import tempfile

import h5py
import numpy
import yaml

from geometry import Name, View, render

HANG = 30.0  # s of a core; a scenario of this generator takes a second. Wall time says nothing on a loaded machine.
SLOW = 1.0   # s of a core: a scenario that takes longer is left out, since each relation runs it again


class Result:
    """One run: exit code, what was printed, and its folder."""

    def __init__(self, folder, code, stdout, stderr, scenario):
        self.folder, self.code, self.stdout, self.stderr, self.scenario = pathlib.Path(folder), code, stdout, stderr, scenario
        self._rows = None

    @property
    def text(self):
        return self.stdout + self.stderr

    @property
    def ended(self):
        return self.code == 0

    def table(self):
        """Columns of series.csv: name -> array, in the file's order; units beside it in `units`."""
        if self._rows is None:
            with open(self.folder / "series.csv", newline="") as file:
                lines = list(csv.reader(file))
            heads = [re.match(r"^(.*) \[(.*)\]$", head) for head in lines[0]]
            self.units = {head[1]: head[2] for head in heads}
            numbers = numpy.array([[float(x) for x in line] for line in lines[1:]], dtype=float).reshape(len(lines) - 1, len(heads))
            self._rows = {head[1]: numbers[:, k] for k, head in enumerate(heads)}
        return self._rows

    def summary(self):
        return json.loads((self.folder / "summary.json").read_text())

    def frames(self):
        """Frames of spheres: (time, {dataset: array}), and the particle table."""
        with h5py.File(self.folder / "run.h5") as file:
            table = {name: file["particles"][name][...] for name in file["particles"]} if "particles" in file else {}
            answer = []
            for name in sorted(file["frames"]) if "frames" in file else []:
                group = file["frames"][name]
                answer.append((float(group.attrs["time"]), {k: group[k][...] for k in group if isinstance(group[k], h5py.Dataset)}))
        return table, answer

    def spheres(self):
        """Places and velocities of the last frame as columns `sphere place.x` ..., one entry per sphere."""
        _, frames = self.frames()
        if not frames or "position" not in frames[-1][1] or "velocity" not in frames[-1][1]:
            return {}
        last = frames[-1][1]
        return {f"{word}.{axis}": last[name][:, k].astype(float) for word, name in (("sphere place", "position"), ("sphere velocity", "velocity"))
                for k, axis in enumerate("xyz")}

    def states(self):
        def instant(path):
            return float(path.stem.split("-", 1)[1])
        return sorted(((instant(path), path) for path in self.folder.glob("state-*.h5")), key=lambda pair: pair[0])


class Program:
    """The program under test and a folder for its results, removed at the end."""

    def __init__(self, path):
        self.path = str(pathlib.Path(path).resolve())
        self.home = pathlib.Path(tempfile.mkdtemp(prefix="consistency-"))
        self.count = self.runs = 0
        self.last = 0.0  # s of a core of the last command
        self.environment = dict(os.environ, OMP_WAIT_POLICY="passive", OMP_NUM_THREADS="1")

    def close(self):
        shutil.rmtree(self.home, ignore_errors=True)

    def command(self, *arguments, limit=HANG, cwd=None):
        self.runs += 1

        def bounded():
            resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(limit), math.ceil(limit) + 1))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        try:
            done = subprocess.run([self.path, *map(str, arguments)], capture_output=True, text=True, timeout=20 * limit, cwd=cwd or self.home,
                                  env=self.environment, errors="replace", preexec_fn=bounded)
        except subprocess.TimeoutExpired as error:
            return "hang", (error.stdout or b"").decode(errors="replace"), f"no end after {20 * limit:g} s of wall time"
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.last = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        if done.returncode in (-signal.SIGXCPU, -signal.SIGKILL) and self.last >= limit - 1:
            return "hang", done.stdout, f"no end after {limit:g} s of a core"
        return done.returncode, done.stdout, done.stderr

    def write(self, document, stem="scenario"):
        self.count += 1
        folder = self.home / f"{self.count}"
        folder.mkdir()
        path = folder / f"{stem}.yaml"
        path.write_text(document if isinstance(document, str) else dump(document))
        return path

    def run(self, tree, view=None, options=(), word="run", limit=HANG):
        """tree: scenario tree, plain mapping, or text of YAML."""
        document = tree if isinstance(tree, str) else render(tree, view or View())
        path = self.write(document)
        out = path.parent / "out"
        code, stdout, stderr = self.command(word, path, *(["--out", out] if word == "run" else []), *options, limit=limit)
        return Result(out, code, stdout, stderr, document)

    def check(self, tree, view=None):
        return self.run(tree, view, word="check")


class Dumper(yaml.SafeDumper):
    def ignore_aliases(self, data):
        return True


def dump(document):
    return yaml.dump(document, Dumper=Dumper, sort_keys=False, width=110, allow_unicode=True, default_flow_style=None)


def name_of(key):
    return key.text if isinstance(key, Name) else key
