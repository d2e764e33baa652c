#include "libsim/fmu/library/instance.hpp"

#include <fmt/format.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <mutex>
#include <sstream>
#include <stdexcept>

#include "libsim/base/json.hpp"
#include "libsim/document/unit_database.hpp"

namespace subsoil::sim {
namespace {

using Role = FmuVariable::Role;

constexpr double close_share = 1e-6;  // of a soil step: as in a run

thread_local FmuInstance* inside = nullptr;

class ImporterSink : public spdlog::sinks::base_sink<std::mutex> {
 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (inside == nullptr) return;
    using Level = FmuInstance::Level;
    const Level level = message.level >= spdlog::level::err    ? Level::error
                        : message.level >= spdlog::level::warn ? Level::warning
                                                               : Level::info;
    inside->log(level, std::string(message.payload.data(), message.payload.size()));
  }
  void flush_() override {}
};

/// The HDF5 library is for one thread; an importer may have several, with an instance each.
std::mutex& reading_files() {
  static std::mutex one;
  return one;
}

void prepare_process(const std::filesystem::path& resources) {
  static std::once_flag once;
  std::call_once(once, [&] {
    use_unit_database((resources / "udunits2.xml").string());
    const auto logger = std::make_shared<spdlog::logger>("subsoil", std::make_shared<ImporterSink>());
    logger->set_level(spdlog::level::info);
    spdlog::set_default_logger(logger);
  });
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error(path.string() + ": cannot be read; the FMU is not unpacked completely");
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

FmuModel read_model(const std::filesystem::path& file) {
  try {
    return fmu_model_of(read_json(file));
  } catch (const std::exception& error) {
    throw std::runtime_error(file.string() + ": " + error.what() + "; the FMU is not unpacked completely");
  }
}

/// A driver is a constraint: a jump of its velocity is an impulse, whose work no balance of forces has. It goes evenly
/// to the value that is set. Other inputs, forces above all, are constant over a step.
bool is_ramp(const FmuVariable& v) { return v.of.rfind("machine.drivers.", 0) == 0; }

/// Rotation vector, rad, of a unit quaternion; the short way round.
dem::Vec3 rotation_vector(dem::Quaternion q) {
  if (q.w < 0) q = {-q.w, -q.x, -q.y, -q.z};
  const dem::Vec3 axis{q.x, q.y, q.z};
  const double sine = dem::norm(axis);
  return sine > 0 ? axis * (2 * std::atan2(sine, q.w) / sine) : dem::Vec3{};
}

dem::Pose moved(const SurfaceMotion& m, double s) {
  return {m.position + m.velocity * s, dem::Quaternion::from_rotation_vector(m.angular_velocity * s) * m.attitude};
}

}  // namespace

LogScope::LogScope(FmuInstance& instance) : before_(inside) { inside = &instance; }
LogScope::~LogScope() { inside = before_; }

FmuInstance::FmuInstance(const std::filesystem::path& resources, const std::string& token, Log log)
    : resources_(resources), log_(std::move(log)), model_(read_model(resources / "fmu.json")) {
  prepare_process(resources);
  if (token != model_.token)
    throw std::invalid_argument(
        fmt::format("token {}: the model description has {}; give that one", token, model_.token));
  for (const std::string& name : model_.tools) {
    Tool tool{.name = name};
    for (std::uint32_t r = static_cast<std::uint32_t>(model_.variables.size()); r-- > 0;) {
      const FmuVariable& v = model_.variables[r];
      if (v.of != name || v.component != 0) continue;
      if (v.role == Role::tool_input) tool.input = r;
      if (v.role == Role::tool_point) tool.point = r;
      if (v.role == Role::tool_output) tool.output = r;
    }
    tools_.push_back(tool);
  }
  motion_.resize(tools_.size());
  reset();
}

void FmuInstance::reset() {
  simulation_.reset();
  values_.clear();
  for (const FmuVariable& v : model_.variables) values_.push_back(v.start);
  applied_.assign(values_.size(), std::numeric_limits<double>::quiet_NaN());
  given_.assign(values_.size(), 0);
  failed_.clear();
  stop_.reset();
  offset_ = time_ = 0, initialized_ = start_is_known_ = false;
}

const FmuVariable& FmuInstance::variable(std::uint32_t reference) const {
  if (reference >= model_.variables.size())
    throw std::invalid_argument(
        fmt::format("value reference {}: must be below {}", reference, model_.variables.size()));
  return model_.variables[reference];
}

double FmuInstance::get(std::uint32_t reference) {
  const FmuVariable& v = variable(reference);
  if (v.role == Role::time) return time_;
  if (v.is_output() && !initialized_ && !start_is_known_) take_start();
  return values_[reference];
}

void FmuInstance::set(std::uint32_t reference, double value) {
  const FmuVariable& v = variable(reference);
  if (v.is_output() || v.role == Role::time)
    throw std::invalid_argument(fmt::format("{}: is an output; set inputs and parameters only", v.name));
  if (!std::isfinite(value)) throw std::invalid_argument(fmt::format("{} = {}: must be finite", v.name, value));
  if (v.is_parameter() && initialized_)
    throw std::invalid_argument(fmt::format("{}: is fixed; set it before the end of initialization", v.name));
  if (v.role == Role::parameter && values_[reference] != value) simulation_.reset();
  values_[reference] = value, given_[reference] = 1;
  start_is_known_ = false;
}

void FmuInstance::build() {
  SimulationOptions options;
  options.inputs = model_.inputs, options.forces_on = model_.forces_on;
  bool as_exported = true;
  for (std::size_t r = 0; r < values_.size(); ++r) {
    const FmuVariable& v = model_.variables[r];
    if (v.role != Role::parameter || values_[r] == v.start) continue;
    as_exported = false;
    options.sets.push_back(fmt::format("{}={} {}", v.of, values_[r], v.unit == "1" ? "" : v.unit));
  }
  const std::lock_guard lock(reading_files());
  // With other parameters the bed is another one: it settles again.
  if (as_exported && std::filesystem::exists(resources_ / "start.h5")) options.start = resources_ / "start.h5";
  simulation_.emplace(
      Simulation::from_text(text_of(resources_ / "scenario.yaml"), (resources_ / "scenario.yaml").string(), options));
  std::fill(applied_.begin(), applied_.end(), std::numeric_limits<double>::quiet_NaN());
}

Simulation& FmuInstance::simulation() {
  if (!simulation_) build();
  return *simulation_;
}

SurfaceMotion FmuInstance::given_motion(std::size_t tool) const {
  const double* const in = values_.data() + tools_[tool].input;
  const double norm = std::hypot(std::hypot(in[3], in[4]), std::hypot(in[5], in[6]));
  if (!(std::abs(norm - 1) < 1e-3))
    throw std::invalid_argument(
        fmt::format("tools.{}.quaternion: has the norm {}; must be 1, as of a rotation", tools_[tool].name, norm));
  return {.position = {in[0], in[1], in[2]},
          .attitude = dem::Quaternion{in[3], in[4], in[5], in[6]}.normalized(),
          .velocity = {in[7], in[8], in[9]},
          .angular_velocity = {in[10], in[11], in[12]}};
}

void FmuInstance::place_tools() {
  for (std::size_t k = 0; k < tools_.size(); ++k) motion_[k] = given_motion(k);
  for (std::size_t k = 0; k < tools_.size(); ++k) simulation().set_motion(tools_[k].name, motion_[k]);
  motion_from_ = simulation().time();
}

// One step shows what acts at the start; the state before it is restored.
void FmuInstance::take_start() {
  Simulation& s = simulation();
  place_tools();
  apply_inputs(0);
  const Simulation::State start = s.save();
  std::vector<dem::Wrench> sums(tools_.size());
  s.has_bed() ? s.step(1) : s.run_until(s.time());
  sum_wrenches(motion_from_, sums);
  put_wrenches(sums, 1);
  take_columns();
  s.restore(start);
  take_bodies();
  start_is_known_ = true;
}

void FmuInstance::enter_initialization() { offset_ = time_ - simulation().time(); }

void FmuInstance::exit_initialization() {
  if (!start_is_known_) take_start();
  for (const std::string& warning : simulation().warnings()) log(Level::warning, warning);
  initialized_ = true;
}

void FmuInstance::apply_inputs(double length) {
  std::map<std::string, double> now;
  if (length > 0)
    for (const InputInfo& input : simulation().inputs()) now[input.name] = input.value;
  for (std::size_t r = 0; r < values_.size(); ++r) {
    const FmuVariable& v = model_.variables[r];
    // What the importer never sets keeps the scenario's own function of time.
    if (v.role != Role::input || given_[r] == 0) continue;
    if (is_ramp(v)) {
      if (length > 0) simulation().set_input(v.of, now.at(v.of), (values_[r] - now.at(v.of)) / length);
    } else if (values_[r] != applied_[r]) {
      simulation().set_input(v.of, values_[r]);
      applied_[r] = values_[r];
    }
  }
}

// From where a tool stands to where its velocities bring it by the end of the step, evenly: a jump of the pose would be
// made within one soil step, at a speed that the tool does not have.
void FmuInstance::move_tools(double target) {
  Simulation& s = simulation();
  const double now = s.time(), dt = s.step_length();
  const double length = std::ceil((target - now) / dt - close_share) * dt;
  if (!(length > 0)) return;
  std::vector<SurfaceMotion> given;
  for (std::size_t k = 0; k < tools_.size(); ++k) given.push_back(given_motion(k));
  for (std::size_t k = 0; k < tools_.size(); ++k) {
    const dem::Pose from = s.pose(tools_[k].name), to = moved(given[k], now + length - (time_ - offset_));
    motion_[k] = {.position = from.position,
                  .attitude = from.attitude,
                  .velocity = (to.position - from.position) * (1 / length),
                  .angular_velocity = rotation_vector(to.attitude * from.attitude.conjugate()) * (1 / length)};
    s.set_motion(tools_[k].name, motion_[k]);
  }
  motion_from_ = now;
}

void FmuInstance::sum_wrenches(double t, std::vector<dem::Wrench>& sums) {
  for (std::size_t k = 0; k < tools_.size(); ++k) {
    const double* const point = values_.data() + tools_[k].point;
    const dem::Pose pose = moved(motion_[k], t - motion_from_);
    sums[k] += simulation_->wrench(tools_[k].name, pose.to_world({point[0], point[1], point[2]}));
  }
}

void FmuInstance::put_wrenches(const std::vector<dem::Wrench>& sums, long steps) {
  for (std::size_t k = 0; k < tools_.size(); ++k) {
    double* const out = values_.data() + tools_[k].output;
    const dem::Wrench mean = sums[k] * (1 / static_cast<double>(steps));
    for (int d = 0; d < 3; ++d) out[d] = mean.force[d], out[3 + d] = mean.moment[d];
  }
}

void FmuInstance::take_columns() {
  for (std::size_t r = 0; r < values_.size(); ++r)
    if (const FmuVariable& v = model_.variables[r]; v.role == Role::column) values_[r] = simulation_->value(v.of);
  take_bodies();
}

void FmuInstance::take_bodies() {
  for (std::size_t r = 0; r < values_.size(); ++r) {
    const FmuVariable& v = model_.variables[r];
    if (v.role != Role::body) continue;
    const mbd::BodyState body = simulation_->body(v.of);
    const double all[] = {body.r.x, body.r.y, body.angle, body.v.x, body.v.y, body.omega};
    values_[r] = all[v.component];
  }
}

double FmuInstance::step(double time, double length, const Intermediate& intermediate) {
  if (!initialized_) throw std::logic_error("a step comes after the end of initialization");
  if (!failed_.empty())
    throw std::logic_error("the step before failed; restore a state or reset the instance: " + failed_);
  if (!(length > 0)) throw std::invalid_argument(fmt::format("communication step = {} s: must be positive", length));
  Simulation& s = simulation();
  if (std::abs(time - time_) > close_share * std::max(length, s.step_length()))
    throw std::invalid_argument(fmt::format(
        "communication point = {} s: the instance stands at {} s; restore a state to go back", time, time_));
  if (stop_ && time + length - *stop_ > close_share * std::max(length, s.step_length()))
    throw std::invalid_argument(
        fmt::format("a communication step of {} s from {} s passes the stop time {} s that the importer has defined; "
                    "make it shorter, or leave the stop time open",
                    length, time, *stop_));
  try {
    apply_inputs(time + length - offset_ - s.time());
    time_ = advance(time, length, intermediate);
  } catch (const std::invalid_argument&) {
    throw;  // of an input, before anything moved
  } catch (const std::exception& fault) {
    failed_ = fault.what();
    throw;
  }
  return time_;
}

double FmuInstance::advance(double time, double length, const Intermediate& intermediate) {
  Simulation& s = simulation();
  const double target = time + length - offset_, close = close_share * s.step_length();
  double reached = time + length;
  if (tools_.empty() && (!intermediate || !s.has_bed())) {
    s.run_until(target);
  } else {
    move_tools(target);
    std::vector<dem::Wrench> sums(tools_.size());
    for (long steps = 1; s.time() < target - close; ++steps) {
      const double t = s.time();
      s.step(1);
      sum_wrenches(t, sums);
      if (!intermediate && s.time() < target - close) continue;
      put_wrenches(sums, steps);
      if (!intermediate) continue;
      take_columns();
      if (intermediate(std::min(s.time() + offset_, time + length)) && s.time() < target - close) {
        reached = s.time() + offset_;
        break;
      }
    }
  }
  take_columns();
  return reached;
}

std::shared_ptr<FmuInstance::State> FmuInstance::save() {
  return std::make_shared<State>(State{simulation().save(), values_, applied_, given_, offset_, time_, initialized_});
}

void FmuInstance::restore(const State& state) {
  if (state.values.size() != values_.size())
    throw std::invalid_argument("state: is of another FMU; restore it where it was saved");
  for (std::size_t r = 0; r < values_.size(); ++r)
    if (model_.variables[r].role == Role::parameter && values_[r] != state.values[r]) simulation_.reset();
  values_ = state.values;
  simulation().restore(state.simulation);
  applied_ = state.applied, given_ = state.given;
  offset_ = state.offset, time_ = state.time, initialized_ = state.initialized, start_is_known_ = false;
  failed_.clear();
}

const std::vector<std::byte>& FmuInstance::serialized(const std::shared_ptr<State>& held) const {
  const State& state = *held;
  std::vector<std::byte>& out = held->serialized;
  if (!out.empty()) return out;
  const auto put = [&](const void* data, std::size_t count) {
    const auto* const bytes = static_cast<const std::byte*>(data);
    out.insert(out.end(), bytes, bytes + count);
  };
  const std::uint64_t count = state.values.size();
  const double head[] = {state.offset, state.time, state.initialized ? 1.0 : 0.0};
  put(&count, sizeof count), put(head, sizeof head);
  put(state.values.data(), count * sizeof(double)), put(state.applied.data(), count * sizeof(double));
  put(state.given.data(), count);
  const std::lock_guard lock(reading_files());
  const std::vector<std::byte> simulation = state.simulation.bytes();
  put(simulation.data(), simulation.size());
  return out;
}

std::shared_ptr<FmuInstance::State> FmuInstance::state_of(std::span<const std::byte> bytes) {
  auto out = std::make_shared<State>();
  const auto take = [&](void* data, std::size_t count) {
    if (bytes.size() < count) throw std::runtime_error("state: is cut off");
    std::memcpy(data, bytes.data(), count);
    bytes = bytes.subspan(count);
  };
  std::uint64_t count = 0;
  double head[3];
  take(&count, sizeof count), take(head, sizeof head);
  if (count > bytes.size() / sizeof(double)) throw std::runtime_error("state: is cut off");
  out->values.resize(count), out->applied.resize(count), out->given.resize(count);
  take(out->values.data(), count * sizeof(double)), take(out->applied.data(), count * sizeof(double));
  take(out->given.data(), count);
  out->offset = head[0], out->time = head[1], out->initialized = head[2] != 0;
  const std::lock_guard lock(reading_files());
  out->simulation = Simulation::State::from_bytes(bytes);
  return out;
}

}  // namespace subsoil::sim
