#include "libsim/run/simulation.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "libdem/base/archive.hpp"
#include "libsim/run/continuation.hpp"
#include "libsim/run/input_report.hpp"
#include "libsim/run/inputs.hpp"
#include "libsim/run/machine_fault.hpp"
#include "libsim/run/motion_search.hpp"
#include "libsim/run/placement_report.hpp"
#include "libsim/run/restart.hpp"
#include "libsim/run/schedule.hpp"
#include "libsim/run/stepper.hpp"
#include "libsim/run/surface_report.hpp"

namespace subsoil::sim {
namespace {

/// A scenario with the files in its folder named by what is behind the folder: it may stand elsewhere.
std::string without_folder(std::string text, const std::filesystem::path& folder) {
  const std::string start = folder.string() + "/";
  for (std::size_t at = text.find(start); at != std::string::npos; at = text.find(start, at))
    text.erase(at, start.size());
  return text;
}

}  // namespace

struct Simulation::State::Impl {
  SavedRun saved;
  dem::Bed::Checkpoint bed;  ///< of a state in memory, whose arrays are filled where someone asks for them

  /// With the arrays. Others may ask at the same time.
  const SavedRun& complete() const {
    std::call_once(filled_, [this] {
      if (saved.has_bed && saved.bed.spheres.empty() && of_checkpoint) const_cast<SavedRun&>(saved).bed = bed.state();
    });
    return saved;
  }
  bool of_checkpoint = false;

 private:
  mutable std::once_flag filled_;
};

Simulation::State::State() = default;
Simulation::State::State(const State&) = default;
Simulation::State::State(State&&) noexcept = default;
Simulation::State& Simulation::State::operator=(const State&) = default;
Simulation::State& Simulation::State::operator=(State&&) noexcept = default;
Simulation::State::~State() = default;

struct Simulation::Impl : StepObserver {
  /// Motion of a surface with constant velocities from a time on.
  struct GivenCourse {
    SurfaceMotion motion;
    double from = 0;

    dem::Pose at(double t) const {
      const double s = t - from, rate = dem::norm(motion.angular_velocity), half = 0.5 * rate * s;
      dem::Quaternion turn{1, 0, 0, 0};
      if (rate > 0) {
        const Vec3 axis = motion.angular_velocity * (std::sin(half) / rate);
        turn = {std::cos(half), axis.x, axis.y, axis.z};
      }
      return {motion.position + motion.velocity * s, turn * motion.attitude};
    }
    void archive(Archive& a) {
      a("position", motion.position)("attitude", motion.attitude)("velocity", motion.velocity);
      a("angular velocity", motion.angular_velocity)("from", from);
    }
  };

  struct Observing {
    int number = 0;
    Schedule due;
    bool always = false;
    std::function<bool(Simulation&)> call;
  };

  Impl(Loaded given, const SimulationOptions& options, Inputs prepared, std::string file_name,
       std::optional<std::string> file_text, const SavedRun* start)
      : loaded(std::move(given)),
        inputs(std::move(prepared)),
        sets(options.sets),
        file(std::move(file_name)),
        source(std::move(file_text)),
        energies(options.energies),
        stepper(loaded, build(loaded, options, start), start) {
    text = write_scenario(loaded.scenario);
    identity = without_folder(text, std::filesystem::weakly_canonical(std::filesystem::absolute(file)).parent_path());
    const World& world = stepper.world();
    for (const SurfaceRecord& s : world.surfaces) {
      const bool of_machine = s.owner == SurfaceRecord::Owner::machine;
      surface_of[s.name] = surfaces.size();
      surfaces.push_back({s.name,
                          of_machine                                   ? SurfaceInfo::Owner::machine
                          : s.owner == SurfaceRecord::Owner::container ? SurfaceInfo::Owner::container
                                                                       : SurfaceInfo::Owner::given,
                          of_machine ? world.machine->system().body_name(s.body) : ""});
    }
    sums.resize(surfaces.size());
    const auto& list = stepper.columns().list();
    for (std::size_t c = 0; c < list.size(); ++c)
      columns.push_back({list[c].name, list[c].unit, stepper.columns().is_sum(c)});
    forget_values();
    if (stepper.is_exact() && stepper.columns().has_history())
      search.emplace(*stepper.world().machine, stepper.columns(), nullptr, nullptr);
  }

