"""A scenario that is stepped in this process: see docs/reference/python.md."""
from __future__ import annotations

import os
import pathlib
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Optional, Union

import yaml

from . import SubsoilError, _Dumper

Scenario = Union[Mapping[str, Any], str, "os.PathLike[str]"]

# OpenMP reads it once, when its library is loaded. Threads that wait in sleep leave the cores to Python: see the program.
_asked = os.environ.get("OMP_WAIT_POLICY")
os.environ.setdefault("OMP_WAIT_POLICY", "passive")
try:
    from . import _core
except ImportError as error:
    raise SubsoilError(f"the compiled part of subsoil cannot be loaded: {error}; build it with "
                       f"`scripts/setup --python` and -DSUBSOIL_PYTHON=ON, or `pip install .`") from error
finally:
    if _asked is None:
        del os.environ["OMP_WAIT_POLICY"]

State = _core.State


def _source(scenario: Scenario) -> tuple[str, str, bool]:
    """Text, name and whether it is a file."""
    if isinstance(scenario, Mapping):
        return yaml.dump(dict(scenario), Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=1000), "<dict>", False
    return "", str(pathlib.Path(scenario)), True


class Simulation(_core.Simulation):
    """A scenario, read, checked, built, its bed at rest. It stands at time 0.

    scenario: a file, or a dict of what stands in one; paths in a dict are relative to the working directory
    sets: values in place of those of the scenario, "time.end=0.1s"
    threads: of the bed; 0: as the scenario has it, else all cores
    inputs: functions of time whose values set_input() sets; available_inputs() lists them
    forces_on: bodies on which set_force() acts
    energies: whether columns that are sums over all spheres are computed at the end of each call
    start: a file with the bytes of a state: the bed is taken from it, also by a scenario with another step or machine
    settle: False leaves the bed as placed
    settling: called with time, s, and root mean square speed, m/s, while the bed settles; False ends that

    Raises ScenarioError for bad input and SimulationFault for a bed that cannot be prepared. Without inputs, motions and
    forces the bits are those of `subsoil run`.

    Arrays of spheres (position, velocity, angular_velocity, radius, id, material) are in the engine's order, which changes
    between steps; rows of arrays that are read at one instant belong together. They are read-only, lie in the engine's
    memory and hold the instant at which they are read: where one is still referenced when a step begins, the memory is
    left to it and the engine continues on a copy.
    """

    def __init__(self, scenario: Scenario, *, sets: Iterable[str] = (), threads: int = 0, inputs: Iterable[str] = (),
                 forces_on: Iterable[str] = (), energies: bool = False,
                 start: Optional[Union[str, "os.PathLike[str]"]] = None, settle: bool = True,
                 settling: Optional[Callable[[float, float], object]] = None):
        text, self._name, is_file = _source(scenario)
        super().__init__(text, self._name, is_file, list(sets), threads, list(inputs), list(forces_on), energies,
                         "" if start is None else str(pathlib.Path(start)), settle, settling)

    def __repr__(self) -> str:
        return f"<simulation of {self._name} at {self.time:g} s>"


def check(scenario: Scenario, sets: Iterable[str] = ()) -> list[str]:
    """Warnings of a scenario; its bed is placed and does not settle. Raises ScenarioError for bad input."""
    return Simulation(scenario, sets=sets, threads=1, settle=False).warnings()


def available_inputs(scenario: Scenario, sets: Iterable[str] = ()) -> list[str]:
    """Names of the functions of time of a scenario that `Simulation(inputs=...)` may name."""
    text, name, is_file = _source(scenario)
    if is_file:
        try:
            text = pathlib.Path(name).read_text(encoding="utf-8")
        except OSError as error:
            raise SubsoilError(f"{name}: cannot be read: {error}; name a scenario file", 2) from error
    return _core.Simulation.available_inputs(text, name, list(sets))
