"""Results of `subsoil` in Python, and runs from there.

    import subsoil
    run = subsoil.open("mine")                    # the folder of a run
    run.series["draft"].max()                     # series.csv, a pandas.DataFrame
    run.summary["soil"]                           # summary.json, a dict
    frame = run.frames.nearest(0.1)               # the frame nearest to 0.1 s
    frame.position, frame.radius                  # NumPy arrays, (n, 3) m and (n,) m
    run = subsoil.run("mine.yaml", sets=["time.end=0.1s"], out="short")
    sim = subsoil.Simulation("mine.yaml")         # stepped in this process, by the compiled part
    sim.run_until(0.1)
    sim.position                                  # NumPy array on the engine's memory

All numbers are in SI units, the world is x along travel, y up, z across. Needs h5py, NumPy, pandas and PyYAML
(Debian: python3-h5py python3-numpy python3-pandas python3-yaml; `scripts/setup` installs them).
"""
from __future__ import annotations

import bisect
import csv
import io
import json
import math
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Optional, Union

import h5py
import numpy as np
import pandas as pd
import yaml

PathLike = Union[str, "os.PathLike[str]"]

__all__ = ["Frame", "Frames", "Run", "ScenarioError", "SimulationFault", "SubsoilError", "open", "run"]

_RESULTS = ("scenario.yaml", "series.csv", "summary.json", "run.h5")
_PARTICLE_TABLE = ("id", "radius", "density", "material", "clump")  # of every sphere, once; of some, with the frame
_NOT_OF_SPHERES = ("window", "surfaces", "values", "written", "point numbers", "contact forces", "loads", "parts")
_CODES = {2: "bad input", 3: "stopped, or ended with warnings under --strict", 130: "interrupted", 143: "terminated"}


class SubsoilError(Exception):
    """What went wrong, in the program's own words where it was the program.

    exit_code: of the program (2 bad input, 3 stopped); None where the program had no part
    run: what a run left that was started and did not end as asked, opened; else None
    """

    def __init__(self, message: str, exit_code: Optional[int] = None, run: Optional["Run"] = None):
        super().__init__(message)
        self.exit_code = exit_code
        self.run = run


class ScenarioError(SubsoilError, ValueError):
    """A scenario that cannot be taken.

    lines: one for each fault, `place key = value: rule; cure`
    """

    def __init__(self, message: str, lines: Sequence[str] = ()):
        super().__init__(message, 2)
        self.lines = list(lines) or message.splitlines()


class SimulationFault(SubsoilError, RuntimeError):
    """A simulation that cannot continue: instant, value, rule, cure.

    time: instant, s
    """

    def __init__(self, message: str, time: float = 0.0):
        super().__init__(message, 3)
        self.time = time