  static World build(const Loaded& loaded, const SimulationOptions& options, const SavedRun* start) {
    if (options.threads < 0 || options.threads > 1024)
      throw ScenarioError(
          fmt::format("threads = {}: must be in [0, 1024]; 0: as the scenario has it", options.threads));
    BuildOptions build;
    build.threads = use_threads(loaded, options.threads);
    build.settle = options.settle;
    build.progress = options.settling;
    build.place_soil = start == nullptr;
    if (start != nullptr) build.restored = spheres_of(*start), build.moving = start->moving.get();
    World world = build_world(loaded, build);
    add_sphere_forces(world, loaded, options.sphere_forces);
    return world;
  }

  static std::unique_ptr<Impl> make(Loaded loaded, const SimulationOptions& options, const std::string& file,
                                    std::optional<std::string> source = {}) {
    if (!loaded.scenario.runs_in_time())
      throw ScenarioError(loaded.where("analysis") +
                          ": is no simulation in time, which alone is stepped in process; use the program");
    if (loaded.scenario.engine != SoilEngine::subsoil)
      throw ScenarioError(loaded.where("engine") +
                          ": only the bed's own engine is stepped in process; leave `engine` out");
    Inputs inputs;
    inputs.replace(loaded, options.inputs);
    for (const std::string& body : options.forces_on) inputs.add_force_on(loaded, body);
    const auto start = options.start.empty() ? std::nullopt : std::optional(read_run(options.start));
    if (start) refuse_other_bed(differences(start->scenario, write_scenario(loaded.scenario)), options.start.string());
    return std::make_unique<Impl>(std::move(loaded), options, std::move(inputs), file, std::move(source),
                                  start ? &*start : nullptr);
  }

  /// Spheres that someone outside reads.
  struct Held {
    std::span<const dem::Sphere> spheres;
    std::shared_ptr<const void> memory{};  ///< once the bed has left it
  };
  /// Before the spheres change.
  void leave_held() {
    if (const auto reader = held.lock()) reader->memory = stepper.world().bed->release_spheres();
    held.reset();
  }

  /// An observer is being called, also where it throws.
  struct Calling {
    explicit Calling(bool& flag) : flag_(flag) { flag_ = true; }
    ~Calling() { flag_ = false; }
    Calling(const Calling&) = delete;
    Calling& operator=(const Calling&) = delete;
    bool& flag_;
  };

  // --- StepObserver ---
  void at_instant() override {
    for (std::size_t k = 0; k < observers.size(); ++k) {  // one may add others
      Observing& o = observers[k];
      if (!o.call || !(o.due.due(time(), close()) || o.always)) continue;
      if (!has_bed()) stepper.columns().take_instant(stepper.values());
      const auto call = o.call;
      const Calling calling(in_observer);
      if (!call(*owner)) stop = true;
    }
    std::erase_if(observers, [](const Observing& o) { return !o.call; });
    leave_held();  // the window of a moving bed advances next
  }
  void before_step(bool, StepRequest& request) override {
    if (search) search->begin(time(), stepper.values()), searched = time();
    const double dt = stepper.simulation().step_length();
    double next = time() + (search ? std::min(dt, MotionSearch::longest) : dt);
    if (next >= target - close()) next = target;  // sums of steps end beside it by rounding
    last = time() + dt >= target - close();
    request.stop = request.stop || stop;
    request.instant = request.instant || last;
    request.energies = request.energies || (last && energies);
    request.until = std::min(request.until, next);
    for (const Observing& o : observers) {
      if (o.due.next() > time() + close()) request.until = std::min(request.until, o.due.next());
      // Who is called at the end of this step reads its values.
      request.instant = request.instant || o.always || o.due.next() <= time() + dt + close();
    }
  }
  bool take(const std::function<void()>& step) override {
    const double t = time();
    try {
      return step(), true;
    } catch (const std::exception& error) {
      throw SimulationFault(step_failure(error, t, loaded.scenario, stepper.world()), t);
    }
  }
  bool after_step() override {
    if (search) search->search(searched, time(), stepper.values());
    if (!has_bed()) return true;
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += about_origin(k);
    ++summed;
    return true;
  }
  /// Values at this instant, of a machine alone.
  void take_values() {
    search ? static_cast<void>(search->begin(time(), stepper.values()))
           : stepper.columns().take_instant(stepper.values());
  }

