#include "libsim/run/machine_fault.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "libmbd/assembly/assembly.hpp"
#include "libmbd/equilibrium/force_jumps.hpp"
#include "libsim/run/overlap_advice.hpp"
#include "libsim/setup/machine.hpp"

namespace subsoil::sim {
namespace {

/// "`torsion.moment` = 3.1e+06 N m", the largest column of a force element; empty without any.
std::string largest_force(const World& world, const Scenario& s, const mbd::Instant& at) {
  const std::vector<std::string>& names = world.machine->column_names();
  std::vector<double> values(names.size());
  world.machine->columns(at, values);
  std::size_t largest = names.size();
  for (std::size_t c = 0; c < names.size(); ++c) {
    const std::string& unit = world.machine->column_units()[c];
    if (unit != "N" && unit != "N m") continue;
    const bool of_force = std::any_of(s.machine->forces.begin(), s.machine->forces.end(), [&](const NamedForce& f) {
      return names[c] == f.name || names[c].starts_with(f.name + ".");
    });
    if (of_force && (largest == names.size() || std::abs(values[c]) > std::abs(values[largest]))) largest = c;
  }
  if (largest == names.size()) return {};
  return fmt::format("`{}` = {:.3g} {}", names[largest], values[largest], world.machine->column_units()[largest]);
}

/// What has put in all the energy that there is; empty where the balance does not close, so that nobody knows.
std::string fed_by(const World& world) {
  const mbd::Instant at = world.machine->now();
  const mbd::MachineEnergy e = world.machine->energy(at);
  const auto& forces = world.machine->system().model().forces;
  const auto count = static_cast<Eigen::Index>(forces.size());
  if (!(e.closure() <= most_closure)) return {};
  Eigen::Index i = 0;
  const double work = count > 0 ? at.flows.of_elements.segment(count, count).maxCoeff(&i) : 0;
  if (work > e.moved / 3)  // beside it the kinetic energy that it became
    return fmt::format("so it is the force: `{}` has put in {:.3g} J up to {:.6g} s",
                       forces[static_cast<std::size_t>(i)].name, work, at.state.t);
  return "so the steps resolve it: a stiffness or damping below zero, gravity or the speed of the start feeds it";
}

/// What jumps where the steps have collapsed, within a step of the last state; empty where nothing does.
std::string jump_advice(const World& world, double time) {
  const mbd::Instant at = world.machine->now();
  mbd::MotionState s = at.state;
  const double h = time - s.t;
  s.t = time, s.q += h * (s.velocity + 0.5 * h * s.acceleration), s.velocity += h * s.acceleration;
  std::vector<std::string> names;
  for (const Eigen::VectorXd& way : {s.velocity, s.acceleration}) {
    if (!(way.norm() > 0) || !way.allFinite()) continue;
    for (const std::string& name : mbd::jumping(at.system, s.t, {s.q, s.velocity, s.lambda}, way / way.norm()))
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  if (names.empty()) return {};
  return fmt::format("{} jump{} there, which no method resolves: {}", fmt::join(names, ", "),
                     names.size() > 1 ? "" : "s", mbd::smooth_force);
}

}  // namespace

std::string shorter_step(const Scenario& s, const World& world) {
  const MachineTime& machine = s.time.machine;
  if (world.bed) {
    const std::string step = fmt::format("give a `time.soil step` below {:.3g} s", world.step.soil_step);
    return machine.soil_steps > 1 ? step + ", or fewer `time.machine.soil steps per machine step`" : step;
  }
  if (machine.step) return "leave out `time.machine.step` to have it chosen by its error, or shorten it";
  const auto kind = integrator_of(s);
  if (kind == mbd::IntegratorKind::cvode || kind == mbd::IntegratorKind::ida)
    return "give a smaller `time.machine.rtol`";
  return fmt::format("give a `time.machine.step` below {:.3g} s", world.step.machine_step);
}

std::string finer_machine(const Scenario& s, const World& world) {
  const bool fixed = world.bed && integrator_of(s) == mbd::IntegratorKind::adams_moulton;
  return shorter_step(s, world) + (fixed ? ", or take `time.machine: {integrator: cvode}`" : "");
}

std::string machine_fault(const Scenario& s, const World& world) {
  return world.machine ? machine_fault(s, world, world.machine->now()) : std::string();
}

std::string machine_fault(const Scenario& s, const World& world, const mbd::Instant& at) {
  const mbd::MachineEnergy e = world.machine->energy(at);
  // A body at rest that is struck has moved by no more than a step at first: what its integrator errs by over that step
  // is a share of little. It can do no harm beyond what the soil brings, so the soil's energy counts as there.
  double brought = 0;
  if (world.bed) {
    const dem::BedEnergy& soil = world.bed->energy();
    brought = soil.kinetic + soil.rotational + std::abs(soil.stored);
  }
  const double off = std::abs(e.balance());
  if (e.closure() <= s.limits.energy || off <= s.limits.energy * (e.moved + brought)) return {};
  if (const std::vector<mbd::PartName> parts = mbd::contradicting_parts(at.system); !parts.empty())
    return fmt::format(
        "{}, so the energy balance of the machine is off by {:.3g} J; end the motion of the driver before "
        "the joint closes, let it agree with the joint, or open one of them",
        mbd::different_motions(parts), e.balance());
  const std::string force = s.machine ? largest_force(world, s, at) : std::string();
  return fmt::format(
      "the energy balance of the machine is off by {:.3g} J, {:.2g} of the {:.3g} J there or moved, "
      "above limits.energy = {:g}; the step is too long for the motion, or a driver or force jumps{}; {}, or raise the "
      "limit",
      e.balance(), off / (e.moved + brought), e.moved + brought, s.limits.energy,
      force.empty() ? std::string() : " (the maximum force is " + force + ")", finer_machine(s, world));
}

std::string step_failure(const std::exception& error, double t, const Scenario& scenario, const World& world) {
  const auto timed = [&](const std::string& text) { return fmt::format("t = {:.9g} s: {}", t, text); };
  // A machine that is not resolved throws the soil about.
  if (world.bed)
    if (const std::string fault = machine_fault(scenario, world); !fault.empty()) return timed(fault);
  const auto* const of_bed = dynamic_cast<const dem::BedFault*>(&error);
  const auto* const of_machine = dynamic_cast<const mbd::MotionFault*>(&error);
  std::string text = error.what();
  if (of_bed != nullptr)
    if (const std::string advice = overlap_advice(*of_bed, world, scenario); !advice.empty()) text += "; " + advice;
  using Cause = mbd::MotionFault::Cause;
  const Cause cause = of_machine != nullptr ? of_machine->cause : Cause::other;
  const std::string fed = cause == Cause::blow_up ? fed_by(world) : std::string();
  if (!fed.empty())
    text += "; the energy balance closes, " + fed;
  else if (cause != Cause::other)
    text += "; " + finer_machine(scenario, world);
  else if (of_machine != nullptr)
    if (const std::string advice = jump_advice(world, of_machine->time); !advice.empty()) text += "; " + advice;
  return of_bed != nullptr || of_machine != nullptr ? text : timed(text);  // these state their time
}

}  // namespace subsoil::sim
