"""A co-simulation importer of FMUs of FMI 2.0 and 3.0 for Linux x86-64, on Python's standard library alone.

    with Fmu("soil.fmu") as fmu:
        soil = fmu.instance({"tools.plate.point.y": -0.01})
        soil.set({"tools.plate.velocity.y": -0.1})
        soil.step(1e-3)
        force = soil["tools.plate.force.y"]

All variables are scalars of type Float64 (Real). A call that the FMU refuses raises FmiError with what it logged.
"""
import ctypes
import pathlib
import shutil
import tempfile
import xml.etree.ElementTree as ElementTree
import zipfile

SIZE, REAL, REFERENCE = ctypes.c_size_t, ctypes.c_double, ctypes.c_uint32
WARNING, ERROR = 1, 3  # of fmi2Status and fmi3Status: OK, Warning, Discard, Error, Fatal


class FmiError(Exception):
    pass


class Fmu:
    """An unpacked FMU: its variables, and instances of it."""

    def __init__(self, file):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="fmu-"))
        with zipfile.ZipFile(file) as archive:
            archive.extractall(self.folder)
        self.description = ElementTree.parse(self.folder / "modelDescription.xml").getroot()
        self.three = self.description.get("fmiVersion").startswith("3")
        variables = self.description.find("ModelVariables")
        self.variables = {v.get("name"): v for v in variables}
        self.references = {name: int(v.get("valueReference")) for name, v in self.variables.items()}
        co_simulation = self.description.find("CoSimulation")
        name = co_simulation.get("modelIdentifier") + ".so"
        self.path = self.folder / "binaries" / ("x86_64-linux" if self.three else "linux64") / name
        self.library = ctypes.CDLL(str(self.path))

    def start(self, name):
        """Start value of an input or a parameter."""
        of = self.variables[name] if self.three else self.variables[name].find("Real")
        return float(of.get("start"))

    def instance(self, parameters=None, start=0.0, logging=False, stop=None):
        """One that is initialized."""
        out = Instance(self, logging=logging)
        out.initialize(parameters or {}, start, stop)
        return out

    def close(self):
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class Instance:
    """update(time), of FMI 3.0, is called within a step, where outputs may be read; True ends the step there."""

    def __init__(self, fmu, token=None, resources=None, logging=False, update=None):
        self.fmu, self.time, self.handle = fmu, 0.0, None
        self.messages = []  # (status, text), as the FMU logs them
        token = token or fmu.description.get("instantiationToken" if fmu.three else "guid")
        folder = pathlib.Path(resources or fmu.folder / "resources")
        if fmu.three:
            make = fmu.library.fmi3InstantiateCoSimulation
            kind = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p)
            self.logger = kind(lambda _, status, __, text: self.messages.append((status, text.decode())))
            within = ctypes.CFUNCTYPE(None, ctypes.c_void_p, REAL, *[ctypes.c_bool] * 4, ctypes.POINTER(ctypes.c_bool),
                                      ctypes.POINTER(REAL))

            def updated(_, time, __, ___, ____, _____, asks_return, until):
                asks_return[0], until[0] = bool(update(time)), time
            self.update = within(updated) if update else within()
            make.argtypes = [ctypes.c_char_p] * 3 + [ctypes.c_bool] * 4 + [ctypes.c_void_p, SIZE, ctypes.c_void_p, kind,
                                                                          within]
            given = [b"one", token.encode(), (str(folder) + "/").encode(), False, logging, False, update is not None, None, 0,
                     None, self.logger, self.update]
        else:
            make = fmu.library.fmi2Instantiate
            kind = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p,
                                    ctypes.c_char_p, ctypes.c_char_p)  # the format is "%s"
            self.logger = kind(lambda _, __, status, ___, ____, text: self.messages.append((status, text.decode())))
            self.callbacks = (ctypes.c_void_p * 5)(ctypes.cast(self.logger, ctypes.c_void_p), None, None, None, None)
            make.argtypes = [ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_void_p, ctypes.c_int,
                             ctypes.c_int]
            given = [b"one", 1, token.encode(), folder.as_uri().encode(), self.callbacks, 0, int(logging)]
        make.restype = ctypes.c_void_p
        self.handle = make(*given)
        if not self.handle:
            self.fail("instantiate")

    def fail(self, name):
        raise FmiError(f"{name}: " + "; ".join(text for status, text in self.messages if status >= ERROR))

    def call(self, name, *given):
        """fmi2Name or fmi3Name."""
        name = ("fmi3" if self.fmu.three else "fmi2") + name
        status = getattr(self.fmu.library, name)(ctypes.c_void_p(self.handle), *given)
        if status > WARNING:
            self.fail(name)

    def initialize(self, parameters, start=0.0, stop=None):
        """stop: no step may end later."""
        self.time = start
        stops, stop = stop is not None, REAL(stop or 0)
        if not self.fmu.three:
            self.call("SetupExperiment", 0, REAL(0), REAL(start), int(stops), stop)
        self.set(parameters)
        if self.fmu.three:
            self.call("EnterInitializationMode", ctypes.c_bool(False), REAL(0), REAL(start), ctypes.c_bool(stops), stop)
        else:
            self.call("EnterInitializationMode")
        self.call("ExitInitializationMode")

    def exchange(self, name, references, values):
        count = len(references)
        numbers, data = (REFERENCE * count)(*references), (REAL * count)(*values)
        self.call(name + ("Float64" if self.fmu.three else "Real"), numbers, SIZE(count), data,
                  *([SIZE(count)] if self.fmu.three else []))
        return list(data)

    def set(self, values):
        self.exchange("Set", [self.fmu.references[name] for name in values], values.values())

    def get(self, *names):
        return self.exchange("Get", [self.fmu.references[name] for name in names], [0.0] * len(names))

    def __getitem__(self, name):
        return self.get(name)[0]

    def step(self, length):
        if self.fmu.three:
            flags, reached = (ctypes.c_bool * 3)(), REAL()
            at = [ctypes.byref(flags, k) for k in range(3)]
            self.call("DoStep", REAL(self.time), REAL(length), ctypes.c_bool(False), *at, ctypes.byref(reached))
            self.time = reached.value
        else:
            self.call("DoStep", REAL(self.time), REAL(length), 0)
            self.time += length

    def state(self, action):
        return action + ("FMUState" if self.fmu.three else "FMUstate")

    def save(self):
        state = ctypes.c_void_p()
        self.call(self.state("Get"), ctypes.byref(state))
        return state, self.time

    def restore(self, saved):
        self.call(self.state("Set"), saved[0])
        self.time = saved[1]

    def free(self, saved):
        self.call(self.state("Free"), ctypes.byref(saved[0]))

    def bytes_of(self, saved):
        size = SIZE()
        self.call(self.state("Serialized") + "Size", saved[0], ctypes.byref(size))
        out = (ctypes.c_uint8 * size.value)()
        self.call(self.state("Serialize"), saved[0], out, size)
        return bytes(out)

    def state_of(self, data, time):
        state = ctypes.c_void_p()
        name = "DeserializeFMUState" if self.fmu.three else "DeSerializeFMUstate"
        self.call(name, (ctypes.c_uint8 * len(data)).from_buffer_copy(data), SIZE(len(data)), ctypes.byref(state))
        return state, time

    def reset(self):
        self.call("Reset")

    def close(self):
        if self.handle:
            self.call("Terminate")
            free = self.fmu.library.fmi3FreeInstance if self.fmu.three else self.fmu.library.fmi2FreeInstance
            free.restype = None
            free(ctypes.c_void_p(self.handle))
            self.handle = None
