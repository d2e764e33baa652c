#include "libsim/run/analysis.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <stdexcept>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/equilibrium/force_jumps.hpp"
#include "libmbd/forces/bushing.hpp"
#include "libmbd/forces/rotational_spring_damper.hpp"
#include "libmbd/forces/spring_damper.hpp"
#include "libmbd/integrators/events.hpp"
#include "libsim/base/json.hpp"
#include "libsim/base/version.hpp"
#include "libsim/io/atomic_file.hpp"
#include "libsim/io/csv.hpp"
#include "libsim/io/series.hpp"
#include "libsim/io/series_writer.hpp"
#include "libsim/run/columns.hpp"
#include "libsim/run/frames.hpp"
#include "libsim/setup/world.hpp"

namespace subsoil::sim {
namespace {

constexpr const char* axes[] = {"x", "y", "angle"};
constexpr const char* axis_units[] = {"m", "m", "rad"};

/// How far joints and drivers are open in the pose that the file gives.
std::map<std::string, double> open_as_given(const mbd::Machine& machine) {
  mbd::System system(machine.system().model());
  mbd::Constraints c;
  system.set_position(system.model().start_time, system.start_position());
  system.constraints(c);
  std::map<std::string, double> open;
  for (int row = 0; row < system.equations(); ++row)
    open[system.owner(row)] = std::max(open[system.owner(row)], std::abs(c.phi[row]));
  return open;
}

Json assembly_json(const mbd::Machine& machine) {
  const mbd::System& system = machine.system();
  const mbd::AssemblyReport& a = machine.assembly();
  Json out{{"coordinates", system.coordinates()},
           {"equations", a.equations},
           {"rank", a.rank},
           {"freedom", a.freedom},
           {"iterations", a.iterations},
           {"residual [m]", a.residual},
           {"largest move [m]", a.moved},
           {"redundant", a.redundant}};
  for (const auto& [owner, residual] : open_as_given(machine)) out["open as given [m or rad]"][owner] = residual;
  for (const auto& b : system.model().bodies) {
    const mbd::BodyState& now = machine.body(system.body_index(b.name));
    out["moved"][b.name] = {
        {"x [m]", now.r.x - b.pose[0]}, {"y [m]", now.r.y - b.pose[1]}, {"angle [rad]", now.angle - b.pose[2]}};
  }
  return out;
}

void print_assembly(const mbd::Machine& machine, const Json& json) {
  const mbd::AssemblyReport& a = machine.assembly();
  fmt::print("assembly: {} coordinates, {} equations of rank {}, freedom {}; closed to {:.1e} m in {} iterations\n",
             machine.system().coordinates(), a.equations, a.rank, a.freedom, a.residual, a.iterations);
  for (const std::string& r : a.redundant) fmt::print("  redundant: {}\n", r);
  for (const auto& [body, moved] : json["moved"].items())
    fmt::print("  {:<20} moved by {:12.5e} m {:12.5e} m {:12.5e} rad\n", body, moved["x [m]"].get<double>(),
               moved["y [m]"].get<double>(), moved["angle [rad]"].get<double>());
}

const char* word_of(mbd::Stability stability) {
  switch (stability) {
    case mbd::Stability::stable:
      return "stable";
    case mbd::Stability::neutral:
      return "neutral";
    case mbd::Stability::unstable:
      return "unstable";
    case mbd::Stability::undetermined:
      return "undetermined";
  }
  return "";
}

Json equilibrium_json(const mbd::Machine& machine, double speed, const mbd::StabilityReport& stability) {
  Json out{{"speed [m/s]", speed},
           {"residual [N]", machine.equilibrium()->residual},
           {"iterations", machine.equilibrium()->iterations},
           {"stability", word_of(stability.kind)},
           {"unstable eigenvalues", stability.unstable},
           {"coordinates that nothing holds", stability.neutral},
           {"undetermined eigenvalues", stability.undetermined}};
  for (const auto& b : machine.system().model().bodies) {
    const mbd::BodyState& now = machine.body(machine.system().body_index(b.name));
    out["pose"][b.name] = {{"x [m]", now.r.x}, {"y [m]", now.r.y}, {"angle [rad]", now.angle}};
  }
  return out;
}

void print_equilibrium(const Json& json) {
  const int undetermined = json["undetermined eigenvalues"].get<int>();
  fmt::print("equilibrium: {}, {} unstable eigenvalues, {}{} coordinates that nothing holds; {:.1e} N unbalanced\n",
             json["stability"].get<std::string>(), json["unstable eigenvalues"].get<int>(),
             undetermined > 0 ? fmt::format("{} undetermined ones, ", undetermined) : std::string(),
             json["coordinates that nothing holds"].get<int>(), json["residual [N]"].get<double>());
  for (const auto& [body, pose] : json["pose"].items())
    fmt::print("  {:<20} {:14.9g} m {:14.9g} m {:14.9g} rad\n", body, pose["x [m]"].get<double>(),
               pose["y [m]"].get<double>(), pose["angle [rad]"].get<double>());
}

Json modes_json(const mbd::System& system, const std::vector<mbd::Mode>& modes) {
  Json out = Json::array();
  for (const mbd::Mode& m : modes) {
    Json shape = Json::object();
    for (Eigen::Index i = 0; i < m.shape.size(); ++i)
      shape[system.body_name(static_cast<int>(i / 3) + 1)][axes[i % 3]] = {m.shape[i].real(), m.shape[i].imag()};
    out.push_back({{"frequency [Hz]", m.frequency},
                   {"damping ratio", m.damping},
                   {"real part [1/s]", m.rate},
                   {"error [1/s]", m.error},
                   {"shape, real and imaginary", shape}});
  }
  return out;
}

/// Of a zero eigenvalue, that rounding may hide a frequency [Hz].
std::string held_below(double hidden) {
  return hidden > 0 ? fmt::format("  nothing above {:.1g} Hz holds it", hidden) : "  nothing holds it";
}

void print_modes(const std::vector<mbd::Mode>& modes) {
  fmt::print("{:>5} {:>16} {:>14} {:>16}\n", "mode", "frequency [Hz]", "damping ratio", "real part [1/s]");
  for (std::size_t i = 0; i < modes.size(); ++i)
    fmt::print("{:>5} {:>16.9g} {:>14.6g} {:>16.9g}{}\n", i + 1, modes[i].frequency, modes[i].damping, modes[i].rate,
               modes[i].is_zero()      ? held_below(modes[i].error / (2 * std::numbers::pi))
               : modes[i].undetermined ? "  not determined"
                                       : std::string());
}

void write_modes(const std::filesystem::path& path, const mbd::System& system, const std::vector<mbd::Mode>& modes) {
  std::vector<SeriesColumn> columns{{"mode", "1"}, {"frequency", "Hz"}, {"damping ratio", "1"}, {"real part", "1/s"}};
  for (const auto& b : system.model().bodies)
    for (std::size_t k = 0; k < 3; ++k)
      for (const char* part : {".real", ".imaginary"})
        columns.push_back({b.name + "." + axes[k] + part, axis_units[k]});
  SeriesWriter out(path, columns, csv::exact_digits);
  std::vector<double> row;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const mbd::Mode& m = modes[i];
    row = {static_cast<double>(i + 1), m.frequency, m.damping, m.rate};
    for (Eigen::Index k = 0; k < system.coordinates(); ++k) {
      row.push_back(m.shape.size() ? m.shape[k].real() : 0.0);
      row.push_back(m.shape.size() ? m.shape[k].imag() : 0.0);
    }
    out.write(row);
  }
  out.flush();
}

/// A pose is no rest where what it leans on gives way at once: a joint whose event is due opens, friction reaches its
/// limit. Throws std::runtime_error where the bodies' mass times 1e-6 of gravity, or of the machine's length per s^2,
/// is unbalanced then, beyond what the equilibrium was found to. Of a towed machine the wheels' moments are left out,
/// which take no part in its balance.
void refuse_unrest(const mbd::Machine& machine, bool towed) {
  const mbd::System& system = machine.system();
  const mbd::Model& model = system.model();
  const Eigen::VectorXd scale = mbd::coordinate_scale(system);
  Eigen::VectorXd unbalanced =
      system.mass().cwiseProduct(machine.integrator().state().acceleration).cwiseQuotient(scale).cwiseAbs();
  for (Eigen::Index k = 2; towed && k < unbalanced.size(); k += 3) unbalanced[k] = 0;
  const double rate = std::hypot(model.gravity[0], model.gravity[1]) + system.length_scale();  // m/s^2
  Eigen::Index at = 0;
  if (unbalanced.size() == 0 ||
      unbalanced.maxCoeff(&at) <= 1e-6 * model.mass() * rate + 1e3 * machine.equilibrium()->residual)
    return;
  std::string why;
  for (const mbd::Event& e : machine.events()) why += fmt::format(", {} {}", e.name, e.word());
  throw std::runtime_error(fmt::format(
      "the pose found is no rest: there body '{}' is pushed by {:.3g} N (moments over the machine's length){}; what "
      "holds it gives way, or a driver accelerates it: look at friction's limits, at the events of joints and at "
      "drivers, or let it move, with `analysis: dynamics`",
      system.body_name(static_cast<int>(at / 3) + 1), unbalanced[at], why));
}

/// Springs whose free angle or length is left out are free where joints and drivers have closed, which is not the pose
/// of the file.
void warn_of_closed_pose(const mbd::Machine& machine, const MachineSection& section) {
  const double moved = machine.assembly().moved;
  if (moved <= 1e-6 * machine.system().length_scale()) return;
  std::vector<std::string> springs;
  for (const NamedForce& f : section.forces) {
    const auto* turned = f.element.get_if<mbd::RotationalSpringDamper>();
    const auto* pulled = f.element.get_if<mbd::SpringDamper>();
    const auto* bushing = f.element.get_if<mbd::Bushing>();
    const auto left_out = [](const auto* force, auto member) {
      return force != nullptr && std::isnan((*force).*member);
    };
    if (left_out(turned, &mbd::RotationalSpringDamper::free_angle) ||
        left_out(pulled, &mbd::SpringDamper::free_length) || left_out(bushing, &mbd::Bushing::free_angle))
      springs.push_back(f.name);
  }
  if (springs.empty()) return;
  spdlog::warn(
      "warning: joints and drivers close {:.3g} m beside the pose of the file (angles times the machine's length): {} "
      "{} free there; give the free lengths and angles, or a pose that closes",
      moved, fmt::join(springs, ", "), springs.size() > 1 ? "are" : "is");
}

/// What sticks holds poses nearby: an equilibrium far off may be on the other side of a contact.
void warn_of_far_pose(const Scenario& s, const mbd::Machine& machine) {
  constexpr double far_off = 0.1;  // of the machine's length
  const mbd::System& system = machine.system();
  if (!mbd::can_stick(system.model())) return;
  const Poses given = start_poses(s);
  Eigen::VectorXd way = Eigen::VectorXd::Zero(system.coordinates());
  for (std::size_t b = 1; b < given.size(); ++b) {  // what a beam is divided into follows behind
    const auto first = static_cast<Eigen::Index>(3 * (b - 1));
    const Eigen::Vector3d pose{given[b].r.x, given[b].r.y, given[b].angle};
    way.segment(first, 3) = machine.equilibrium()->q.segment(first, 3) - pose;
  }
  Eigen::Index at = 0;
  const double most = way.cwiseProduct(mbd::coordinate_scale(system)).cwiseAbs().maxCoeff(&at);
  if (most <= far_off * system.length_scale()) return;
  spdlog::warn(
      "warning: the equilibrium is {:.3g} m (angles times the machine's length) beside the pose given, of body '{}': "
      "what sticks does not hold it there, it has fallen, slid away or passed a contact; look at the pose, or let it "
      "move, with `analysis: dynamics`",
      most, system.body_name(static_cast<int>(at / 3) + 1));
}

/// Modes whose derivatives are not determined: a law has a corner at the state itself, or none.
void warn_of_undetermined(const mbd::Machine& machine, const std::vector<mbd::Mode>& modes) {
  const mbd::Equilibrium& at = *machine.equilibrium();
  std::vector<std::size_t> which;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (!modes[i].undetermined) continue;
    which.push_back(i + 1);
    for (const std::string& name :
         mbd::jumping(machine.system(), machine.time(), {at.q, at.velocity, at.lambda}, modes[i].shape.real()))
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  if (which.empty()) return;
  const bool many = names.size() > 1;
  const std::string why =
      names.empty() ? "a law has another slope on either side, as where a valve, stop or contact just closes: move the "
                      "state off it, by a load or by another pressure"
                    : fmt::format("{} jump{} or {} infinitely steep: {}", fmt::join(names, ", "), many ? "" : "s",
                                  many ? "are" : "is", mbd::smooth_force);
  spdlog::warn("warning: {} {} not determined: at the very state that was found {}",
               which.size() > 1 ? fmt::format("modes {}", fmt::join(which, ", ")) : fmt::format("mode {}", which[0]),
               which.size() > 1 ? "are" : "is", why);
}

/// Modes at a corner of a law, which has two stiffnesses there, and those that rounding hides.
void warn_of_uncertain(const std::vector<mbd::Mode>& modes) {
  constexpr double share = 1e-3;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const mbd::Mode& m = modes[i];
    const double size = std::hypot(2 * std::numbers::pi * m.frequency, m.rate);
    if (m.undetermined) continue;
    if (m.error_of_laws > share * size)
      spdlog::warn(
          "warning: mode {} is known to +-{:.2g} of itself only: a contact, stop or friction changes its law at the "
          "very state that was found, and has two stiffnesses there; load it a little, or take it away",
          i + 1, m.error_of_laws / size);
    else if (m.rounding > share * size)
      spdlog::warn(
          "warning: mode {} is known to +-{:.2g} of itself only: stiffnesses of the machine are so different that "
          "rounding in the largest one hides it; make the stiffest parts rigid, or divide beams into fewer elements",
          i + 1, m.rounding / size);
  }
}

