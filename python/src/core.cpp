#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "libsim/base/memory.hpp"
#include "libsim/base/problems.hpp"
#include "libsim/run/simulation.hpp"

/// subsoil._core: sim::Simulation for Python.
///
/// Steps release the GIL; what Python is called for takes it back. While a thread steps, others are refused: the phase
/// of a simulation changes under the GIL only, so that no lock is needed.
namespace nb = nanobind;
using namespace nb::literals;
using subsoil::dem::Sphere;
using subsoil::sim::ScenarioError;
using subsoil::sim::SimulationFault;
using SteppedSimulation = subsoil::sim::Simulation;

namespace {

using Three = std::array<double, 3>;
using Four = std::array<double, 4>;

subsoil::dem::Vec3 vec(const Three& v) { return {v[0], v[1], v[2]}; }
Three three(const subsoil::dem::Vec3& v) { return {v.x, v.y, v.z}; }

template <std::size_t n>
using SmallArray = nb::ndarray<nb::numpy, double, nb::shape<static_cast<nb::ssize_t>(n)>>;

/// A new array of these numbers.
template <std::size_t n>
SmallArray<n> array(const std::array<double, n>& values) {
  auto kept = std::make_unique<std::array<double, n>>(values);
  double* const data = kept->data();
  const nb::capsule owner(kept.get(), [](void* p) noexcept { delete static_cast<std::array<double, n>*>(p); });
  kept.release();
  return SmallArray<n>(data, {n}, owner);
}

class Simulation {
 public:
  enum class Phase { idle, stepping, observing };

  Simulation(const std::function<SteppedSimulation()>& make) : stepped_(make()) {
    stepped_.observe(0, [this](SteppedSimulation&) { return listen_to_signals(); });
  }

  /// Refuses a call of another thread while this simulation is stepped.
  const SteppedSimulation& now() const {
    if (phase_ == Phase::stepping)
      throw std::runtime_error(
          "simulation: another thread steps it; wait for that thread, or read what is needed in an observer");
    return stepped_;
  }
  SteppedSimulation& now() { return const_cast<SteppedSimulation&>(std::as_const(*this).now()); }
  /// Refuses a call of an observer too.
  SteppedSimulation& between_steps(const char* what) {
    if (phase_ == Phase::observing)
      throw std::runtime_error(std::string(what) +
                               ": an observer cannot call it; return False there, which ends the present call");
    return now();
  }

  bool advance(const std::function<bool(SteppedSimulation&)>& steps, const char* what) {
    SteppedSimulation& simulation = between_steps(what);
    const InPhase stepping(*this, Phase::stepping);
    const nb::gil_scoped_release release;
    return steps(simulation);
  }

  int observe(nb::handle self, nb::object call, double every) {
    if (!PyCallable_Check(call.ptr()))
      throw nb::type_error("observer: must be callable with the simulation as argument");
    const auto key = std::make_shared<int>(0);
    *key = now().observe(every, [this, self, key](SteppedSimulation&) {
      const nb::gil_scoped_acquire gil;
      const InPhase observing(*this, Phase::observing);
      const nb::object call = calls_.at(*key), answer = call(self);
      return !answer.is(nb::handle(Py_False));
    });
    calls_.emplace(*key, std::move(call));
    return *key;
  }
  void stop_observing(int number) {
    if (calls_.find(number) == calls_.end())
      throw nb::value_error(
          ("observer " + std::to_string(number) + ": there is none; observe() returns the number").c_str());
    now().stop_observing(number);
    const nb::object last = std::move(calls_.at(number));  // its end may run code of its own
    calls_.erase(number);
  }

  /// For Python's collector of cycles: observers often hold the simulation.
  static int traverse(PyObject* self, visitproc visit, void* arg) {
    Py_VISIT(Py_TYPE(self));
    if (!nb::inst_ready(self)) return 0;
    for (const auto& [number, call] : nb::inst_ptr<Simulation>(self)->calls_) Py_VISIT(call.ptr());
    return 0;
  }
  static int clear(PyObject* self) {
    if (!nb::inst_ready(self)) return 0;
    auto* const simulation = nb::inst_ptr<Simulation>(self);
    for (const auto& [number, call] : simulation->calls_) simulation->stepped_.stop_observing(number);
    const auto calls = std::exchange(simulation->calls_, {});
    return 0;
  }