  double time() const { return stepper.simulation().time(); }
  double close() const { return stepper.close(); }
  bool has_bed() const { return stepper.world().bed != nullptr; }

  /// Steps until `t`; false where an observer ends them.
  bool run_until(double t) {
    if (!std::isfinite(t))
      throw std::invalid_argument(std::isnan(t) ? "run_until: the time is no number"
                                                : "run_until: the time is infinite; give when the call ends, s");
    if (in_observer)
      throw std::logic_error("an observer is called within a step: it must not step; return false to end the call");
    stop = false, summed = 0, target = t;
    std::fill(sums.begin(), sums.end(), dem::Wrench{});
    StepObserver* const observers_of_step[] = {this};
    bool continues = true;
    while (continues && time() < t - close()) continues = stepper.advance(observers_of_step);
    end_call();
    return continues;
  }
  void end_call() {
    if (!has_bed()) take_values();
    if (!energies)
      for (std::size_t c = 0; c < columns.size(); ++c)
        if (columns[c].of_sum) stepper.values()[c] = std::numeric_limits<double>::quiet_NaN();
    if (stepper.world().machine == nullptr) return;
    if (const std::string fault = machine_fault(loaded.scenario, stepper.world()); !fault.empty())
      throw SimulationFault("t = " + std::to_string(time()) + " s: " + fault, time());
  }
  std::size_t surface(const std::string& name) const {
    const auto found = surface_of.find(name);
    if (found != surface_of.end()) return found->second;
    std::vector<std::string> known;
    for (const SurfaceInfo& s : surfaces) known.push_back(s.name);
    throw std::invalid_argument("surface " + name + ": the scenario has no such surface" + suggestion(name, known));
  }
  int body(const std::string& name) const {
    std::vector<std::string> known;
    const mbd::Machine* machine = stepper.world().machine.get();
    for (int i = 1; machine != nullptr && i < machine->system().bodies(); ++i) {
      if (machine->system().body_name(i) == name) return i;
      known.push_back(machine->system().body_name(i));
    }
    throw std::invalid_argument("body " + name + ": the machine has no such body" + suggestion(name, known));
  }
  dem::Wrench about_origin(std::size_t k) const {
    const SurfaceRecord& s = stepper.world().surfaces[k];
    const dem::Boundary& b = stepper.world().bed->boundary(s.boundary);
    return dem::about(b.on_mesh(s.mesh), b.pose.position, {});
  }
  void forget_values() {
    std::fill(stepper.values().begin(), stepper.values().end(), std::numeric_limits<double>::quiet_NaN());
  }

  void drive(int boundary, const GivenCourse& course) {
    courses[boundary] = course;
    stepper.set_motion(boundary, [course](double t) { return course.at(t); });
  }
  /// What a state holds beside bed, machine and coupling.
  void archive(Archive& a) {
    long& steps = stepper.steps();
    a("steps", steps);
    for (const auto& input : inputs.list()) a("input", *input);
    stepper.columns().archive_histories(a);
    std::vector<std::pair<int, GivenCourse>> list(courses.begin(), courses.end());
    a("courses", list);
    if (!a.reads()) return;
    const auto kept = [&](int boundary) {
      return std::any_of(list.begin(), list.end(), [&](const auto& one) { return one.first == boundary; });
    };
    for (const auto& [boundary, course] : courses)
      if (!kept(boundary)) stepper.set_motion(boundary, {});
    courses.clear();
    for (const auto& [boundary, course] : list) drive(boundary, course);
  }