/// One row: the columns of every run at the state that was found.
void write_state(const std::filesystem::path& path, const Loaded& loaded, World& world,
                 coupling::Simulation& simulation) {
  Columns columns(loaded, world, simulation);
  std::vector<double> row(columns.list().size(), 0.0);
  columns.take_instant(row);
  if (columns.has_means()) columns.take_step(row, false);  // nothing moves: the mean is the instant
  SeriesWriter out(path, columns.list(), csv::exact_digits);
  out.write(row);
  out.flush();
}

/// The pose as given at time 0, the one that was found at time 1.
void write_frames(FrameOutput& frames, const Scenario& s) {
  frames.write_poses(0, start_poses(s));
  frames.begin(1);
  frames.write(1, 0);
}

/// The first modes one after another, mode k over a period that the frames' time runs from k to k + 1. Those of a beam
/// of many elements go into the hundreds, and nobody watches them all.
void write_mode_frames(FrameOutput& frames, const Poses& rest, const std::vector<mbd::Mode>& modes) {
  constexpr int pieces = 24;
  constexpr std::size_t watched = 30;
  std::vector<double> shape(3 * (rest.size() - 1));
  if (modes.size() > watched) spdlog::info("frames show the first {} of {} modes", watched, modes.size());
  for (std::size_t k = 0; k < std::min(modes.size(), watched); ++k) {
    if (modes[k].shape.size() == 0) continue;
    const auto take = [&](double phase) {
      const std::complex<double> turn = std::polar(1.0, 2 * std::numbers::pi * phase);
      for (std::size_t i = 0; i < shape.size(); ++i)
        shape[i] = (modes[k].shape[static_cast<Eigen::Index>(i)] * turn).real();
    };
    take(0);
    const double factor = picture_factor(*frames.sketch(), rest, shape);
    for (int i = 0; i < pieces && factor > 0; ++i) {
      take(static_cast<double>(i) / pieces);
      frames.write_poses(static_cast<double>(k + 1) + static_cast<double>(i) / pieces, displaced(rest, shape, factor));
    }
  }
}