class Frame:
    """One moment of a run. Arrays are read when they are asked for, then kept with the frame.

    Spheres, in rising id, n of them (what the run's `output.columns` left out raises SubsoilError):
      position (n, 3) m, velocity (n, 3) m/s, spin (n, 3) rad/s, force (n, 3) N, torque (n, 3) N m, contacts (n,),
      id (n,), radius (n,) m, density (n,) kg/m^3, material (n,) index into Frames.materials; bonds (n,) where a law has any
    """

    def __init__(self, frames: "Frames", index: int):
        self._frames = frames
        self._kept: dict[str, np.ndarray] = {}
        self.index = index
        self.time: float = frames.times[index]  #: s
        self.step: int = frames._steps[index]  #: of the soil

    def __repr__(self) -> str:
        return f"<frame {self.index} at {self.time:g} s>"

    def __len__(self) -> int:
        """Spheres in the frame."""
        return len(self.position) if "position" in self else 0

    def __contains__(self, name: str) -> bool:
        return self._own(name) or (self._in_table(name) and "position" in self)

    def _own(self, name: str) -> bool:
        """Whether it lies with the frame, or with the parts of it that the processes of a run have written."""
        return self._frames._holds(self._path(name)) or (bool(self._parts) and name in self._frames._names(self._parts[0]))

    @property
    def _parts(self) -> list[str]:
        return self._frames._parts_of(self._path("parts"))

    def __getitem__(self, name: str) -> np.ndarray:
        """A column by its name: frame["velocity"]."""
        if name not in self._kept:
            self._kept[name] = self._column(name)
        return self._kept[name]

    def _in_table(self, name: str) -> bool:
        """Only a bed with clumps has their numbers."""
        return name in _PARTICLE_TABLE and (name != "clump" or self._frames._holds("/particles/clump"))

    def _path(self, name: str) -> str:
        return f"/frames/{self.index:06}/{name}"

    def _column(self, name: str) -> np.ndarray:
        if self._frames._holds(self._path(name)):
            return self._frames._read(self._path(name))
        if self._own(name):
            return self._joined(name)
        if self._in_table(name) and "position" in self:
            return self._frames._particles(name)  # everybody is there: one array for all frames
        raise SubsoilError(f"{self._frames.path}: frame {self.index} has no '{name}'; it has "
                           f"{', '.join(self.columns) or 'no spheres'} (output.columns of the scenario selects)")

    def _joined(self, name: str) -> np.ndarray:
        """Of all parts, in rising id."""
        ids, values = (np.concatenate([self._frames._read(f"{part}/{of}") for part in self._parts]) for of in ("id", name))
        order = np.argsort(ids, kind="stable")
        if np.any(np.diff(ids[order]) == 0) or len(ids) != len(values):
            raise SubsoilError(f"{self._frames.path}: the parts of frame {self.index} do not fit together")
        return values[order]

    @property
    def columns(self) -> list[str]:
        """Names of what spheres have here."""
        own = self._frames._names(self._path("")[:-1])
        if self._parts:
            own += self._frames._names(self._parts[0])
        names = [name for name in own if name not in _NOT_OF_SPHERES]
        return names + [name for name in _PARTICLE_TABLE if "position" in own and name not in own and self._in_table(name)]

    id = property(lambda self: self["id"], doc="(n,), rising")
    position = property(lambda self: self["position"], doc="centres, (n, 3) m, world axes")
    velocity = property(lambda self: self["velocity"], doc="(n, 3) m/s, world axes")
    spin = property(lambda self: self["spin"], doc="angular velocity, (n, 3) rad/s, world axes")
    force = property(lambda self: self["force"], doc="(n, 3) N, world axes")
    torque = property(lambda self: self["torque"], doc="about the centre, (n, 3) N m, world axes")
    contacts = property(lambda self: self["contacts"], doc="how many touch it, (n,)")
    bonds = property(lambda self: self["bonds"], doc="intact ones, (n,)")
    radius = property(lambda self: self["radius"], doc="(n,) m")
    density = property(lambda self: self["density"], doc="(n,) kg/m^3")
    material = property(lambda self: self["material"], doc="(n,) index into Frames.materials")

    @property
    def mass(self) -> np.ndarray:
        """(n,) kg, of radius and density."""
        return 4 / 3 * np.pi * self.density.astype(float) * self.radius.astype(float) ** 3

    @property
    def values(self) -> dict[str, float]:
        """Measures of the machine at the frame's time, by name; units: Frames.value_units."""
        if not self._frames._holds(self._path("values")):
            return {}
        return dict(zip(self._frames.value_units, self._frames._read(self._path("values")).ravel().tolist()))

    @property
    def contact_forces(self) -> dict[str, np.ndarray]:
        """Contacts that carry a force, k of them, of runs with `output.contact forces: yes`: "ends" (k, 2, 3) m, from the
        centre of a sphere to that of the other or to the point on a surface; "ids" (k, 2), the second -1 at a surface;
        "force" on the first sphere, (k, 3) N; "normal force" (k,) N, compression positive."""
        if not self._frames._holds(self._path("contact forces/force")):
            raise SubsoilError(f"{self._frames.path}: frame {self.index} has no contact forces; run with "
                               "`output: {contact forces: yes}`")
        held = {name: self._frames._read(self._path(f"contact forces/{name}"))
                for name in ("ends", "ids", "force", "normal force")}
        held["ends"] = held["ends"].reshape(-1, 2, 3)
        return held

    def loads(self, name: str) -> dict[str, np.ndarray]:
        """What the triangles of a surface with `wear` have borne, in the order of Frames.triangles: "mean pressure" Pa,
        "normal work" and "shear work" J/m^2, wear depths m."""
        names = self._frames._names(self._path(f"loads/{name}"))
        if not names:
            raise SubsoilError(f"{self._frames.path}: frame {self.index} has no loads of '{name}'; give the surface "
                               "`wear: {}`")
        return {of: self._frames._read(self._path(f"loads/{name}/{of}")) for of in names}

    def surface(self, name: str) -> np.ndarray:
        """Vertices of a surface now, (m, 3) m, world axes; its faces: Frames.triangles, lines: Frames.segments."""
        shape = self._frames._shape(name)
        path = self._path("surfaces/" + name.replace("/", "_"))
        return self._frames._read(path) if self._frames._holds(path) else shape

    def pose(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Where a surface stands: origin p (3,) m and rotation R (3, 3) of its own axes, world = p + R own.

        A surface's own axes are its body's, with the origin in the centre of mass; of a boundary on a path its own
        place. Frames keep the moved vertices; the pose is the rigid motion that fits them best (Kabsch 1976), as exact
        as these. What stands still has the world's axes: p = 0, R = 1.
        """
        own, world = self._frames._shape(name).astype(float), self.surface(name).astype(float)
        if np.array_equal(own, world):
            return np.zeros(3), np.eye(3)
        middle, moved = own.mean(axis=0), world.mean(axis=0)
        left, size, right = np.linalg.svd((own - middle).T @ (world - moved))
        if not size[1] > 1e-6 * size[0]:
            raise SubsoilError(f"{name}: its points lie on a line or in one point, which has no pose; "
                               "take the columns BODY.x, BODY.y and BODY.angle of the series")
        turn = right.T @ np.diag([1, 1, np.sign(np.linalg.det(right.T @ left.T))]) @ left.T
        misfit = np.abs((own - middle) @ turn.T + moved - world).max()
        if misfit > 1e-4 * np.abs(own - middle).max():
            raise SubsoilError(f"{name}: is not rigid, and has no pose; take surface('{name}')")
        return moved - turn @ middle, turn


class Frames(Sequence):
    """The frames of a run, in order of time: frames[0], frames[-1], frames[::10], frames.nearest(0.2).

    A frame reads what it is asked for; nothing of it stays in memory once it is gone. A run that goes on is seen as far
    as it was when it was opened.
    """

    def __init__(self, path: pathlib.Path):
        self.path = path
        self._file: Any = None
        self._table: dict[str, np.ndarray] = {}
        self.times: list[float] = []  #: s, of every frame
        self._steps: list[int] = []
        if path.exists():
            self._open()

    def _open(self) -> None:
        try:
            self._file = h5py.File(self.path, "r")
            if "frames" not in self._file:
                raise SubsoilError(f"{self.path}: has no group /frames: no output of a run")
            for name in sorted(self._file["frames"]):
                group = self._group(name)
                if "written" in group and not np.any(group["written"][()]):
                    break  # a place that the run did not come to
                self.times.append(float(group.attrs["time"]))
                self._steps.append(int(group.attrs["step"]))
        except OSError as error:
            raise SubsoilError(f"{self.path}: cannot be read as HDF5: {error}") from error

    def _group(self, name: str) -> Any:
        return self._linked(self._file["frames"], name, self.path.parent, name)

    def _linked(self, group: Any, name: str, folder: pathlib.Path, frame: str) -> Any:
        """A group that lies in another file."""
        link = group.get(name, getlink=True)
        try:
            return group[name]
        except (KeyError, OSError) as error:
            where = folder / link.filename if isinstance(link, h5py.ExternalLink) else self.path
            what = "cannot be read" if where.exists() else "is missing: keep run.h5 and the folder frames together"
            raise SubsoilError(f"{where}: {what} (frame {int(frame)})") from error

    def _parts_of(self, path: str) -> list[str]:
        """Paths of the parts of a frame, all of which are there; none where one process has written it."""
        if not self._holds(path):
            return []
        parts = self._file[path]
        folder, frame = pathlib.Path(parts.file.filename).parent, path.split("/")[2]
        for name in parts:
            self._linked(parts, name, folder, frame)
        return [f"{path}/{name}" for name in parts]

    def _holds(self, path: str) -> bool:
        if self._file is None and self.times:
            raise SubsoilError(f"{self.path}: was closed; open the run again")
        try:
            return self._file is not None and path in self._file
        except (KeyError, OSError):
            return False

    def _names(self, path: str) -> list[str]:
        return list(self._file[path]) if self._holds(path) else []

    def _read(self, path: str) -> np.ndarray:
        """The dataset as it lies in the file, in one piece."""
        try:
            return self._file[path][()]
        except (KeyError, OSError, RuntimeError) as error:
            raise SubsoilError(f"{self.path}: {path} cannot be read: {error}") from error

    def _particles(self, name: str) -> np.ndarray:
        if name not in self._table:
            self._table[name] = self._read("/particles/" + name)
            self._table[name].flags.writeable = False  # all frames share it
        return self._table[name]

    def _text(self, path: str) -> list[str]:
        return [str(one) for one in self._file[path].asstr()[()]] if self._holds(path) else []

    def __len__(self) -> int:
        return len(self.times)

    def __getitem__(self, which: Any) -> Any:
        """A Frame by its number, a list of them by a slice."""
        if isinstance(which, slice):
            return [Frame(self, k) for k in range(*which.indices(len(self)))]
        k = which + len(self) if which < 0 else which
        if not 0 <= k < len(self):
            raise IndexError(f"frame {which}: the run has {len(self)}" + (f", 0 to {len(self) - 1}" if self.times else ""))
        return Frame(self, k)

    def nearest(self, time: float) -> Frame:
        """The frame whose time is nearest to `time` s."""
        if not self.times:
            raise SubsoilError(f"{self.path.parent}: the run has no frames")
        if math.isnan(time):
            raise ValueError("nearest: the time is no number")
        k = min(bisect.bisect_left(self.times, time), len(self.times) - 1)
        return self[k - 1 if k > 0 and time - self.times[k - 1] <= self.times[k] - time else k]

    @property
    def materials(self) -> list[str]:
        """Names of the materials, by the number that spheres have."""
        return self._text("/particles/material names")

    @property
    def value_units(self) -> dict[str, str]:
        """Measures that frames carry: name -> unit."""
        return dict(zip(self._text("/values/names"), self._text("/values/units")))

    @property
    def surfaces(self) -> list[str]:
        """Names of what is drawn beside the spheres: surfaces, boundaries, walls, outlines, joints."""
        return self._names("/surfaces")

    def _of_surface(self, name: str, what: str) -> str:
        if name.replace("/", "_") not in self.surfaces:
            raise SubsoilError(f"{self.path}: no surface '{name}'; it has {', '.join(self.surfaces) or 'none'}")
        return f"/surfaces/{name.replace('/', '_')}/{what}"

    def _shape(self, name: str) -> np.ndarray:
        return self._read(self._of_surface(name, "vertices"))

    def triangles(self, name: str) -> np.ndarray:
        """Faces of a surface, (f, 3) numbers of vertices; (0, 3) for lines and points."""
        path = self._of_surface(name, "triangles")
        return self._read(path) if self._holds(path) else np.empty((0, 3), np.int32)

    def segments(self, name: str) -> np.ndarray:
        """Lines of an outline, (s, 2) numbers of vertices; (0, 2) for surfaces and points."""
        path = self._of_surface(name, "segments")
        return self._read(path) if self._holds(path) else np.empty((0, 2), np.int32)

    @property
    def broken_bonds(self) -> pd.DataFrame:
        """Bonds that broke, a row each: time [s], id 1, id 2, x, y, z [m], energy [J], mode `tension`, `shear` or `edge`."""
        names = ["time", "id 1", "id 2", "x", "y", "z", "energy", "mode"]
        if not self._holds("/broken bonds"):
            return pd.DataFrame(columns=names)
        read = {name: self._read("/broken bonds/" + name) for name in ("time", "ids", "position", "energy", "mode")}
        modes = self._text("/broken bonds/modes")
        columns = [read["time"], *read["ids"].T, *read["position"].T, read["energy"], [modes[m] for m in read["mode"]]]
        return pd.DataFrame(dict(zip(names, columns)))

    def close(self) -> None:
        """Closes the file; arrays that were read stay."""
        if self._file is not None:
            self._file.close()
            self._file = None


class Run:
    """The results in a folder; each part is read when it is first asked for."""

    def __init__(self, path: pathlib.Path):
        self.path = path
        self._series: Optional[pd.DataFrame] = None
        self._summary: Optional[dict[str, Any]] = None
        self._frames: Optional[Frames] = None

    def __repr__(self) -> str:
        return f"<run {self.path}>"

    def __enter__(self) -> "Run":
        return self

    def __exit__(self, *unused: Any) -> None:
        self.close()

    def close(self) -> None:
        """Closes the frames' file."""
        if self._frames is not None:
            self._frames.close()

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return (self.path / "summary.json").exists() and self.summary.get("run", {}).get("end") == "reached"

    @property
    def scenario(self) -> str:
        """Text of scenario.yaml: every default explicit."""
        return self._text("scenario.yaml")

    @property
    def series(self) -> pd.DataFrame:
        """series.csv: a row per sample, a column per quantity by its name without unit (`time`, `blade.x`, `draft`).

        `.attrs["units"]` is name -> unit. A last row that a killed run cut short is left out.
        """
        if self._series is None:
            self._series = _read_series(self.path / "series.csv", self._text("series.csv"))
        return self._series

    @property
    def summary(self) -> dict[str, Any]:
        """summary.json: means, extremes, energy, warnings; units stand in the keys."""
        if self._summary is None:
            try:
                self._summary = json.loads(self._text("summary.json"))
            except ValueError as error:
                raise SubsoilError(f"{self.path / 'summary.json'}: is no JSON: {error}") from error
        return self._summary

    @property
    def frames(self) -> Frames:
        """The frames of run.h5; an empty sequence where the run wrote none."""
        if self._frames is None:
            self._frames = Frames(self.path / "run.h5")
        return self._frames

    @property
    def states(self) -> list[pathlib.Path]:
        """States to start again from (`--from`), in order of time."""
        return sorted(self.path.glob("state-*.h5"), key=lambda p: float(p.stem.split("-", 1)[1]))

    def _text(self, name: str) -> str:
        try:
            return (self.path / name).read_text(encoding="utf-8")
        except FileNotFoundError:
            why = "is missing"
            if name == "summary.json":
                why = (f"is missing: the run goes on, or was killed; series and frames can be read as far as they "
                       f"go, `subsoil resume {self.path}` goes on")
            raise SubsoilError(f"{self.path / name}: {why}") from None
        except (OSError, UnicodeDecodeError) as error:
            raise SubsoilError(f"{self.path / name}: cannot be read: {error}") from error


def _read_series(path: pathlib.Path, text: str) -> pd.DataFrame:
    text = text.split("\0", 1)[0]  # a cut of the power loses the rest of a block
    head, *rows = text.split("\n")[:-1] or [""]  # behind the last line end: a row cut short, or nothing
    labels = [re.fullmatch(r"\s*(.*?)\s*(?:\[([^\[\]]*)\])?\s*", label) for label in next(csv.reader([head]), [])]
    if not labels:
        raise SubsoilError(f"{path}: has no line of names: the run was killed before its first row")
    names = [label[1] for label in labels if label]
    values = np.empty((0, len(names)))
    if rows:
        try:
            values = np.loadtxt(io.StringIO("\n".join(rows)), delimiter=",", ndmin=2)
        except ValueError as error:
            raise SubsoilError(f"{path}: {error}") from error
    if values.shape[1] != len(names):
        raise SubsoilError(f"{path}: {values.shape[1]} fields under {len(names)} names")
    series = pd.DataFrame(values, columns=names, copy=False)
    series.attrs["units"] = {label[1]: label[2] or "" for label in labels if label}
    return series


def open(directory: PathLike) -> Run:
    """Opens the folder of a run. Raises SubsoilError where there is none.

    A run that goes on, was killed or stopped opens too: `run.complete` says so, and what is missing says so when it is
    asked for.
    """
    path = pathlib.Path(directory)
    if path.is_file():
        raise SubsoilError(f"{path}: is a file; name the folder of the run, {path.parent}")
    if not path.is_dir():
        raise SubsoilError(f"{path}: there is no such folder; name the result folder of a run")
    if not any((path / name).exists() for name in _RESULTS):
        raise SubsoilError(f"{path}: holds none of {', '.join(_RESULTS)}; name the result folder of a run")
    return Run(path)


class _Dumper(yaml.SafeDumper):
    """Plain YAML of dicts with NumPy numbers and paths in them; nothing is an alias."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


_Dumper.add_multi_representer(np.generic, lambda dumper, value: dumper.represent_data(value.item()))
_Dumper.add_multi_representer(np.ndarray, lambda dumper, value: dumper.represent_data(value.tolist()))
_Dumper.add_multi_representer(pathlib.PurePath, lambda dumper, value: dumper.represent_str(str(value)))
_Dumper.add_multi_representer(tuple, lambda dumper, value: dumper.represent_list(value))


def _program(given: Optional[PathLike]) -> str:
    """What was given, else $SUBSOIL, the one built or installed beside this file, or that of PATH."""
    if given is not None:
        return str(given)
    here = pathlib.Path(__file__).resolve().parent
    built, installed = here / "../../build/release/apps/subsoil", here / "../../../../bin/subsoil"
    for one in (os.environ.get("SUBSOIL"), built, installed, shutil.which("subsoil")):
        if one and os.access(one, os.X_OK) and os.path.isfile(one):
            return str(one)
    raise SubsoilError("there is no program subsoil: build it, put it into PATH, or give program=")


def _call(command: list[str]) -> tuple[int, str]:
    """Exit code and what it said. A KeyboardInterrupt lets the program write its last frame, state and summary."""
    try:
        child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    except OSError as error:
        raise SubsoilError(f"{command[0]}: cannot be started: {error}") from error
    try:
        out, err = child.communicate()
    except BaseException:
        child.send_signal(signal.SIGINT)
        child.communicate()
        raise
    return child.returncode, err.strip() or out.strip()


def run(scenario: Union[Mapping[str, Any], PathLike], out: Optional[PathLike] = None, *, sets: Iterable[str] = (),
        threads: Optional[int] = None, force: bool = False, options: Iterable[str] = (),
        program: Optional[PathLike] = None) -> Run:
    """Runs a scenario to its end and opens what it left.

    scenario: a file, or a dict of what stands in one; paths in a dict are taken from the working directory
    out: folder for the results; left out: ./<name of the scenario file>. A dict needs one
    sets: values of the scenario said otherwise, "time.end=0.1s"
    threads: of the bed; left out: as the scenario says, else all cores
    force: write over a folder with something in it
    options: further ones of `subsoil run`, ["--strict", "--from", "mine/state-0.1.h5"]
    program: left out: $SUBSOIL, the one built or installed beside this file, or that of PATH

    Raises SubsoilError with the program's own message and exit_code; where results were written (3, 130, 143) its `run`
    opens them.
    """
    if isinstance(scenario, Mapping):
        if out is None:
            raise SubsoilError("a scenario that is a dict has no name: say where its results go, out=")
        text = yaml.dump(dict(scenario), Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=1000)
        with tempfile.NamedTemporaryFile("w", suffix=".yaml", prefix=".subsoil-", dir=".", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            return _run_file(file.name, "<dict>", out, sets, threads, force, options, program)
    path = str(pathlib.Path(scenario))
    return _run_file(path, path, out or pathlib.Path(path).stem, sets, threads, force, options, program)


def _run_file(path: str, shown: str, out: PathLike, sets: Iterable[str], threads: Optional[int], force: bool,
              options: Iterable[str], program: Optional[PathLike]) -> Run:
    command = [_program(program), "run", path, "--out", str(out)]
    for one in sets:
        command += ["--set", one]
    command += ["--threads", str(threads)] if threads is not None else []
    command += ["--force"] if force else []
    code, said = _call([*command, *options])
    if code == 0:
        return open(out)
    left = Run(pathlib.Path(out)) if code in (3, 130, 143) and pathlib.Path(out).is_dir() else None
    if shown != path:
        said = re.sub(r"[^\s'\"]*" + re.escape(pathlib.Path(path).name), shown, said)
    what = _CODES.get(code, f"killed by signal {-code}" if code < 0 else "unknown to this module")
    raise SubsoilError(f"{said or 'the program said nothing'}\n(exit code {code}: {what})", code, left)


_STEPPED = ("Simulation", "State", "available_inputs", "check")
_BUILT = pathlib.Path(__file__).resolve().parent / "../../build/release/python/subsoil"
if _BUILT.is_dir():  # of this tree: the compiled part is there
    __path__.append(str(_BUILT))


def __getattr__(name: str) -> Any:
    """What needs the compiled part is loaded when it is asked for: results can be read without it."""
    if name in _STEPPED:
        from . import simulation
        return getattr(simulation, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


if TYPE_CHECKING:
    from .simulation import Simulation, State, available_inputs, check