  Loaded loaded;
  Inputs inputs;
  std::vector<std::string> sets;
  std::string file;
  std::optional<std::string> source;  ///< text that the scenario was read from; none: the file
  std::string text;
  std::string identity;  ///< what a state and the simulation that takes it have in common: the text but for the folder
  bool energies = false;
  Stepper stepper;
  Simulation* owner = nullptr;
  std::vector<SurfaceInfo> surfaces;
  std::map<std::string, std::size_t> surface_of;
  std::vector<ColumnInfo> columns;
  std::vector<dem::Wrench> sums;  ///< of surfaces about the world's origin, over the steps of a call
  long summed = 0;
  bool in_observer = false;
  double target = 0;                   ///< s, to which the call steps
  std::optional<MotionSearch> search;  ///< where columns of a machine alone are followed over time
  double searched = 0;                 ///< s, where the step that is searched begins
  bool last = false, stop = false;
  std::vector<Observing> observers;
  int observers_made = 0;
  std::map<int, GivenCourse> courses;  ///< by boundary
  std::weak_ptr<Held> held;
};

Simulation::Simulation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) { impl_->owner = this; }
Simulation::Simulation(Simulation&& other) noexcept : impl_(std::move(other.impl_)) { impl_->owner = this; }
Simulation::~Simulation() {
  if (impl_) impl_->leave_held();
}

Simulation Simulation::from_file(const std::filesystem::path& file, const SimulationOptions& options) {
  return Simulation(Impl::make(load_scenario(file.string(), options.sets), options, file.string()));
}

Simulation Simulation::from_text(const std::string& text, const std::string& name, const SimulationOptions& options) {
  return Simulation(Impl::make(load_scenario_text(text, name, options.sets), options, name, text));
}

std::vector<std::string> Simulation::available_inputs(const std::string& text, const std::string& name,
                                                      const std::vector<std::string>& sets) {
  return Inputs::available(load_scenario_text(text, name, sets));
}

double Simulation::time() const { return impl_->time(); }
double Simulation::end() const { return impl_->loaded.scenario.time.end; }
double Simulation::step_length() const { return impl_->stepper.simulation().step_length(); }
long Simulation::steps() const { return impl_->stepper.steps(); }

bool Simulation::step(long count) {
  if (count < 0) throw std::invalid_argument("step: " + std::to_string(count) + " steps; must not be negative");
  return run_until(time() + static_cast<double>(count) * step_length());
}
bool Simulation::run_until(double t) { return impl_->run_until(t); }

bool Simulation::has_bed() const { return impl_->has_bed(); }
bool Simulation::has_machine() const { return impl_->stepper.world().machine != nullptr; }
const std::string& Simulation::scenario_text() const { return impl_->text; }

std::vector<std::string> Simulation::warnings() const {
  const World& world = impl_->stepper.world();
  const Scenario& s = impl_->loaded.scenario;
  std::vector<SurfaceFacts> facts = surface_facts(world, s, s.time.end);
  for (const SurfaceRecord& surface : world.surfaces)  // where they come is up to the caller
    if (impl_->courses.count(surface.boundary) != 0)
      for (SurfaceFacts& f : facts)
        if (f.name == surface.name) f.path_known = false;
  std::vector<std::string> out = surface_warnings(facts, world);
  for (const std::string& text :
       input_warnings(impl_->loaded, world, impl_->file, impl_->sets, impl_->source ? &*impl_->source : nullptr))
    out.push_back(text);
  for (const std::string& text : placement_warnings(s, world)) out.push_back(text);
  if (impl_->courses.empty())
    for (const std::string& text : travel_warnings(s, world)) out.push_back(text);
  return out;
}

std::span<const dem::Sphere> Simulation::spheres() const {
  if (!has_bed()) return {};
  return impl_->stepper.world().bed->spheres();
}

std::shared_ptr<const std::span<const dem::Sphere>> Simulation::held_spheres() {
  auto held = impl_->held.lock();
  if (!held) impl_->held = held = std::make_shared<Impl::Held>(Impl::Held{spheres()});
  return {held, &held->spheres};
}

const std::vector<SurfaceInfo>& Simulation::surfaces() const { return impl_->surfaces; }

dem::Pose Simulation::pose(const std::string& surface) const {
  return impl_->stepper.simulation().surface_pose(impl_->stepper.world().surfaces[impl_->surface(surface)].boundary);
}

namespace {

void refuse_no_place(const Vec3& about) {
  if (!std::isfinite(about.x) || !std::isfinite(about.y) || !std::isfinite(about.z))
    throw std::invalid_argument(
        fmt::format("wrench: about ({:g}, {:g}, {:g}) m is no place", about.x, about.y, about.z));
}

}  // namespace