Poses poses_of(const mbd::Machine& machine) {
  Poses poses;
  for (int body = 0; body < machine.system().bodies(); ++body) poses.push_back(machine.body(body));
  return poses;
}

}  // namespace

int run_analysis(const Loaded& loaded, const RunRequest& request) {
  const Scenario& s = loaded.scenario;
  World world = build_world(loaded, {});
  mbd::Machine& machine = *world.machine;
  if (machine.equilibrium() && s.analysis != Analysis::assembly) {
    refuse_unrest(machine, s.machine->start.kind == StartKind::towing_equilibrium && s.machine->start.speed != 0);
    warn_of_closed_pose(machine, *s.machine);
    warn_of_far_pose(s, machine);
  }
  std::filesystem::create_directories(request.out);
  write_atomically(request.out / "scenario.yaml", write_scenario(s));
  coupling::Simulation simulation(nullptr, world.machine.get(), {}, {}, {.machine_step = world.step.machine_step});
  write_state(request.out / "series.csv", loaded, world, simulation);
  FrameOutput frames(request.out, s, world, simulation);
  const Poses found = poses_of(machine);
  if (s.analysis != Analysis::modes) write_frames(frames, s);

  Json summary;
  summary["run"] = {{"version", version()},
                    {"scenario", std::filesystem::absolute(request.scenario).string()},
                    {"title", s.title},
                    {"analysis", analysis_names[static_cast<std::size_t>(s.analysis)]},
                    {"end", "reached"}};
  if (!request.sets.empty()) summary["run"]["set"] = request.sets;
  summary["assembly"] = assembly_json(machine);
  if (s.analysis == Analysis::assembly)
    print_assembly(machine, summary["assembly"]);
  else
    summary["assembly"].erase("moved");  // an equilibrium has moved the bodies since
  if (machine.equilibrium() && s.analysis != Analysis::assembly) {
    const double speed = s.machine->start.kind == StartKind::towing_equilibrium ? s.machine->start.speed : 0;
    // The poses go out first: linearising moves the system about.
    const Json poses = equilibrium_json(machine, speed, {});
    const std::vector<mbd::Mode> modes = mbd::modes(machine.system(), machine.time(), *machine.equilibrium());
    summary["equilibrium"] = equilibrium_json(machine, speed, mbd::stability(modes));
    summary["equilibrium"]["pose"] = poses["pose"];
    print_equilibrium(summary["equilibrium"]);
    warn_of_undetermined(machine, modes);
    warn_of_uncertain(modes);
    if (s.analysis == Analysis::modes) {
      summary["modes"] = modes_json(machine.system(), modes);
      write_modes(request.out / "modes.csv", machine.system(), modes);
      write_mode_frames(frames, found, modes);
      print_modes(modes);
    }
  }
  frames.finish();
  write_atomically(request.out / "summary.json", json_text(summary, 2) + "\n");
  spdlog::info("done; results in {}", request.out.string());
  return exit_ok;
}

}  // namespace subsoil::sim