 private:
  struct InPhase {
    InPhase(Simulation& of, Phase phase) : simulation(of), before(std::exchange(of.phase_, phase)) {}
    ~InPhase() { simulation.phase_ = before; }
    InPhase(const InPhase&) = delete;
    InPhase& operator=(const InPhase&) = delete;
    Simulation& simulation;
    Phase before;
  };

  /// Ctrl-C ends a long call: asked for every 50 ms, since each time waits for the GIL.
  bool listen_to_signals() {
    using Clock = std::chrono::steady_clock;
    if (Clock::now() < next_look_) return true;
    next_look_ = Clock::now() + std::chrono::milliseconds(50);
    const nb::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    return true;
  }

  SteppedSimulation stepped_;
  std::map<int, nb::object> calls_;  ///< observers of Python by their number
  Phase phase_ = Phase::idle;
  std::chrono::steady_clock::time_point next_look_{};
};

template <class T, std::size_t columns>
using SphereArray =
    std::conditional_t<columns == 1, nb::ndarray<nb::numpy, const T, nb::shape<-1>>,
                       nb::ndarray<nb::numpy, const T, nb::shape<-1, static_cast<nb::ssize_t>(columns)>>>;

/// A field of all spheres on the engine's memory, which the array keeps.
template <class T, std::size_t columns>
SphereArray<T, columns> field(Simulation& simulation, std::size_t offset) {
  static_assert(sizeof(Sphere) % sizeof(T) == 0);
  using Pointer = decltype(simulation.now().held_spheres());
  auto held = std::make_unique<Pointer>(simulation.now().held_spheres());
  const auto spheres = **held;
  static const Sphere none{};
  const auto* const base = reinterpret_cast<const std::byte*>(spheres.empty() ? &none : spheres.data()) + offset;
  const nb::capsule owner(held.get(), [](void* p) noexcept { delete static_cast<Pointer*>(p); });
  held.release();
  const std::size_t shape[2] = {spheres.size(), columns};
  const std::int64_t strides[2] = {static_cast<std::int64_t>(sizeof(Sphere) / sizeof(T)), 1};
  return SphereArray<T, columns>(reinterpret_cast<const T*>(base), columns > 1 ? 2 : 1, shape, owner, strides);
}

/// Raises an exception of the package, which has the classes: they are also those of results and of the program.
void raise_of_package(const char* type, const char* text, const nb::object& detail) {
  try {
    const nb::object of_type = nb::module_::import_("subsoil").attr(type);
    PyErr_SetObject(of_type.ptr(), of_type(text, detail).ptr());
  } catch (nb::python_error& error) {
    error.restore();
  }
}

void translate(const std::exception_ptr& thrown, void*) {
  try {
    std::rethrow_exception(thrown);
  } catch (const ScenarioError& error) {
    raise_of_package("ScenarioError", error.what(), nb::cast(error.lines));
  } catch (const SimulationFault& error) {
    raise_of_package("SimulationFault", error.what(), nb::cast(error.time));
  }
}

/// A borrowed reference: copies are made without the GIL. The caller's argument outlives them.
std::function<bool(double, double)> settling_of(nb::handle call) {
  return [call](double time, double rms_speed) {
    const nb::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    return call.is_none() || !call(time, rms_speed).is(nb::handle(Py_False));
  };
}

void make(Simulation* self, const std::string& text, const std::string& name, bool is_file,
          std::vector<std::string> sets, int threads, std::vector<std::string> inputs,
          std::vector<std::string> forces_on, bool energies, const std::string& start, bool settle,
          const nb::object& settling) {
  const subsoil::sim::SimulationOptions options{.sets = std::move(sets),
                                                .threads = threads,
                                                .inputs = std::move(inputs),
                                                .forces_on = std::move(forces_on),
                                                .energies = energies,
                                                .start = start,
                                                .settle = settle,
                                                .settling = settling_of(settling)};
  const nb::gil_scoped_release release;
  try {
    new (self) Simulation([&] {
      return is_file ? SteppedSimulation::from_file(name, options) : SteppedSimulation::from_text(text, name, options);
    });
  } catch (const ScenarioError&) {
    throw;
  } catch (const nb::python_error&) {
    throw;
  } catch (const std::exception& error) {  // as the program: a bed that cannot be prepared is a failed run
    throw SimulationFault(name + ": " + error.what(), 0);
  }
}

void bind_state(nb::module_& m) {
  using State = SteppedSimulation::State;
  nb::class_<State>(m, "State", "Full state of a simulation, in memory.")
      .def_prop_ro("time", &State::time, "Instant of the state, s.")
      .def_prop_ro("is_exact", &State::is_exact,
                   "Whether a simulation continues from it with the same bits; not near a singular configuration.")
      .def(
          "to_bytes",
          [](const State& state) {
            const auto bytes = state.bytes();
            return nb::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
          },
          "The state as bytes: a HDF5 file that `subsoil run --from` and from_bytes() of the same version read.")
      .def_static(
          "from_bytes",
          [](const nb::bytes& data) {
            return State::from_bytes({static_cast<const std::byte*>(data.data()), data.size()});
          },
          "data"_a, "The state that to_bytes() gave.");
}

using Class = nb::class_<Simulation>;

void bind_time(Class& c) {
  c.def("__init__", &make, "text"_a, "name"_a, "is_file"_a, "sets"_a, "threads"_a, "inputs"_a, "forces_on"_a,
        "energies"_a, "start"_a, "settle"_a, nb::arg("settling").none() = nb::none());
  c.def_static("available_inputs", &SteppedSimulation::available_inputs, "text"_a, "name"_a,
               "sets"_a = std::vector<std::string>{}, "Functions of time that `inputs` may name.");
  c.def_prop_ro(
      "time", [](const Simulation& s) { return s.now().time(); }, "Time that the simulation has reached, s.");
  c.def_prop_ro(
      "end", [](const Simulation& s) { return s.now().end(); },
      "`time.end` of the scenario, s. No step ends there by itself.");
  c.def_prop_ro(
      "step_length", [](const Simulation& s) { return s.now().step_length(); },
      "Step of the soil, s; of a machine alone its longest step.");
  c.def_prop_ro(
      "steps", [](const Simulation& s) { return s.now().steps(); }, "Number of steps taken.");
  c.def(
      "step", [](Simulation& s, long count) { return s.advance([=](auto& at) { return at.step(count); }, "step"); },
      "count"_a = 1,
      "Takes `count` steps. Returns False where an observer ended the call, True else. Other threads of Python run "
      "meanwhile.");
  c.def(
      "run_until",
      [](Simulation& s, double t) { return s.advance([=](auto& at) { return at.run_until(t); }, "run_until"); }, "t"_a,
      "Steps to the first end of a step at or after t, s; a machine alone with steps by their error ends at t. Returns "
      "as step().");
  c.def(
      "observe",
      [](nb::handle self, nb::object call, double every) {
        return nb::cast<Simulation&>(self).observe(self, std::move(call), every);
      },
      "call"_a, "every"_a = 0.0,
      "Calls call(simulation) at the first step that begins at or after each multiple of `every`, s, from now on; 0: "
      "at every "
      "step. What it sets acts in that step. Where it returns False the call of step() or run_until() ends. Its "
      "exceptions "
      "leave that call. Returns a number for stop_observing().",
      nb::sig("def observe(self, call: collections.abc.Callable[[Simulation], object], every: float = 0.0) -> int"));
  c.def("stop_observing", &Simulation::stop_observing, "number"_a, "Ends what observe() started.");
  c.def(
      "save", [](Simulation& s) { return s.now().save(); }, "The full state, in memory.");
  c.def(
      "restore",
      [](Simulation& s, const SteppedSimulation::State& state) { s.between_steps("restore").restore(state); },
      "state"_a, "Puts a state of the same scenario in place.");
}

void bind_bed(Class& c) {
  c.def_prop_ro(
      "has_bed", [](const Simulation& s) { return s.now().has_bed(); }, "Whether there is a bed of spheres.");
  c.def_prop_ro(
      "position", [](Simulation& s) { return field<double, 3>(s, offsetof(Sphere, x)); },
      "Centres at `time`, (n, 3) m, world axes.", nb::rv_policy::automatic);
  c.def_prop_ro(
      "velocity", [](Simulation& s) { return field<double, 3>(s, offsetof(Sphere, v)); },
      "Velocities half a step before `time` (leapfrog), (n, 3) m/s, world axes.", nb::rv_policy::automatic);
  c.def_prop_ro(
      "angular_velocity", [](Simulation& s) { return field<double, 3>(s, offsetof(Sphere, w)); },
      "Angular velocities half a step before `time`, (n, 3) rad/s, world axes.", nb::rv_policy::automatic);
  c.def_prop_ro(
      "radius", [](Simulation& s) { return field<double, 1>(s, offsetof(Sphere, r)); }, "Radii, (n,) m.",
      nb::rv_policy::automatic);
  c.def_prop_ro(
      "id", [](Simulation& s) { return field<std::uint32_t, 1>(s, offsetof(Sphere, id)); },
      "Numbers that spheres keep for life, (n,).", nb::rv_policy::automatic);
  c.def_prop_ro(
      "material", [](Simulation& s) { return field<std::uint16_t, 1>(s, offsetof(Sphere, material)); },
      "Index of the material, (n,).", nb::rv_policy::automatic);
}

void bind_scenario(Class& c) {
  c.def_prop_ro(
      "scenario", [](const Simulation& s) { return s.now().scenario_text(); },
      "The scenario with every default explicit, YAML.");
  c.def(
      "warnings", [](const Simulation& s) { return s.now().warnings(); }, "What `subsoil check` warns of.");
}

void bind_surfaces(Class& c) {
  c.def_prop_ro(
      "surfaces",
      [](const Simulation& s) {
        std::vector<std::string> names;
        for (const auto& surface : s.now().surfaces()) names.push_back(surface.name);
        return names;
      },
      "Names of all surfaces: walls of the container, boundaries, surfaces of the machine.");
  c.def(
      "pose",
      [](const Simulation& s, const std::string& surface) {
        const auto p = s.now().pose(surface);
        const auto& q = p.attitude;
        return std::make_pair(array(three(p.position)), array(Four{q.w, q.x, q.y, q.z}));
      },
      "surface"_a,
      "Pose of a surface at `time`: origin of its axes in the world, (3,) m, and attitude as a unit quaternion w x y "
      "z, (4,).");
  c.def(
      "wrench",
      [](const Simulation& s, const std::string& surface, const Three& about, bool mean) {
        const auto& at = s.now();
        const auto w = mean ? at.mean_wrench(surface, vec(about)) : at.wrench(surface, vec(about));
        return std::make_pair(array(three(w.force)), array(three(w.moment)));
      },
      "surface"_a, "about"_a = Three{0, 0, 0}, "mean"_a = true,
      "Wrench of the spheres on a surface, world axes: force, (3,) N, and moment about the world point `about`, (3,) N "
      "m. Mean "
      "over the steps of the last call of step() or run_until(); mean=False: at the start of the last step.");
  c.def(
      "set_motion",
      [](Simulation& s, const std::string& surface, const Three& position, const Four& attitude, const Three& velocity,
         const Three& angular_velocity) {
        s.now().set_motion(surface, {.position = vec(position),
                                     .attitude = {attitude[0], attitude[1], attitude[2], attitude[3]},
                                     .velocity = vec(velocity),
                                     .angular_velocity = vec(angular_velocity)});
      },
      "surface"_a, "position"_a, "attitude"_a = Four{1, 0, 0, 0}, "velocity"_a = Three{0, 0, 0},
      "angular_velocity"_a = Three{0, 0, 0},
      "Moves a boundary of the scenario from now on at constant velocity: position of the origin of its axes, (3,) m, "
      "attitude "
      "as a quaternion w x y z, velocity, (3,) m/s, angular velocity, (3,) rad/s; world axes. A pose other than the "
      "present one "
      "is reached within the next step.");
}

void bind_machine(Class& c) {
  c.def_prop_ro(
      "has_machine", [](const Simulation& s) { return s.now().has_machine(); }, "Whether there is a machine.");
  c.def_prop_ro(
      "bodies", [](const Simulation& s) { return s.now().bodies(); }, "Names of the machine's bodies.");
  c.def(
      "body",
      [](const Simulation& s, const std::string& name) {
        const auto b = s.now().body(name);
        return std::make_pair(array(Three{b.r.x, b.r.y, b.angle}), array(Three{b.v.x, b.v.y, b.omega}));
      },
      "name"_a,
      "Pose of a body's centre of mass at `time`, x m, y m, angle rad, and its rate, m/s, m/s, rad/s; (3,) each.");
  c.def_prop_ro(
      "inputs",
      [](const Simulation& s) {
        nb::dict out;
        for (const auto& i : s.now().inputs()) out[i.name.c_str()] = nb::make_tuple(i.value, i.unit);
        return out;
      },
      "Inputs by name: value now and unit.", nb::sig("def inputs(self) -> dict[str, tuple[float, str]]"));
  c.def(
      "set_input",
      [](Simulation& s, const std::string& name, double value, double rate) { s.now().set_input(name, value, rate); },
      "name"_a, "value"_a, "rate"_a = 0.0, "An input is value + rate (t - now) from now on, in the unit of `inputs`.");
  c.def(
      "set_force",
      [](Simulation& s, const std::string& body, double fx, double fy, double moment) {
        s.now().set_force(body, fx, fy, moment);
      },
      "body"_a, "fx"_a, "fy"_a, "moment"_a = 0.0,
      "Force, N, and moment, N m, on a body's centre of mass from now on, world axes. `forces_on` names the body.");
}

void bind_columns(Class& c) {
  c.def_prop_ro(
      "columns",
      [](const Simulation& s) {
        nb::dict out;
        for (const auto& column : s.now().columns()) out[column.name.c_str()] = column.unit;
        return out;
      },
      "Columns of series.csv by name: unit.", nb::sig("def columns(self) -> dict[str, str]"));
  c.def(
      "value", [](const Simulation& s, const std::string& column) { return s.now().value(column); }, "column"_a,
      "Value of a column in the last step of the last call. Positions are those of its start, forces those over it. "
      "Sums over "
      "all spheres need energies=True and are NaN else.");
  c.def(
      "values",
      [](const Simulation& s) {
        nb::dict out;
        const auto values = s.now().values();
        for (std::size_t k = 0; k < values.size(); ++k) out[s.now().columns()[k].name.c_str()] = values[k];
        return out;
      },
      "Values of all columns by name, as value().", nb::sig("def values(self) -> dict[str, float]"));
}

}  // namespace

NB_MODULE(_core, m) {
  subsoil::sim::recycle_arrays();
  m.doc() =
      "Compiled part of subsoil: a scenario that is stepped in this process. SI units; x along travel, y up, z across.";
  nb::register_exception_translator(translate);
  bind_state(m);
  PyType_Slot slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(Simulation::traverse)},
                         {Py_tp_clear, reinterpret_cast<void*>(Simulation::clear)},
                         {0, nullptr}};
  Class c(m, "Simulation", nb::type_slots(slots), "A scenario that is stepped in this process.");
  bind_time(c);
  bind_scenario(c);
  bind_bed(c);
  bind_surfaces(c);
  bind_machine(c);
  bind_columns(c);
}