dem::Wrench Simulation::wrench(const std::string& surface, const Vec3& about) const {
  refuse_no_place(about);
  return dem::about(impl_->about_origin(impl_->surface(surface)), {}, about);
}

dem::Wrench Simulation::mean_wrench(const std::string& surface, const Vec3& about) const {
  refuse_no_place(about);
  const dem::Wrench sum = impl_->sums[impl_->surface(surface)];
  if (impl_->summed == 0) return wrench(surface, about);
  return dem::about(sum * (1 / static_cast<double>(impl_->summed)), {}, about);
}

std::vector<std::string> Simulation::bodies() const {
  std::vector<std::string> out;
  const mbd::Machine* machine = impl_->stepper.world().machine.get();
  for (int i = 1; machine != nullptr && i < machine->system().bodies(); ++i)
    out.push_back(machine->system().body_name(i));
  return out;
}

mbd::BodyState Simulation::body(const std::string& name) const {
  return impl_->stepper.simulation().body(impl_->body(name));
}

const std::vector<ColumnInfo>& Simulation::columns() const { return impl_->columns; }
std::span<const double> Simulation::values() const { return impl_->stepper.values(); }

double Simulation::value(const std::string& column) const {
  const int found = impl_->stepper.columns().find(column);
  if (found >= 0) return impl_->stepper.values()[static_cast<std::size_t>(found)];
  std::vector<std::string> known;
  for (const ColumnInfo& c : impl_->columns) known.push_back(c.name);
  throw std::invalid_argument("column " + column + ": the simulation has no such column" + suggestion(column, known));
}

