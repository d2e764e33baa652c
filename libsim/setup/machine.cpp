#include "libsim/setup/machine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <string>

#include "libmbd/base/jumps.hpp"
#include "libmbd/controllers.hpp"
#include "libmbd/drivers/distance_driver.hpp"
#include "libmbd/forces/hydraulic_cylinder.hpp"
#include "libmbd/measures/control_input.hpp"
#include "libmbd/system/beam.hpp"
#include "libsim/document/expression.hpp"
#include "libsim/document/quantity.hpp"
#include "libsim/scenario/load.hpp"

namespace subsoil::sim {
namespace {

bool starts_in_equilibrium(const Scenario& s) {
  if (s.analysis == Analysis::assembly) return false;
  return s.machine->start.kind == StartKind::towing_equilibrium || s.analysis == Analysis::equilibrium ||
         s.analysis == Analysis::modes;
}

/// Where a part of the machine stands: libmbd knows names and no files.
std::string place_of(const Loaded& loaded, const mbd::PartName& part, const std::string& key) {
  using Kind = mbd::PartName::Kind;
  const auto in = [&](const char* section) {
    return loaded.where(std::string("machine.") + section + "." + part.name + (key.empty() ? "" : "." + key));
  };
  switch (part.kind) {
    case Kind::body:
      return in("bodies");
    case Kind::joint:
      return in("joints");
    case Kind::driver:
      return in("drivers");
    case Kind::force:
      return in("forces");
    case Kind::controller:
      return in("controllers");
    case Kind::event:
      return in("events");
    case Kind::machine:
      break;
  }
  return loaded.where("machine");
}

void add_measures(mbd::Machine& machine, const Loaded& loaded) {
  for (const NamedMeasure& m : loaded.scenario.machine->measures) {
    try {
      machine.measure(m.name, m.element);
    } catch (const std::invalid_argument& error) {
      throw ScenarioError(loaded.where("machine.measures." + m.name) + ": " + error.what());
    }
  }
}

mbd::JointEvent event_of(const MachineSection& m, const JointEventSection& e) {
  mbd::JointEvent event;
  event.does = e.opens.empty() ? mbd::JointEvent::Does::closes : mbd::JointEvent::Does::opens;
  event.joint = e.opens.empty() ? e.closes : e.opens;
  event.starts = e.starts;
  if (e.at) event.at = *e.at;
  if (e.reaction_above) event.reaction_above = *e.reaction_above;
  if (e.measure.empty()) return event;
  std::size_t place = 0;
  const NamedMeasure* measure = measure_of(m, e.measure, place);
  event.input = mbd::input_of(measure->element, place);
  const std::string unit = mbd::columns_of(measure->element)[place].unit;
  if (!e.above.empty()) event.above = parse_quantity(e.above, unit);
  if (!e.below.empty()) event.below = parse_quantity(e.below, unit);
  return event;
}

/// With the measures that it takes, and its formula as a function.
mbd::AnyController controller_of(const MachineSection& m, mbd::AnyController controller) {
  const std::vector<std::string> columns = measured_by(m, controller);
  visit(
      [&]<class Controller>(Controller& law) {
        std::vector<std::shared_ptr<mbd::ControllerInput>> inputs;
        for (const std::string& column : columns) {
          std::size_t place = 0;
          inputs.push_back(mbd::input_of(measure_of(m, column, place)->element, place));
        }
        if constexpr (requires { law.input; })
          law.input = inputs.front();
        else
          law.inputs = inputs;
        if constexpr (std::is_same_v<Controller, mbd::FormulaController>)
          law.names = columns, law.value = make_formula_of(law.text, columns);
      },
      controller);
  return controller;
}

/// Of a run with adams-moulton at its automatic step, in position over the machine's length and in velocity over the
/// maximum. Impacts one after the other magnify it a hundredfold at the most, to a tenth of what is warned of.
constexpr double automatic_step_error = 1e-6;
// Of cvode. Measured over the mechanisms of docs/verification/mechanisms.md: the looser 1e-8 saves a third of the time
// at most.
constexpr double cvode_tolerance = 1e-12;

int order_of(const Scenario& s) {
  const int order = static_cast<int>(s.time.machine.order.value_or(mbd::AdamsMoultonOptions{}.order));
  // Higher orders feed the fastest waves of a beam that is not damped.
  return s.machine->beams.empty() ? order : std::min(order, 2);
}

}  // namespace

double atol_of(const Scenario& s) {
  const mbd::IntegratorKind kind = integrator_of(s);
  if (kind == mbd::IntegratorKind::cvode) return s.time.machine.atol.value_or(cvode_tolerance);
  return kind == mbd::IntegratorKind::ida ? s.time.machine.atol.value_or(mbd::IdaOptions{}.atol) : cvode_tolerance;
}

double longest_machine_step(const Scenario& s, const mbd::Model& model) {
  if (s.machine->beams.empty()) return std::numeric_limits<double>::infinity();
  return mbd::longest_beam_step(model, order_of(s));
}

namespace {

// A driver of a distance has no direction where the distance is 0. Its motion is known ahead, from the start pose.
void refuse_vanishing_distances(const Loaded& loaded, const mbd::Model& model, const MachineStart& start) {
  constexpr int samples = 10000;  // a dip between two of them ends the run where it is met
  const Scenario& s = loaded.scenario;
  if (!s.runs_in_time()) return;
  for (const auto& driver : model.drivers) {
    const auto* const distance = driver.element.get_if<mbd::DistanceDriver>();
    // Behind a state, a rate may be another one, which begins at the length there.
    if (distance == nullptr || (start.begun_by != nullptr && !distance->motion.position.is_set())) continue;
    const double from = std::max(model.start_time, start.time);
    for (int k = 1; k <= samples; ++k) {
      const double t = from + (s.time.end - from) * k / samples;
      if (distance->motion.value(t) > 0) continue;
      throw ScenarioError(fmt::format(
          "{}: its motion brings the distance to 0 by t = {:.6g} s, where it has no direction; must stay above 0 until "
          "time.end = {} s: end the motion or the run before, or let the ends start farther apart",
          loaded.where("machine.drivers." + driver.name), t, s.time.end));
    }
  }
}

/// The table among the terms of f that begins or ends at t.
const mbd::TableFunction* table_with_end(const mbd::Function& f, double t) {
  constexpr double near = 1e-6;  // s
  if (const auto* sum = f.get_if<mbd::SumFunction>())
    for (const mbd::Function& term : sum->terms)
      if (const auto* found = table_with_end(term, t)) return found;
  const auto* table = f.get_if<mbd::TableFunction>();
  if (table == nullptr || table->periodic) return nullptr;
  return std::abs(table->times.back() - t) < near || std::abs(table->times.front() - t) < near ? table : nullptr;
}

/// The last step of a run may end behind time.end. A motion that is another one right there, such as a table that ends
/// in travel, or that has no value there, is extended: what is read within that step is of the motion until time.end.
void extend_motions(const Scenario& s, mbd::Model& model) {
  if (!s.runs_in_time() || !(s.time.end > model.start_time)) return;
  const double end = s.time.end, span = end - model.start_time;
  constexpr double longest_step = 0.1, rounding = 1e-9, smooth = 1e-6;  // of the run, of its end, of the change over it
  for (auto& driver : model.drivers)
    visit(
        [&](auto& d) {
          const mbd::Motion& m = d.motion;
          const double apart = rounding * std::max(std::abs(end), span);
          const auto changes = [&](double (mbd::Motion::*part)(double) const, double size) {
            try {
              // A smooth motion changes alike on both sides.
              const double before = (m.*part)(end - apart), now = (m.*part)(end), behind = (m.*part)(end + apart);
              return !(std::abs(behind - 2 * now + before) <= smooth * size);
            } catch (const std::exception&) {
              return true;  // a formula without a value
            }
          };
          // The value of a motion that is given as a rate begins with the start pose, which is not known yet.
          const double value = m.position.is_set() ? m.value(end) : 0;
          const double of_rate = std::abs(m.rate(end)) + std::abs(value) / span;
          const double of_second = std::abs(m.second(end)) + of_rate / span;
          if ((m.position.is_set() && changes(&mbd::Motion::value, std::abs(value))) ||
              changes(&mbd::Motion::rate, of_rate) || changes(&mbd::Motion::second, of_second))
            d.motion.extended_from = end, d.motion.extended_until = end + longest_step * span;
        },
        driver.element);
}

/// Whether f grows on as the instant of the jump is approached, in a run of that length: by a factor with each power of
/// 10 that it is nearer, which no corner does.
bool has_pole(const mbd::Function& f, const mbd::Jump& jump, double from, double length) {
  constexpr double factor = 5;
  const double side = jump.time - 1e-3 * length < from ? 1 : -1;  // before the run there may be no value
  const auto size = [&](double share) {
    const double t = jump.time + side * share * length;
    return std::abs(jump.of_rate ? f.first(t) : f.value(t));
  };
  return size(1e-4) > factor * size(1e-3) && size(1e-5) > factor * size(1e-4);
}

/// A body has a mass: what moves it has a continuous velocity. Integrators would step across a jump.
void refuse_velocity_jumps(const Loaded& loaded, const mbd::Model& model, const MachineStart& start) {
  const Scenario& s = loaded.scenario;
  if (!s.runs_in_time()) return;
  const double from = std::max(model.start_time, start.time), until = s.time.end;
  const auto refuse = [&](const std::string& path, const mbd::Function& f, const mbd::Jump& jump,
                          const std::string& unit) {
    const bool starts = jump.time - from < 1e-6;
    const std::string size =
        fmt::format("jumps by {:.4g} {} at t = {:.6g} s, from {:.4g} to {:.4g} {}", std::abs(jump.after - jump.before),
                    unit, jump.time, jump.before, jump.after, unit);
    if (has_pole(f, jump, from, until - from))
      throw ScenarioError(
          fmt::format("{}: grows without limit near t = {:.4g} s; take a function that is finite until "
                      "time.end = {:.6g} s, or end the run before",
                      loaded.where(path), jump.time, s.time.end));
    std::string cure = "let a `ramp` of some milliseconds lead from one to the other";
    if (const auto* table = table_with_end(f, jump.time))
      cure = std::abs(table->times.back() - jump.time) < 1e-6
                 ? fmt::format(
                       "the table ends there, and its last value holds from then on: give it points until "
                       "time.end = {:.6g} s, or, with `between: monotone`, the last value twice",
                       s.time.end)
                 : "the table begins there, and its first value holds until then: let it begin at the start of the "
                   "run, or, with `between: monotone`, give the first value twice";
    else if (jump.of_rate)
      cure = "give the velocity in its place, as a `ramp` or a table, or round the corner off";
    throw ScenarioError(fmt::format("{}: {}{}{}; a body has a mass, so its velocity must be continuous: {}",
                                    loaded.where(path), jump.of_rate ? "its rate " : "", size,
                                    starts ? ", right after the start" : "", cure));
  };
  for (const auto& driver : model.drivers)
    visit(
        [&]<class Driver>(const Driver& d) {
          const std::string path = "machine.drivers." + driver.name, unit = d.angular() ? "rad" : "m";
          // Kinematics asks for poses, which have corners; a corner costs no force there.
          const bool poses_alone = s.analysis == Analysis::kinematics;
          const mbd::Smooth wanted = poses_alone ? mbd::Smooth::value : mbd::Smooth::value_and_rate;
          if (const auto jump = first_jump(d.motion.position, wanted, from, until))
            refuse(path + ".position", d.motion.position, *jump, jump->of_rate ? unit + "/s" : unit);
          if (poses_alone) return;
          if (const auto jump = first_jump(d.motion.velocity, mbd::Smooth::value, from, until))
            refuse(path + ".velocity", d.motion.velocity, *jump, unit + "/s");
        },
        driver.element);
}

/// Lets drivers move as the scenario that began the run says, so that the start pose is that of the state's run;
/// returns their own motions.
std::vector<mbd::Motion> take_motions(mbd::Model& model, const MachineSection& begun_by) {
  std::vector<mbd::Motion> own;
  for (auto& driver : model.drivers)
    visit(
        [&]<class Driver>(Driver& d) {
          own.push_back(d.motion);
          for (const NamedDriver& before : begun_by.drivers)
            if (const auto* const same = before.element.get_if<Driver>(); before.name == driver.name && same != nullptr)
              d.motion = same->motion;
        },
        driver.element);
  return own;
}

}  // namespace

std::unique_ptr<mbd::Machine> build_machine(const Loaded& loaded, const MachineStart& start) {
  const Scenario& s = loaded.scenario;
  if (!s.machine) return nullptr;
  mbd::Model model;
  model.gravity = {s.gravity.x, s.gravity.y};
  for (const BodySection& b : s.machine->bodies)
    model.add({.name = b.name,
               .mass = b.mass,
               .inertia = b.inertia,
               .pose = {b.at[0], b.at[1], b.angle},
               .velocity = {b.velocity[0], b.velocity[1], b.spin},
               .pose_is = b.pose_is,
               .velocity_is = b.velocity_is});
  model.redundancy = s.machine->redundant;
  for (const NamedJoint& j : s.machine->joints) model.add(j.name, j.element);
  for (const NamedDriver& d : s.machine->drivers) model.add(d.name, d.element);
  for (const NamedForce& f : s.machine->forces) model.add(f.name, f.element);
  for (const NamedController& c : s.machine->controllers) model.add(c.name, controller_of(*s.machine, c.element));
  for (const JointEventSection& e : s.machine->events) model.add(e.name, event_of(*s.machine, e));
  const MachineTime& time = s.time.machine;
  mbd::MachineOptions options;
  options.integrator = integrator_of(s);
  options.adams_moulton.order = order_of(s);
  // Both sides agree on the motion under a constant wrench: it must be that motion, on stiff contacts too.
  if (s.time.coupling == CouplingWord::iterated) options.adams_moulton.wrench_jump = mbd::WrenchJump::restart;
  options.adams_moulton.longest_step = longest_machine_step(s, model);
  // A step that is given, or made of soil steps, is kept; of a beam's waves nothing is seen.
  if (!time.step && !s.has_bed() && s.machine->beams.empty() && s.runs_in_time())
    options.adams_moulton.error_per_second = automatic_step_error / s.time.end;
  options.ida.rtol = time.rtol.value_or(options.ida.rtol), options.ida.atol = time.atol.value_or(options.ida.atol);
  options.ida.formulation = time.formulation;
  options.cvode.rtol = time.rtol.value_or(cvode_tolerance), options.cvode.atol = time.atol.value_or(cvode_tolerance);
  options.locate_events = time.locate_events;
  options.assemble = s.machine->assemble;
  extend_motions(s, model);
  std::vector<mbd::Motion> motions;
  const bool continues = start.begun_by != nullptr && start.begun_by->machine;
  if (continues) motions = take_motions(model, *start.begun_by->machine);
  options.hold_start = s.runs_in_time();  // the other analyses are there to find a pose
  try {
    auto machine = std::make_unique<mbd::Machine>(std::move(model), options);
    add_measures(*machine, loaded);
    if (!continues) refuse_velocity_jumps(loaded, machine->system().model(), start);
    if (starts_in_equilibrium(s))
      machine->start_from_towing_equilibrium(s.machine->start.speed);
    else
      machine->start_from_pose();
    for (std::size_t i = 0; i < motions.size(); ++i) machine->system().set_motion(i, motions[i]);
    if (continues) refuse_velocity_jumps(loaded, machine->system().model(), start);
    refuse_vanishing_distances(loaded, machine->system().model(), start);
    return machine;
  } catch (const ScenarioError&) {
    throw;
  } catch (const std::runtime_error& error) {
    if (!s.runs_in_time()) throw;  // the input is good; the analysis did not come to an end
    throw ScenarioError(loaded.where("machine") + ": " + error.what());
  } catch (const mbd::ModelFault& fault) {
    throw ScenarioError(place_of(loaded, fault.of, fault.key) + ": " + fault.what());
  } catch (const std::exception& error) {
    throw ScenarioError(loaded.where("machine") + ": " + error.what());
  }
}

}  // namespace subsoil::sim