void Simulation::set_motion(const std::string& surface, const SurfaceMotion& motion) {
  const std::size_t k = impl_->surface(surface);
  if (impl_->surfaces[k].owner != SurfaceInfo::Owner::given)
    throw std::invalid_argument("surface " + surface + ": belongs to the " +
                                (impl_->surfaces[k].owner == SurfaceInfo::Owner::machine
                                     ? "machine, which moves it; set an input of its driver or a force on its body"
                                     : "container; give the moved wall under `boundaries`"));
  for (const BoundarySection& b : impl_->loaded.scenario.boundaries)
    if (b.name == surface && b.servo)
      throw std::invalid_argument("surface " + surface +
                                  ": its servo moves it; leave `servo` out of the scenario, or set no motion");
  const auto finite = [](const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
  if (!finite(motion.position) || !finite(motion.velocity) || !finite(motion.angular_velocity))
    throw std::invalid_argument("surface " + surface + ": position and velocities must be finite numbers");
  const dem::Quaternion& q = motion.attitude;
  const double norm = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  if (!(std::abs(norm - 1) < 1e-3))
    throw std::invalid_argument("surface " + surface + ": its attitude has the norm " + std::to_string(norm) +
                                "; a quaternion of a rotation has 1");
  SurfaceMotion unit = motion;
  unit.attitude = {q.w / norm, q.x / norm, q.y / norm, q.z / norm};
  impl_->drive(impl_->stepper.world().surfaces[k].boundary, {unit, time()});
}

std::vector<InputInfo> Simulation::inputs() const {
  std::vector<InputInfo> out;
  for (const auto& input : impl_->inputs.list()) out.push_back({input->name(), input->unit(), input->value(time())});
  return out;
}

void Simulation::set_input(const std::string& name, double value, double rate) {
  if (!std::isfinite(value) || !std::isfinite(rate))
    throw std::invalid_argument("input " + name + ": value and rate must be finite");
  Input& input = impl_->inputs.at(name);
  // The rate of a driver's velocity is an acceleration: a jump of it is one of the reactions.
  const bool jumps = input.value(time()) != value || input.first(time()) != rate;
  input.set(time(), value, rate);
  if (jumps && has_machine()) impl_->stepper.note_jump();
}

void Simulation::set_force(const std::string& body, double fx, double fy, double moment) {
  impl_->body(body);
  try {
    impl_->inputs.at(body + ".fx");
  } catch (const std::invalid_argument&) {
    throw std::invalid_argument("force on " + body +
                                ": the simulation was made without it; name the body in `forces_on`");
  }
  set_input(body + ".fx", fx), set_input(body + ".fy", fy), set_input(body + ".moment", moment);
}

dem::SphereForce& Simulation::sphere_force(const std::string& name) {
  if (!has_bed()) throw std::invalid_argument("force on spheres '" + name + "': the scenario has no soil");
  return impl_->stepper.world().bed->force(name);
}

int Simulation::observe(double every, std::function<bool(Simulation&)> observer) {
  if (!(every >= 0)) throw std::invalid_argument("observer: `every` must be at or above 0 s; 0 is every step");
  Impl::Observing o{.number = ++impl_->observers_made, .due = {}, .always = every == 0, .call = std::move(observer)};
  o.due = Schedule(every, {}, time());
  impl_->observers.push_back(std::move(o));
  return impl_->observers_made;
}

void Simulation::stop_observing(int number) {
  for (Impl::Observing& o : impl_->observers)
    if (o.number == number) o.call = nullptr;
}

Simulation::State Simulation::save() {
  Impl& d = *impl_;
  d.stepper.refresh_now();
  auto out = std::make_shared<State::Impl>();
  out->saved = take_state(d.stepper.world(), d.stepper.simulation(), &out->bed);
  out->of_checkpoint = out->saved.has_bed;
  out->saved.scenario = d.identity;
  RunProgress progress;
  d.archive(progress.sums);
  progress.exact = out->saved.exact = d.stepper.machine_is_fresh();
  out->saved.progress = std::move(progress);
  State state;
  state.impl_ = std::move(out);
  return state;
}

void Simulation::restore(const State& state) {
  Impl& d = *impl_;
  if (!state.impl_) throw std::invalid_argument("state: is empty; take one from save() or from_bytes()");
  const SavedRun& saved = state.impl_->saved;
  if (saved.scenario != d.identity)
    throw std::invalid_argument("state: is of another scenario or other inputs; restore it where it was saved");
  d.leave_held();
  // Inputs and motions first: a machine takes its accelerations from them.
  Archive numbers = saved.progress->sums.to_read();
  d.archive(numbers);
  numbers.end();
  const bool is_own = d.stepper.world().bed && state.impl_->bed.is_of(*d.stepper.world().bed);
  d.stepper.restore(is_own ? saved : state.impl_->complete(), is_own ? &state.impl_->bed : nullptr);
  d.forget_values();
}

double Simulation::State::time() const { return impl_ ? impl_->saved.time : 0; }
bool Simulation::State::is_exact() const { return impl_ && impl_->saved.exact; }

namespace {

/// A file that is gone with its scope: the format of states is that of HDF5 files.
struct ScratchFile {
  std::filesystem::path path;
  ScratchFile() {
    std::string name = (std::filesystem::temp_directory_path() / "subsoil-state-XXXXXX").string();
    const int file = ::mkstemp(name.data());
    if (file < 0) throw std::runtime_error("state: no scratch file can be made in " + name);
    ::close(file);
    path = name;
  }
  ~ScratchFile() {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
};

}  // namespace

void Simulation::State::write(const std::filesystem::path& file) const {
  if (!impl_) throw std::invalid_argument("state: is empty; take one from save() or from_bytes()");
  write_run(file, impl_->complete());
}

std::vector<std::byte> Simulation::State::bytes() const {
  if (!impl_) throw std::invalid_argument("state: is empty; take one from save() or from_bytes()");
  const ScratchFile file;
  write_run(file.path, impl_->complete());
  std::vector<std::byte> out(std::filesystem::file_size(file.path));
  std::ifstream(file.path, std::ios::binary).read(reinterpret_cast<char*>(out.data()), static_cast<long>(out.size()));
  return out;
}

Simulation::State Simulation::State::from_bytes(std::span<const std::byte> bytes) {
  const ScratchFile file;
  std::ofstream(file.path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<long>(bytes.size()));
  auto out = std::make_shared<Impl>();
  try {
    out->saved = read_run(file.path);
  } catch (const StateFault&) {  // which names a file that nobody knows
    throw std::invalid_argument(
        "state: the bytes are not those of a whole state of this version; take them from to_bytes()");
  }
  if (!out->saved.progress) throw std::runtime_error("state: is none of a simulation in process");
  State state;
  state.impl_ = std::move(out);
  return state;
}

}  // namespace subsoil::sim
